# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Finds the rows of a relaxed fabric whose stitches are too wide or too narrow, too high or too low.

The stretch of course sides measures the width of stitches, and the stretch of wale sides their height. The unit is the
geometric mean of both over the fabric, because the rest lengths follow from the area of the whole surface. If the mean
width of a row differs from the unit by more than ``ALLOWED_RATIO``, the row has too few or too many stitches for its
place. If its mean height differs, there are too few or too many rows at this place.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.arrays import runs_of
from stitchmesh.reporting.verdict import Finding, Kind, Verdict

ALLOWED_RATIO = 1.2
"""Largest mean size of the stitches of a row over the average size of the fabric, and largest inverse, with which the
row still has the right number of stitches."""
Direction = Literal["width", "height"]
_KINDS: dict[tuple[bool, bool], Kind] = {
    (True, True): "too few stitches", (False, True): "too many stitches",
    (True, False): "too few rows", (False, False): "too many rows",
}  # fmt: skip
"""Kind of a finding, by two facts: whether there are too few, and whether the width is wrong."""
Measure = Literal["size", "width", "height"]
"""Which sides of a stitch are measured: all, the course sides, or the wale sides."""


@dataclass(frozen=True)
class UnevenRows:
    """Consecutive rows whose stitches are too large or too small in one direction."""

    first: int
    """Number of the first row."""
    last: int
    """Number of the last row."""
    direction: Direction
    """Whether the width or the height of the stitches is wrong."""
    ratio: float
    """Mean width or height of the stitches over the average of the fabric."""
    stitches: float
    """Mean number of stitches in each of the rows."""

    @property
    def missing(self) -> int:
        """Number of stitches to add to each row, or of rows to add, to make the rows even; negative to remove some."""
        count = self.stitches if self.direction == "width" else self.last - self.first + 1
        missing = round(count * (self.ratio - 1.0))
        return missing or (1 if self.ratio > 1.0 else -1)

    def finding(self) -> Finding:
        """Return what is wrong, and how many stitches or rows would help."""
        few, wide = self.ratio > 1.0, self.direction == "width"
        alone = self.first == self.last
        rows = f"row {self.first} is" if alone else f"rows {self.first} to {self.last} are"
        state, measure = "stretched" if few else "crowded", "wide" if wide else "high"
        text = f"{rows} {state}, {self.ratio:.2f} times as {measure} as the average"
        count, act = abs(self.missing), "add" if few else "leave out"
        things = _counted("stitch", "stitches", count) if wide else _counted("row", "rows", count)
        where = "" if alone or not wide else " in each"
        return Finding(_KINDS[few, wide], text, f"{act} about {things}{where}")


def _counted(one: str, several: str, count: int) -> str:
    return f"{count} {one if count == 1 else several}"


def uneven_rows(fabric: StitchMesh) -> list[UnevenRows]:
    """Return the bands of rows with too few or too many stitches or rows, the most uneven band first.

    Args:
        fabric: stitch mesh after mesh relaxation.

    Raises:
        ParameterError: the fabric has no stretch.
    """
    course, wale = _row_stretch(fabric, wale=False), _row_stretch(fabric, wale=True)
    unit = _unit(fabric)
    counts = np.bincount(fabric.row)
    ratios: dict[Direction, FloatArray] = {"width": course / unit, "height": wale / unit}
    bands = []
    for direction, ratio in ratios.items():
        for first, beyond in runs_of(ratio > ALLOWED_RATIO) + runs_of(ratio < 1.0 / ALLOWED_RATIO):
            mean_ratio, count = float(ratio[first:beyond].mean()), float(counts[first:beyond].mean())
            bands.append(UnevenRows(first, beyond - 1, direction, mean_ratio, count))
    return sorted(bands, key=lambda band: -abs(np.log(band.ratio)))


def evenness_verdict(fabric: StitchMesh) -> Verdict:
    """Return whether a fabric has the right numbers of stitches and rows everywhere.

    Args:
        fabric: stitch mesh after mesh relaxation.

    Raises:
        ParameterError: the fabric has no stretch.
    """
    bands = uneven_rows(fabric)
    stretch = _known_stretch(fabric)[fabric.side_edge]
    size = stretch[np.isfinite(stretch)] / _unit(fabric)
    even = float(np.mean((size < ALLOWED_RATIO) & (size > 1.0 / ALLOWED_RATIO)))
    praise = f"{100.0 * even:.0f} % of the sides of stitches are within 20 % of the average"
    return Verdict(tuple(band.finding() for band in bands), praise)


def relative_sizes(fabric: StitchMesh, measure: Measure = "size") -> FloatArray:
    """Return the size of each stitch over the average of the fabric, shape (F,); NaN where it is not known.

    Args:
        fabric: stitch mesh after mesh relaxation.
        measure: the mean of all sides of a stitch, its width or its height.

    Raises:
        ParameterError: the fabric has no stretch.
    """
    stretch = _known_stretch(fabric)[fabric.side_edge]
    chosen = np.isfinite(stretch)
    if measure != "size":
        chosen &= fabric.is_wale == (measure == "height")
    return _means(fabric.side_face[chosen], stretch[chosen], fabric.face_count) / _unit(fabric)


def _known_stretch(fabric: StitchMesh) -> FloatArray:
    """Return the stretch of each edge, shape (E,)."""
    if fabric.stretch is None:
        raise ParameterError("stretch: the stitch mesh has none; relax the mesh first")
    return fabric.stretch


def _unit(fabric: StitchMesh) -> float:
    """Return the geometric mean of the mean stretches of course sides and of wale sides."""
    stretch = _known_stretch(fabric)[fabric.side_edge]
    means = [np.nanmean(stretch[part]) for part in (fabric.is_wale, ~fabric.is_wale)]
    return float(np.sqrt(means[0] * means[1]))


def _row_stretch(fabric: StitchMesh, *, wale: bool) -> FloatArray:
    """Return the mean stretch of the wale sides or of the course sides of each row, NaN if none is known."""
    stretch = _known_stretch(fabric)[fabric.side_edge]
    chosen = (fabric.is_wale == wale) & np.isfinite(stretch)
    return _means(fabric.row[fabric.side_face[chosen]], stretch[chosen], int(fabric.row.max()) + 1)


def _means(group: IntArray, values: FloatArray, groups: int) -> FloatArray:
    """Return the mean of the values of each group, shape (groups,); NaN for a group without values."""
    count = np.bincount(group, minlength=groups)
    total = np.bincount(group, weights=values, minlength=groups)
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)
