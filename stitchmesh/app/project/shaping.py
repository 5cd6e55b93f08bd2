# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The search for rows and stitches on a mesh without labels, as a value that JSON can hold."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from stitchmesh.io.checked import check_table
from stitchmesh.mesh import Mesh, StitchMesh
from stitchmesh.mesh.shaping_stitches import DEFAULT_INCREASE, Increase
from stitchmesh.progress import Progress, no_progress
from stitchmesh.shaping.marks import TimeMark
from stitchmesh.shaping.options import ShapingOptions
from stitchmesh.tessellate import COURSE_OVER_WALE_SPACING, STITCH_WIDTH

if TYPE_CHECKING:
    from stitchmesh.shaping.auto_stitches import ShapedFabric

Point = tuple[float, float, float]
"""A place or a direction in space; places in cm."""


@dataclass(frozen=True, kw_only=True)
class Shaping(ShapingOptions):
    """The options with which rows and stitches are found on a mesh, and the size of the stitches.

    Raises:
        ParameterError: an error of ``ShapingOptions``.
    """

    stitch_width: float = STITCH_WIDTH
    """Wale spacing [cm]."""
    stitch_height: float | None = None
    """Course spacing [cm]; None for 0.77 times the stitch width."""
    increase: Increase = DEFAULT_INCREASE
    """How increases are made: ``m1``, ``kfb``, ``lifted`` or ``yo``."""
    marks: tuple[TimeMark, ...] = ()
    """Where knitting begins and ends, lines along which rows run, and plain places."""

    @property
    def height(self) -> float:
        """Course spacing [cm]."""
        return COURSE_OVER_WALE_SPACING * self.stitch_width if self.stitch_height is None else self.stitch_height

    def shape(self, mesh: Mesh, progress: Progress = no_progress) -> ShapedFabric:
        """Find rows and stitches on a mesh.

        Raises:
            StitchMeshError: an error of ``shape_fabric``.
        """
        from stitchmesh.shaping.auto_stitches import shape_fabric

        return shape_fabric(
            mesh, stitch_width=self.stitch_width, stitch_height=self.stitch_height, increase=self.increase,
            options=self, progress=progress,
        )  # fmt: skip


@dataclass(frozen=True, eq=False)
class ShapedStitches:
    """Stitches that were found on a mesh, before all edits, and the options that found them."""

    shaping: Shaping
    """The options that found the stitches."""
    fabric: StitchMesh
    """The stitches."""


def shaping_table(shaping: Shaping) -> dict[str, Any]:
    """Return a shaping as a table for JSON."""
    marks = [mark_table(mark) for mark in shaping.marks]
    return {**vars(shaping), "up": list(shaping.up), "marks": marks}


def mark_table(mark: TimeMark) -> dict[str, Any]:
    """Return a mark as a table for JSON."""
    points = [[float(number) for number in point] for point in mark.points]
    table = {"kind": mark.kind, "points": points, "role": mark.role, "time": mark.time}
    return table if mark.radius is None else {**table, "radius": mark.radius}


def shaping_of(table: object) -> Shaping:
    """Return the shaping from a table of ``shaping_table``.

    Raises:
        ParameterError: the table has another form.
    """
    return check_table(table, Shaping)


def plain_mark(mark: TimeMark) -> TimeMark:
    """Return a mark whose points are tuples of numbers, so that equal marks compare equal."""
    points = tuple(tuple(float(number) for number in point) for point in mark.points)
    return replace(mark, points=points)
