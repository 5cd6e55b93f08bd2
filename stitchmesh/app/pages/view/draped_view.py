# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A run of mixed yarns and triangles in the scene: frame by frame, and as a sketch while a large run goes on.

A sketch is drawn in a small part of a second: the triangles without subdivision, and some of the simulated yarns, as
straight lines from node to node. The whole picture needs the curves of all yarns.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stitchmesh.app.controls.controls import Controls
from stitchmesh.app.pages.view.thing_view import EDGES, NAME, ClipBox, Place
from stitchmesh.app.scene.drawing import Colour, Colours, Lines, Surface, YarnTubes
from stitchmesh.app.scene.mesh_drawing import BODY_COLOUR, plain_surface
from stitchmesh.app.scene.scene import DrawingScene
from stitchmesh.mesh import FloatArray, IntArray, Mesh, StitchMesh
from stitchmesh.mesh.palette import colours_of, empty_palette, parse_colour
from stitchmesh.mesh.picking import pick as pick_face
from stitchmesh.mesh.picking import picking_table
from stitchmesh.mixed.assembly import LoadedBody, bodies_at
from stitchmesh.mixed.drape import Draped
from stitchmesh.mixed.enrichment.region import TRIANGLES, YARNS, Region
from stitchmesh.mixed.layout.spline_yarns import LaidYarns, SplineYarns
from stitchmesh.mixed.output.display import Display, Shown
from stitchmesh.mixed.output.frames import DrapeFrame
from stitchmesh.render.colour_scale import ColourScale, sequential_scale
from stitchmesh.render.colouring import Coloured, colour_yarns
from stitchmesh.render.draped.colouring import ALPHA_SCALE, LEAST_TENSION, DrapedValues, nodes_at_points
from stitchmesh.render.yarn_blocks import YarnBlocks, make_blocks
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.picking import pick_yarn, yarn_picking_table

SURFACE = "viewed surface"
"""Name of the drawing of the triangles."""
BODIES = "viewed bodies"
"""Name of the drawing of the bodies."""
CLOTH_COLOUR: Colour = (214, 208, 196)
BODY_OPACITY = 0.4
"""Opacity of bodies, because they may stand in front of the cloth."""
THICKNESS = 4.0
"""Thickness of the cloth over the radius of its yarns; a yarn within it belongs to the triangle in front of it."""
KINDS = ("triangles are simulated", "triangles and yarns are simulated", "yarns are simulated")
"""What is simulated in a triangle, by its kind."""


class DrapedView:
    """One frame of a run."""

    def __init__(
        self, draped: Draped, before: object = None, *, frame: int | None = None, everywhere: bool = False
    ) -> None:
        """Prepare a frame.

        Args:
            draped: the run.
            before: the view of another frame; its structure is used again if it belongs to the same run.
            frame: number of the frame; the last one by default.
            everywhere: whether to draw all yarns and no triangles.
        """
        self.draped, self.everywhere = draped, everywhere
        self.frame: DrapeFrame = draped.frames[-1 if frame is None else frame]
        self.shown: Shown = draped.shown_at(self.frame)
        self.display: Display = draped.display_of(self.frame)
        self.yarns: YarnSet = self.display.curves(self.shown, draped.prepared.fabric.yarn_radius, measured=False)
        self._of_yarns, self.coloured_count = len(self.yarns.points), len(self.yarns.points) + len(self.shown.surface)
        known = before if isinstance(before, DrapedView) and before.display is self.display else None
        self.node: IntArray = nodes_at_points(draped, self.frame, self.yarns) if known is None else known.node
        self._blocks: tuple[ClipBox | None, bool, YarnBlocks | None] | None = None if known is None else known._blocks
        self._triangles: tuple[ClipBox | None, IntArray] | None = None if known is None else known._triangles

    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """Return the box of the cloth."""
        return self.shown.vertices.min(axis=0), self.shown.vertices.max(axis=0)

    def figures(self) -> list[tuple[str, str]]:
        """Return the time, and the numbers of nodes and vertices."""
        region = self.display.region
        kinds = [int((region.node_kind == kind).sum()) for kind in (TRIANGLES, 1, YARNS)]
        size = " x ".join(f"{side:.1f}" for side in np.ptp(self.shown.vertices, axis=0))
        return [
            ("Time", f"{self.frame.time:.4g} of {self.draped.prepared.scene.duration:.4g} s"),
            ("Frames", f"{len(self.draped.frames):,}"),
            ("Yarn nodes, simulated", f"{kinds[2]:,}"), ("Yarn nodes, hybrid", f"{kinds[1]:,}"),
            ("Yarn nodes that follow", f"{kinds[0]:,}"), ("Triangles", f"{len(region.triangles):,}"),
            ("Size", f"{size} cm"),
        ]  # fmt: skip

    def is_slow(self, colour: str) -> bool:
        """Return False: the colours are quick."""
        return False

    def coloured(self, colour: str, fabric: StitchMesh | None, body: Mesh | None) -> Coloured:
        """Return the colours of the control points, followed by those of the vertices of the surface."""
        values = DrapedValues(self.draped, self.frame, self.node)
        if colour == "alpha":
            return self._scaled(*values.alpha(), ALPHA_SCALE, "alpha")
        if colour == "cloth-tension":
            found = values.cloth_tension()
            return self._scaled(*found, sequential_scale(np.concatenate(found), LEAST_TENSION, low=0.0), "dyn/cm")
        if colour == "yarn-tension":
            tension = values.yarn_tension()
            return self._on_plain_cloth(self._scaled(
                tension, None, sequential_scale(tension, LEAST_TENSION, low=0.0), "dyn"
            ))  # fmt: skip
        if colour.startswith("#"):
            return Coloured(np.tile(parse_colour(colour), (self.coloured_count, 1)))
        found_colours = colour_yarns(self.yarns, "yarn")
        return self._on_plain_cloth(Coloured(found_colours.points, found_colours.key))

    def draw(self, scene: DrawingScene, colours: NDArray[np.uint8], clip: ClipBox | None) -> None:
        """Draw the yarns and the surface inside the box, and the bodies."""
        scene.remove(EDGES)
        self._draw_yarns(scene, colours[: self._of_yarns], clip)
        self._draw_surface(scene, colours[self._of_yarns :], clip)
        draw_bodies(scene, self.draped.prepared.bodies, self.frame.time)

    def clear(self, scene: DrawingScene) -> None:
        """Remove the drawings."""
        scene.remove(NAME)
        scene.remove(SURFACE)
        remove_bodies(scene, self.draped.prepared.bodies)

    def pick(self, origin: FloatArray, direction: FloatArray, fabric: StitchMesh | None) -> Place | None:
        """Return the place on the cloth under a ray, and the yarn there if yarns are drawn."""
        region, cloth = self.display.region, self.draped.prepared.fabric.cloth
        mesh = Mesh.from_polygons(self.shown.vertices, region.triangles.tolist())
        met = pick_face(picking_table(mesh), origin, direction)
        if met is None:
            return None
        words = f"Triangle {met.face} of {cloth.panel_names[cloth.panel[met.face]]}"
        words = f"{words}: {KINDS[int(region.triangle_kind[met.face])]}"
        yarn = pick_yarn(yarn_picking_table(self.yarns), origin, direction)
        if yarn is None or yarn.depth > met.depth + THICKNESS * float(self.yarns.radius.max()):
            return Place(met.point, words)
        return Place(yarn.point, f"{words}. Yarn {yarn.yarn}", yarn)

    def stitch(self, number: int, fabric: StitchMesh | None) -> Place | None:
        """Return the middle of a triangle."""
        triangles = self.display.region.triangles
        if not 0 <= number < len(triangles):
            return None
        kind = KINDS[int(self.display.region.triangle_kind[number])]
        return Place(self.shown.vertices[triangles[number]].mean(axis=0), f"Triangle {number}: {kind}")

    def _draw_yarns(self, scene: DrawingScene, colours: NDArray[np.uint8], clip: ClipBox | None) -> None:
        if self._blocks is None or self._blocks[:2] != (clip, self.everywhere):
            segments = self._segments(clip)
            self._blocks = clip, self.everywhere, make_blocks(self.yarns, segments) if len(segments) else None
        blocks = self._blocks[2]
        scene.show(NAME, None if blocks is None else YarnTubes(blocks, self.yarns.points, colours))

    def _draw_surface(self, scene: DrawingScene, colours: NDArray[np.uint8], clip: ClipBox | None) -> None:
        if self._triangles is None or self._triangles[0] != clip:
            self._triangles = clip, self._inside(clip)
        corners = self._triangles[1]
        if self.everywhere or not len(corners):
            scene.remove(SURFACE)
        else:
            scene.show(SURFACE, Surface(self.shown.surface, corners, Colours.of(colours), flat=False))

    def _segments(self, clip: ClipBox | None) -> IntArray:
        """Return the segments to draw: the simulated ones, or all, inside the box."""
        middle = self.yarns.segment_points[:, 1:3]
        drawn = np.ones(len(middle), dtype=bool)
        if not self.everywhere:
            drawn = (self.display.region.node_kind[self.node][middle] != TRIANGLES).all(axis=1)
        if clip is not None:
            drawn &= clip.inside(self.yarns.points[middle].mean(axis=1))
        return np.flatnonzero(drawn)

    def _inside(self, clip: ClipBox | None) -> IntArray:
        corners = self.display.triangles
        return corners if clip is None else corners[clip.inside(self.shown.surface[corners].mean(axis=1))]

    def _scaled(self, points: FloatArray, surface: FloatArray | None, scale: ColourScale, unit: str) -> Coloured:
        values = points if surface is None else np.concatenate([points, surface])
        form = ",.0f" if scale.high >= 1000.0 else ".3g"
        return Coloured(scale.of(values), scale.key(lambda value: f"{value:{form}} {unit}"), scale)

    def _on_plain_cloth(self, of_yarns: Coloured) -> Coloured:
        """Return the colours of the yarns, with one colour for the surface."""
        plain = np.tile(np.array(CLOTH_COLOUR, dtype=np.uint8), (len(self.shown.surface), 1))
        return replace(of_yarns, points=np.concatenate([of_yarns.points, plain]))


def draw_bodies(scene: DrawingScene, bodies: Sequence[LoadedBody], time: float, name: str = BODIES) -> None:
    """Draw bodies at their places at a time [s]; the cloth shows through them."""
    for number, mesh in enumerate(bodies_at(bodies, time)):
        scene.show(f"{name} {number}", plain_surface(mesh, BODY_COLOUR, flat=False, opacity=BODY_OPACITY))


def remove_bodies(scene: DrawingScene, bodies: Sequence[LoadedBody]) -> None:
    """Remove the drawings of bodies."""
    for number in range(len(bodies)):
        scene.remove(f"{BODIES} {number}")


NEWEST = 100.0
"""Place of the newest frame on the slider [%]."""
BACK, ON, LAST = "Frame before", "Next frame", "Newest"
"""Labels of the buttons."""


class FramePanel:
    """Chooses a frame; the end of the slider shows the newest frame, also of a run in progress."""

    def __init__(self, controls: Controls, changed: Callable[[], object]) -> None:
        """Make the controls, hidden; ``changed`` is called when another frame or yarns must be drawn."""
        self._draped: Draped | None = None
        self._changed = changed
        self._moment = controls.slider(
            "Moment", "Part of the frames of the run [%]; at 100 the newest frame is followed.", NEWEST,
            lambda _: self._changed(), least=0.0, most=NEWEST, step=0.5,
        )  # fmt: skip
        self._steps = controls.buttons("Frames", "One frame back or on, or the newest.", (BACK, ON, LAST), self._step)
        self._everywhere = controls.toggle(
            "Yarns everywhere", "Draw all yarns and no triangles.", False, lambda _: self._changed()
        )
        self.show(None)

    @property
    def frame(self) -> int:
        """Number of the chosen frame."""
        count = 1 if self._draped is None else len(self._draped.frames)
        return min(round(float(self._moment.value) / NEWEST * (count - 1)), count - 1)

    def show(self, draped: Draped | None) -> None:
        """Show the controls for a run; None hides them."""
        self._draped = draped
        many = draped is not None and len(draped.frames) > 1
        self._moment.visible = self._steps.visible = many
        self._everywhere.visible = draped is not None

    def view(self, draped: Draped, before: object = None) -> DrapedView:
        """Return the view of the chosen frame of a run, and make it the visible one."""
        self.show(draped)
        return DrapedView(draped, before, frame=self.frame, everywhere=bool(self._everywhere.value))

    def _step(self, which: str) -> None:
        if self._draped is None:
            return
        last = len(self._draped.frames) - 1
        frame = {BACK: self.frame - 1, ON: self.frame + 1, LAST: last}[which]
        self._moment.value = NEWEST * min(max(frame, 0), last) / max(last, 1)
        self._changed()


LINES = "sketched yarns"
"""Name of the drawing of the yarns."""
LARGE = 40_000
"""A run in progress is sketched if its cloth has more yarn nodes than this."""
MOST_LINES = 20_000
"""Largest number of lines of a sketch."""
PIECE = 64
"""Number of passages in a piece of yarn; a cloth with few yarns shows some of the pieces."""
WORDS = "A large run is sketched while it goes on; a pause or its end shows it whole."


@dataclass(frozen=True, eq=False)
class SketchLines:
    """The lines of one region."""

    region: Region
    """The region."""
    node: IntArray
    """The simulated nodes at both ends of each line, shape (n, 2)."""
    yarn: IntArray
    """Yarn of each line, shape (n,)."""

    @classmethod
    def of(cls, yarns: LaidYarns, region: Region) -> SketchLines:
        """Choose the lines: every k-th yarn, or every k-th piece if there are few yarns."""
        number = region.node_number[yarns.yarn_node]
        yarn = np.repeat(np.arange(len(yarns.yarn_start) - 1), np.diff(yarns.yarn_start))
        joined = np.flatnonzero((yarn[1:] == yarn[:-1]) & (number[1:] >= 0) & (number[:-1] >= 0))
        every = -(-len(joined) // MOST_LINES)
        if every > 1:
            few = len(np.unique(yarn[joined])) < 2 * every
            joined = joined[(joined // PIECE if few else yarn[joined]) % every == 0]
        return cls(region, np.stack([number[joined], number[joined + 1]], axis=1), yarn[joined])


class DrapedSketch:
    """The newest state of a run in progress."""

    def __init__(self, draped: Draped, before: object = None) -> None:
        """Prepare the state; an earlier sketch of the same region is used again."""
        self.draped, self.frame = draped, draped.end
        region, yarns = draped.prepared.region, draped.prepared.fabric.yarns
        known: SketchLines | None = before.lines if isinstance(before, DrapedSketch) else None
        self.lines: SketchLines
        self.lines = known if known is not None and known.region is region else SketchLines.of(yarns, region)

    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """Return the box of the cloth."""
        return self.frame.vertices.min(axis=0), self.frame.vertices.max(axis=0)

    def draw(self, scene: DrawingScene, *, alpha: bool) -> None:
        """Draw the lines, the triangles outside the region, and the bodies, in colours of alpha or of the yarns."""
        frame, region = self.frame, self.lines.region
        corners = region.triangles[frame.triangle_kind != YARNS]
        plain = np.tile(np.array(CLOTH_COLOUR, dtype=np.uint8), (len(frame.vertices), 1))
        colours = ALPHA_SCALE.of(frame.vertex_alpha) if alpha else plain
        scene.show(SURFACE, Surface(frame.vertices, corners, Colours.of(colours), flat=False))
        scene.show(LINES, Lines(frame.nodes[self.lines.node], self._line_colours(alpha=alpha), 1.5))
        draw_bodies(scene, self.draped.prepared.bodies, frame.time)

    def clear(self, scene: DrawingScene) -> None:
        """Remove the drawings."""
        scene.remove(LINES)
        scene.remove(SURFACE)
        remove_bodies(scene, self.draped.prepared.bodies)

    def _line_colours(self, *, alpha: bool) -> NDArray[np.uint8]:
        """Return the colours of the ends of the lines, shape (n, 2, 3)."""
        if alpha:
            region = self.lines.region
            found: NDArray[np.uint8] = ALPHA_SCALE.of(region.node_alpha[region.nodes][self.lines.node.ravel()])
            return found.reshape(-1, 2, 3)
        yarns = self.draped.prepared.fabric.yarns
        colour = yarns.curves.colour if isinstance(yarns, SplineYarns) else yarns.yarn_family
        of_lines = colours_of(colour[self.lines.yarn], empty_palette())
        return np.repeat(of_lines[:, None], 2, axis=1)
