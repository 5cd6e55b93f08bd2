# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The drawing of the yarns of a garment: tubes in colours, pinned stitches and the body."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray

from stitchmesh.app.controls.html_pieces import LegendEntry, legend
from stitchmesh.app.pages.view.thing_view import SLOW_COLOURS
from stitchmesh.app.scene.drawing import YarnTubes, point_marks
from stitchmesh.app.scene.mesh_drawing import BODY_COLOUR, draw_plainly, plain_surface, remove_plain
from stitchmesh.app.scene.scene import DrawingScene
from stitchmesh.markup import Markup
from stitchmesh.mesh import FloatArray, Mesh, StitchMesh
from stitchmesh.render.colouring import Coloured, colour_yarns
from stitchmesh.render.yarn_blocks import YarnBlocks, make_blocks
from stitchmesh.yarn import YarnSet

COLOURINGS = {
    "Yarn": "yarn", "Row": "row", "Stitch": "stitch", "Strain": "strain", "Stretch of stitches": "stretch",
    "Contact force": "contact", "Distance of yarns": "distance",
}  # fmt: skip
"""What the colours can show, by the words of the user."""
MOVING = ("strain",)
"""Colours that change while the yarns move, and that are quick enough to follow them."""


class GarmentYarnView:
    """Draws moving yarns, with the same structure in every frame."""

    def __init__(self, scene: DrawingScene, colouring: str = "Yarn") -> None:
        """Draw nothing yet."""
        self._scene, self.colouring = scene, colouring
        self._fabric: StitchMesh | None = None
        self._yarns: YarnSet | None = None
        self._blocks: YarnBlocks | None = None
        self._coloured: Coloured | None = None

    @property
    def yarns(self) -> YarnSet | None:
        """The visible yarns."""
        return self._yarns

    def show(self, yarns: YarnSet, fabric: StitchMesh | None, *, moving: bool = False) -> None:
        """Draw the yarns of a fabric; slow colours stay as they are while the yarns are moving."""
        if self._yarns is None or not np.array_equal(self._yarns.start, yarns.start):
            self._blocks = self._coloured = None
        if self._yarns is None:
            remove_plain(self._scene)
        self._yarns, self._fabric = yarns, fabric
        if self._blocks is None:
            self._blocks = make_blocks(yarns)
        if not moving and self.is_slow(self.colouring):
            self.colouring, self._coloured = "Yarn", None
        if self._coloured is None or not moving or COLOURINGS[self.colouring] in MOVING:
            self._coloured = self._colours(yarns, fabric)
        self._scene.show("yarns", YarnTubes(self._blocks, yarns.points, self._coloured.points))

    def show_stitches(self, fabric: StitchMesh) -> None:
        """Draw the stitches; their yarns will replace them."""
        draw_plainly(self._scene, fabric)

    def set_colouring(self, colouring: str) -> None:
        """Show other colours."""
        self.colouring, self._coloured = colouring, None
        if self._yarns is not None:
            self.show(self._yarns, self._fabric)

    def is_slow(self, colouring: str) -> bool:
        """Return whether colours of the visible yarns take long to find."""
        return self._yarns is not None and len(self._yarns.points) > SLOW_COLOURS.get(COLOURINGS[colouring], np.inf)

    def colouring_work(self, colouring: str) -> Callable[[], Coloured]:
        """Return a function that finds colours of the visible yarns; any thread may call it."""
        assert self._yarns is not None
        return partial(colour_yarns, self._yarns, COLOURINGS[colouring], fabric=self._fabric)

    def take_colours(self, colouring: str, coloured: Coloured) -> None:
        """Show colours that were found for the visible yarns."""
        if self._yarns is not None and self._blocks is not None and len(coloured.points) == len(self._yarns.points):
            self.colouring, self._coloured = colouring, coloured
            self._scene.show("yarns", YarnTubes(self._blocks, self._yarns.points, coloured.points))

    def legend(self) -> Markup:
        """Return the legend of the colours as HTML; nothing if they need none."""
        if self._coloured is None or not self._coloured.key:
            return Markup()
        return legend([LegendEntry(text, (colour,)) for text, colour in self._coloured.key])

    def show_pins(self, faces: Sequence[int]) -> None:
        """Mark the pinned stitches."""
        if self._yarns is None:
            self._scene.remove("pins")
            return
        centres = stitch_centres(self._yarns, np.asarray(faces, dtype=int))
        size = 3.0 * float(self._yarns.drawn_radius.mean())
        self._scene.show("pins", point_marks(centres, size, (230, 120, 0)))

    def show_body(self, body: Mesh | None) -> None:
        """Draw the body; None removes it."""
        self._scene.show("body", None if body is None else plain_surface(body, BODY_COLOUR, opacity=0.75))

    def look_at_all(self) -> None:
        """Show the whole garment."""
        if self._yarns is not None:
            self._scene.look_at(self._yarns.points.min(axis=0), self._yarns.points.max(axis=0))

    def _colours(self, yarns: YarnSet, fabric: StitchMesh | None) -> Coloured:
        found = colour_yarns(yarns, COLOURINGS[self.colouring], fabric=fabric)
        # The scene sends colours only if they are another object.
        if self._coloured is not None and np.array_equal(self._coloured.points, found.points):
            return Coloured(self._coloured.points, found.key)
        return found


def stitch_centres(yarns: YarnSet, faces: NDArray[np.int64]) -> FloatArray:
    """Return the mean of the control points of some stitches [cm], shape (n, 3); stitches without yarn are left out."""
    chosen = np.flatnonzero(np.isin(yarns.face, faces))
    known, index = np.unique(yarns.face[chosen], return_inverse=True)
    count = np.bincount(index, minlength=len(known))
    total = [np.bincount(index, weights=yarns.points[chosen, axis], minlength=len(known)) for axis in range(3)]
    centres: FloatArray = np.stack(total, axis=1) / count[:, None]
    return centres
