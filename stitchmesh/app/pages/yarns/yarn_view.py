# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The yarns of a garment in the scene, while they move and at rest, with pinned stitches and the body."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray

from stitchmesh.app.controls.html_pieces import legend_of_key
from stitchmesh.app.pages.view.thing_view import YARN_COLOURS, YarnView
from stitchmesh.app.scene.drawing import point_marks
from stitchmesh.app.scene.mesh_drawing import BODY_COLOUR, plain_surface, remove_plain
from stitchmesh.app.scene.scene import DrawingScene
from stitchmesh.markup import Markup
from stitchmesh.mesh import FloatArray, Mesh, StitchMesh
from stitchmesh.render.colouring import Coloured
from stitchmesh.yarn import YarnSet

COLOURINGS = {words: name for words, name in YARN_COLOURS.items() if name not in ("body-distance", "")}
"""What the colours can show, by the words of the user."""
PLAIN = next(iter(COLOURINGS))
"""The colours at first."""


class GarmentYarnView:
    """Draws moving yarns, with the same structure in every frame."""

    def __init__(self, scene: DrawingScene, colouring: str = PLAIN) -> None:
        """Draw nothing yet."""
        self._scene, self.colouring = scene, colouring
        self._fabric: StitchMesh | None = None
        self.view: YarnView | None = None
        """The visible yarns; None before there are any."""
        self._coloured: Coloured | None = None

    def show(self, yarns: YarnSet, fabric: StitchMesh | None, *, moving: bool = False) -> None:
        """Draw the yarns of a fabric; colours that are slow, or do not change with the motion, stay as they are."""
        before = self.view
        if before is None:
            remove_plain(self._scene)
        if before is None or not np.array_equal(before.yarns.start, yarns.start):
            self._coloured = None
        self.view, self._fabric = YarnView(yarns, before), fabric
        if not moving and self.is_slow(self.colouring):
            self.colouring, self._coloured = PLAIN, None
        if self._coloured is None or not moving or COLOURINGS[self.colouring] == "strain":
            self._coloured = self._same_if_equal(self.view.coloured(COLOURINGS[self.colouring], fabric, None))
        self.view.draw(self._scene, self._coloured.points, None)

    def set_colouring(self, colouring: str) -> None:
        """Show other colours."""
        self.colouring, self._coloured = colouring, None
        if self.view is not None:
            self.show(self.view.yarns, self._fabric)

    def is_slow(self, colouring: str) -> bool:
        """Return whether colours of the visible yarns take long to find."""
        return self.view is not None and self.view.is_slow(COLOURINGS[colouring])

    def colouring_work(self, colouring: str) -> Callable[[], Coloured]:
        """Return a function that finds colours of the visible yarns; any thread may call it."""
        assert self.view is not None
        return partial(self.view.coloured, COLOURINGS[colouring], self._fabric, None)

    def take_colours(self, colouring: str, coloured: Coloured) -> None:
        """Show colours that were found for the visible yarns."""
        if self.view is not None and len(coloured.points) == self.view.coloured_count:
            self.colouring, self._coloured = colouring, coloured
            self.view.draw(self._scene, coloured.points, None)

    def legend(self) -> Markup:
        """Return the legend of the colours as HTML; nothing if they need none."""
        return legend_of_key(self._coloured.key) if self._coloured is not None and self._coloured.key else Markup()

    def show_pins(self, faces: Sequence[int]) -> None:
        """Mark the pinned stitches."""
        if self.view is None:
            self._scene.remove("pins")
            return
        yarns = self.view.yarns
        centres = stitch_centres(yarns, np.asarray(faces, dtype=int))
        self._scene.show("pins", point_marks(centres, 3.0 * float(yarns.drawn_radius.mean()), (230, 120, 0)))

    def show_body(self, body: Mesh | None) -> None:
        """Draw the body; None removes it."""
        self._scene.show("body", None if body is None else plain_surface(body, BODY_COLOUR, opacity=0.75))

    def look_at_all(self) -> None:
        """Show the whole garment."""
        if self.view is not None:
            self._scene.look_at(*self.view.bounds())

    def _same_if_equal(self, found: Coloured) -> Coloured:
        """Return colours with the array of the earlier ones if nothing in it has changed, so that it is not sent."""
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
