# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A state of a large run in progress, in few lines and triangles, which are drawn in a small part of a second.

The triangles of the cloth are drawn without subdivision. Only some of the simulated yarns are drawn, as straight lines
from node to node. The whole picture (``draped_view``) needs the curves of all yarns.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stitchmesh.app.pages.view.draped_view import CLOTH_COLOUR, SURFACE, draw_bodies, remove_bodies
from stitchmesh.app.scene.drawing import Colours, Lines, Surface
from stitchmesh.app.scene.scene import DrawingScene
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mesh.palette import colours_of, empty_palette
from stitchmesh.mixed.drape import Draped
from stitchmesh.mixed.enrichment.region import YARNS, Region
from stitchmesh.mixed.layout.spline_yarns import LaidYarns, SplineYarns
from stitchmesh.render.draped.colouring import ALPHA_SCALE

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
