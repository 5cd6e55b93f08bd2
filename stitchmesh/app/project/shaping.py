# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How rows and stitches are found on a mesh without labels, as a value that JSON can hold."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from stitchmesh.errors import ParameterError
from stitchmesh.io.checked import check_table
from stitchmesh.mesh import Mesh, StitchMesh
from stitchmesh.progress import Progress, no_progress
from stitchmesh.shaping.marks import TimeMark, marks_from
from stitchmesh.tessellate import COURSE_OVER_WALE_SPACING, STITCH_WIDTH

if TYPE_CHECKING:
    from stitchmesh.shaping.auto_stitches import ShapedFabric

Point = tuple[float, float, float]
"""A place or a direction in space; places in cm."""
UP: Point = (0.0, 1.0, 0.0)
"""Direction in which garments stand."""


@dataclass(frozen=True, kw_only=True)
class Shaping:
    """The sizes, marks and choices with which rows and stitches are found on a mesh.

    Raises:
        ParameterError: the multiple is no positive number.
    """

    stitch_width: float = STITCH_WIDTH
    """Wale spacing [cm]."""
    stitch_height: float | None = None
    """Course spacing [cm]; None for 0.77 times the stitch width."""
    marks: tuple[TimeMark, ...] = ()
    """Where knitting begins and ends, lines along which rows run, and plain places."""
    up: Point = UP
    """Direction in which the garment is knitted where nothing else decides."""
    multiple: int = 1
    """Number that the stitches of each round are a multiple of."""

    def __post_init__(self) -> None:
        if self.multiple < 1:
            raise ParameterError(f"multiple: got {self.multiple}; expected 1 or more stitches")

    @property
    def height(self) -> float:
        """Course spacing [cm]."""
        return COURSE_OVER_WALE_SPACING * self.stitch_width if self.stitch_height is None else self.stitch_height

    def shape(self, mesh: Mesh, progress: Progress = no_progress) -> ShapedFabric:
        """Find rows and stitches on a mesh.

        Raises:
            StitchMeshError: as for ``shape_fabric``.
        """
        from stitchmesh.shaping.auto_stitches import shape_fabric

        return shape_fabric(
            mesh, stitch_width=self.stitch_width, stitch_height=self.stitch_height, marks=self.marks, up=self.up,
            multiple=self.multiple, progress=progress,
        )  # fmt: skip


@dataclass(frozen=True, eq=False)
class ShapedStitches:
    """Stitches that were found on a mesh, before all edits, and how they were found."""

    shaping: Shaping
    """How they were found."""
    fabric: StitchMesh
    """The stitches."""


@dataclass(frozen=True, kw_only=True)
class _Table:
    """A shaping as JSON holds it."""

    stitch_width: float
    stitch_height: float | None
    marks: tuple[dict[str, Any], ...]
    up: tuple[float, float, float]
    multiple: int


def shaping_table(shaping: Shaping) -> dict[str, Any]:
    """Return a shaping as JSON can hold it."""
    return {
        "stitch_width": shaping.stitch_width,
        "stitch_height": shaping.stitch_height,
        "marks": [mark_table(mark) for mark in shaping.marks],
        "up": list(shaping.up),
        "multiple": shaping.multiple,
    }


def mark_table(mark: TimeMark) -> dict[str, Any]:
    """Return a mark as JSON can hold it."""
    points = [[float(number) for number in point] for point in mark.points]
    table = {"kind": mark.kind, "points": points, "role": mark.role, "time": mark.time}
    return table if mark.radius is None else {**table, "radius": mark.radius}


def shaping_of(table: object) -> Shaping:
    """Return the shaping of a table that ``shaping_table`` made.

    Raises:
        ParameterError: the table has another form.
    """
    found = check_table(table, _Table)
    return Shaping(
        stitch_width=found.stitch_width, stitch_height=found.stitch_height, up=found.up, multiple=found.multiple,
        marks=tuple(plain_mark(mark) for mark in marks_from(found.marks)),
    )  # fmt: skip


def plain_mark(mark: TimeMark) -> TimeMark:
    """Return a mark whose points are tuples of numbers, so that equal marks compare equal."""
    points = tuple(tuple(float(number) for number in point) for point in mark.points)
    return replace(mark, points=points)
