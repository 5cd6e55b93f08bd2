# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The variants of a swatch: a design, the session that relaxes it, its frames, and their drawing in the scene."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence

import numpy as np

from stitchmesh.app.event_queue import EventQueue
from stitchmesh.app.pages.swatch.state import Look
from stitchmesh.app.scene.drawing import Copies, Labels
from stitchmesh.app.scene.scene import DrawingScene
from stitchmesh.app.task import FRAME_SECONDS
from stitchmesh.errors import ParameterError
from stitchmesh.mesh import FloatArray
from stitchmesh.patterns import Pattern, parse_pattern
from stitchmesh.periodic.session.frames import Frame
from stitchmesh.periodic.session.session import SwatchSession
from stitchmesh.periodic.swatch_design import SwatchDesign
from stitchmesh.render.colouring import colour_yarns
from stitchmesh.render.lettering import Colour
from stitchmesh.render.tile_drawing import TileDrawing, draw_tiles

URGENT_FRAMES = 6
"""Number of frames after a change that do not wait for the time of the next frame: frames that the session was already
making, the newly drawn yarns, and their first movements."""


class FrameWatcher:
    """Delivers the frames of a session in a thread of its own, until the session is closed."""

    def __init__(self, session: SwatchSession, queue: EventQueue, deliver: Callable[[Frame], object]) -> None:
        """Start to watch.

        Args:
            session: the session; its present frame is not delivered.
            queue: the queue that calls ``deliver``.
            deliver: called with each frame; a waiting frame is dropped when a newer one arrives.
        """
        self.seconds = FRAME_SECONDS
        """Shortest time between two frames [s]."""
        self._session, self._queue, self._deliver = session, queue, deliver
        self._urgent = threading.Event()
        threading.Thread(target=self._watch, args=(session.frame.number,), name="frames", daemon=True).start()

    def hurry(self) -> None:
        """Deliver the next frames without delay, because the user has changed something."""
        self._urgent.set()

    def _watch(self, seen: int) -> None:
        hurried = 0
        while (frame := self._session.wait_for_frame(after=seen)) is not None:
            seen = frame.number
            self._queue.post_newest((id(self), "frame"), self._deliver, frame)
            if hurried == 0 and self._urgent.wait(self.seconds):
                hurried = URGENT_FRAMES + 1
            self._urgent.clear()
            hurried = max(hurried - 1, 0)


PLAIN = parse_pattern("round 1: k1")
"""Pattern with which a session begins. The design then follows as a change. An impossible design is therefore an error
of a frame, and the event thread does not wait for the generation of a large design."""
MOST_STITCHES = 10_000
"""Largest number of stitches of a chart that is relaxed live; a frame of this size takes a second on one core."""


class Variant:
    """A variant of the swatch. All methods belong to the event thread."""

    def __init__(
        self, name: str, queue: EventQueue, iterations: int, stopped: bool, deliver: Callable[[Variant, Frame], object]
    ) -> None:
        """Start a session that relaxes nothing yet.

        Args:
            name: name of the variant.
            queue: the queue of the event thread.
            iterations: number of iterations from one frame to the next.
            stopped: whether the yarns wait for ``start`` or ``step``.
            deliver: called with the variant and each of its frames.
        """
        self.name = name
        self.frame: Frame | None = None
        """The newest frame of the design; None before the first one."""
        self.drawing: TileDrawing | None = None
        """The drawing of the newest frame in the scene."""
        self.legend: tuple[tuple[str, Colour], ...] = ()
        """Names and colours of the legend of the drawing; empty if it has the colours of the yarns."""
        self.design: SwatchDesign | None = None
        """The design to which the session moves; None before the first change."""
        self.refusal: str | None = None
        """Why the design is not relaxed; None if it is relaxed."""
        self.session = SwatchSession(PLAIN, quality="draft", stopped=True, iterations_per_frame=iterations)
        self._stopped = stopped
        self._watcher = FrameWatcher(self.session, queue, lambda frame: deliver(self, frame))

    @property
    def stopped(self) -> bool:
        """Whether the yarns wait for ``start`` or ``step``."""
        return self._stopped

    def change(self, design: SwatchDesign) -> None:
        """Move to another design; start from the present state if the yarns are the same."""
        self._watcher.hurry()
        self.design = design
        try:
            check_size(design)
        except ParameterError as error:
            self.refusal = str(error)
            self.session.stop()
            return
        self.refusal = None
        self.session.set(**design.settings())
        if not self._stopped:
            self.session.start()

    def start(self) -> None:
        """Let the yarns relax."""
        self._stopped = False
        self._watcher.hurry()
        self.session.start()

    def stop(self) -> None:
        """Stop the relaxation."""
        self._stopped = True
        self.session.stop()

    def step(self) -> None:
        """Relax for one frame; a running session stops."""
        self._stopped = True
        self._watcher.hurry()
        self.session.request_steps()

    def restart(self) -> None:
        """Return to the yarns as they were generated."""
        self._watcher.hurry()
        self.session.restart()

    def draw(self, frame: Frame, look: Look) -> TileDrawing:
        """Take a frame, and return its drawing."""
        self.frame = frame
        fabric = frame.fabric
        by = look.colour_by if fabric is not None else "yarn"
        coloured = colour_yarns(frame.yarns, by, fabric=fabric, blend=look.blend)
        self.legend = coloured.key
        self.drawing = draw_tiles(frame.yarns, (look.columns, look.rows), colours=coloured.points, before=self.drawing)
        return self.drawing

    def slow_down(self, seconds: float) -> None:
        """Leave at least this time between two frames [s]."""
        self._watcher.seconds = seconds

    def close(self) -> None:
        """End the session."""
        self.session.close()


def check_size(design: SwatchDesign) -> None:
    """Check that a design is small enough to relax live.

    Raises:
        ParameterError: it has more than ``MOST_STITCHES`` stitches.
    """
    source, dials = design.pattern, design.dials
    if isinstance(source, Pattern):
        stitches = source.width * source.height * dials.columns * dials.rows
    else:
        stitches = len(source.wefts) * len(source.warps)
    if stitches > MOST_STITCHES:
        found = f"swatch: got a repeat of {stitches:,} stitches; expected at most {MOST_STITCHES:,} to relax live"
        raise ParameterError(f"{found}; make the chart smaller, or relax it with the command swatch")


AXIS = np.array([1.0, 0.0, 0.0])
"""Direction from one variant to the next."""
NAMES_OF_VARIANTS = "names of variants"
"""Name of the drawing of the labels."""
ABOVE = 0.07
"""Height of the labels above the fabric, and of the space above them, over the larger side of the picture."""
REFIT = 1.3
"""The camera is placed again after the fabric has grown or shrunk by this factor."""


class FabricDrawing:
    """Shows drawings of variants by the names of their parts."""

    def __init__(self, scene: DrawingScene) -> None:
        """Start with an empty scene."""
        self._scene = scene
        self._parts: dict[Variant, int] = {}
        self._box: tuple[FloatArray, FloatArray] | None = None
        self._fitted: FloatArray | None = None
        self._named: FloatArray | None = None
        self._settling = True

    def show(self, variants: Sequence[Variant]) -> None:
        """Show the drawings of all variants that have one."""
        drawings = [(variant, variant.drawing) for variant in variants if variant.drawing is not None]
        if not drawings:
            return
        places = _places([drawing for _, drawing in drawings])
        for (variant, drawing), place in zip(drawings, places, strict=True):
            self._show_one(variant, drawing, place)
        self._label([(variant.name, drawing) for variant, drawing in drawings], places)
        self._fit([drawing for _, drawing in drawings], places)

    def remove(self, variant: Variant) -> None:
        """Remove the drawing of a variant."""
        for number in range(self._parts.pop(variant, 0)):
            self._scene.remove(_name(variant, number))

    def _show_one(self, variant: Variant, drawing: TileDrawing, place: float) -> None:
        offsets = drawing.offsets + (place * AXIS).astype(np.float32)
        for number, part in enumerate(drawing.parts):
            self._scene.show(_name(variant, number), Copies(part.vertices, part.triangles, part.colour, offsets))
        for number in range(len(drawing.parts), self._parts.get(variant, 0)):
            self._scene.remove(_name(variant, number))
        self._parts[variant] = len(drawing.parts)

    def _label(self, drawings: Sequence[tuple[str, TileDrawing]], places: Sequence[float]) -> None:
        """Name the variants if there are two."""
        if len(drawings) < 2:
            self._named = None
            return self._scene.remove(NAMES_OF_VARIANTS)
        low, high = _bounds([drawing for _, drawing in drawings], places)
        room = ABOVE * float((high - low).max())
        points = np.array([[place, high[1] + room, 0.0] for place in places])
        # A browser that gets a label with every frame shows none of them.
        if self._named is None or np.abs(points - self._named).max() > 0.5 * room:
            self._named = points
            self._scene.show(NAMES_OF_VARIANTS, Labels(points, tuple(name for name, _ in drawings)))

    def expect_other_size(self) -> None:
        """Place the camera again when the fabric is at rest, because the user has chosen another pattern."""
        self._settling = True

    def fit_next(self) -> None:
        """Place the camera at the next drawing, because the number of copies or variants has changed."""
        self._fitted = None

    def fit_at_rest(self) -> None:
        """Place the camera for the size of the fabric at rest, once after a change of the pattern."""
        if self._settling and self._box is not None:
            self._settling = False
            self._place_camera(self._box)

    def _fit(self, drawings: Sequence[TileDrawing], places: Sequence[float]) -> None:
        """Place the camera if the size of the fabric has changed much since it was placed last."""
        low, high = _bounds(drawings, places)
        if len(drawings) > 1:
            high = high + np.array([0.0, 2.0 * ABOVE * float((high - low).max()), 0.0])
        self._box = low, high
        size = (high - low)[:2]
        if self._fitted is None or not (size / self._fitted < REFIT).all() or not (self._fitted / size < REFIT).all():
            self._place_camera(self._box)

    def _place_camera(self, box: tuple[FloatArray, FloatArray]) -> None:
        low, high = box
        self._fitted = (high - low)[:2]
        self._scene.look_at(low, high)


def _places(drawings: Sequence[TileDrawing]) -> list[float]:
    """Return the middle of each fabric along x [cm]; between two fabrics, the middle of the gap lies at 0."""
    if len(drawings) == 1:
        return [0.0]
    half = [float(drawing.high[0]) for drawing in drawings]
    gap = 0.12 * max(half)
    return [-half[0] - gap, half[1] + gap]


def _bounds(drawings: Sequence[TileDrawing], places: Sequence[float]) -> tuple[FloatArray, FloatArray]:
    """Return the smallest and the largest coordinates of all fabrics [cm], shape (3,) each."""
    moves = np.stack([place * AXIS for place in places])
    low: FloatArray = (np.stack([drawing.low for drawing in drawings]) + moves).min(axis=0)
    high: FloatArray = (np.stack([drawing.high for drawing in drawings]) + moves).max(axis=0)
    return low, high


def _name(variant: Variant, number: int) -> str:
    return f"fabric {id(variant)} {number}"
