# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The fabric of one variant, or of two side by side, in the scene."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stitchmesh.app.pages.swatch.variant import Variant
from stitchmesh.app.scene.drawing import Copies, Labels
from stitchmesh.app.scene.scene import DrawingScene
from stitchmesh.mesh import FloatArray
from stitchmesh.render.tile_drawing import TileDrawing

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
