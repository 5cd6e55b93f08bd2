# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Numbers of stitches and courses with which a size comes true, and patterns run around in whole repeats.

``tessellate`` rounds the number of stitches of each edge by itself, and the number of courses of each row of panels.
The errors of a ring of equal edges, or of many rows, add up. Here whole rings and whole lengths are rounded:

- A ring of course edges beside rounds that a pattern covers has the nearest multiple of the width of the pattern. If
  the rings of one pattern would differ by less than a repeat, they have one number, so that no shaping cuts a repeat.
- If an asked girth is missed by more than ``ALLOWED``, every other ring has the nearest multiple of 4, 2 or 1 that is
  close enough to its length. Multiples of 4 keep a garment symmetric.
- Rows of an asked length get or lose single courses, first those whose number was rounded the other way most, until
  their total is the nearest one.

Edges of a ring keep the numbers of the ring below where they can, so that few stitches are shaped between them.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from stitchmesh.editing.pattern_regions import PatternRegion
from stitchmesh.mesh import BORDER, BOTTOM, TOP, FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.courses import right_neighbours
from stitchmesh.recipe.garment_measures import GarmentMeasures, Girth, row_heights
from stitchmesh.selection import select
from stitchmesh.tessellate import COURSE_OVER_WALE_SPACING
from stitchmesh.tessellate.planned_stitches import PlannedStitches, planned_stitches
from stitchmesh.tessellate.tessellate import tessellate

EdgeCounts = dict[tuple[int, int], int]
"""Numbers of stitches or courses of edges, each named by its two vertices."""
ALLOWED = 0.02
"""Relative error of a girth that is left as it is."""
MULTIPLES = (4, 2, 1)
"""Numbers of which a ring without a pattern has a multiple, the preferred ones first."""
ROUNDED = 0.5
"""Stitches by which whole numbers differ from the length of a ring in any case."""
TIE = 1e-6
"""Stitches by which edges differ if one of them is to come first."""


@dataclass(frozen=True)
class _Ring:
    """The course edges between two closed rows of panels, or at the end of one, from left to right."""

    edges: tuple[int, ...]
    ends: tuple[tuple[int, bool], ...]
    """The rows of panels that it ends, each with whether it is at the top of the row."""


def size_counts(
    measures: GarmentMeasures, labeled: StitchMesh, wanted: Iterable[str], regions: Sequence[PatternRegion], *,
    stitch_width: float, stitch_height: float | None = None,
) -> EdgeCounts:  # fmt: skip
    """Return the numbers of stitches of course edges, and of courses of wale edges, that differ from ``tessellate``.

    Args:
        measures: the measures of the base size.
        labeled: the labeled mesh of a size, with the same sides.
        wanted: names of the asked measures, which the mesh has.
        regions: the patterns and their parts of the fabric.
        stitch_width: wale spacing [cm].
        stitch_height: course spacing [cm]; by default as in ``tessellate``.

    Raises:
        StitchMeshError: as for ``tessellate`` and ``select``.
    """
    height = COURSE_OVER_WALE_SPACING * stitch_width if stitch_height is None else stitch_height
    natural = planned_stitches(labeled, stitch_width=stitch_width, stitch_height=height)
    courses = _course_counts(measures, labeled, wanted, natural, height)
    planned = planned_stitches(labeled, stitch_width=stitch_width, stitch_height=height, counts=dict(courses))
    rings = _rings(labeled)
    missed = any(_is_missed(measures, labeled, name, planned, stitch_width) for name in wanted)
    asked = _asked_edges(measures, labeled, wanted)
    totals = _pattern_totals(labeled, rings, regions, planned, courses, (stitch_width, height), asked)
    if missed:
        length = labeled.side_length[labeled.edge_side]
        for ring in rings:
            totals.setdefault(ring, _near(float(length[list(ring.edges)].sum()) / stitch_width))
    return courses | _ring_counts(labeled, rings, totals, planned.along)


def _is_missed(
    measures: GarmentMeasures, labeled: StitchMesh, name: str, planned: PlannedStitches, stitch_width: float
) -> bool:
    """Whether a girth is missed by more than ``ALLOWED``."""
    measure = measures.measure(name)
    if not isinstance(measure, Girth):
        return False
    loops = np.mean([planned.along[labeled.side_edge[ring]].sum() for ring in measure.rings])
    return abs(float(loops) * stitch_width / measures.value(name, labeled) - 1.0) > ALLOWED


def _asked_edges(measures: GarmentMeasures, labeled: StitchMesh, wanted: Iterable[str]) -> frozenset[int]:
    """The edges of the rings of asked girths."""
    girths = [measure for measure in map(measures.measure, wanted) if isinstance(measure, Girth)]
    return frozenset(edge for girth in girths for ring in girth.rings for edge in labeled.side_edge[ring].tolist())


def _near(loops: float) -> int:
    """Return the nearest multiple of one of ``MULTIPLES`` that is close enough to a number."""
    for multiple in MULTIPLES:
        total = max(multiple, multiple * math.floor(loops / multiple + 0.5))
        if abs(total / loops - 1.0) <= ALLOWED:
            return total
    return max(1, math.floor(loops + 0.5))


def _course_counts(
    measures: GarmentMeasures, labeled: StitchMesh, wanted: Iterable[str], planned: PlannedStitches, height: float
) -> EdgeCounts:
    """Return the numbers of courses of the rows that change, each by a wale edge of the row."""
    ideal = row_heights(labeled, measures.row_index) / height
    first = np.unique(measures.row_index, return_index=True)[1]
    own = planned.courses[first].copy()
    for name in wanted:
        measure = measures.measure(name)
        if isinstance(measure, Girth):
            continue
        for tube in measure.tubes:
            part = np.ones(len(ideal)) if measure.part is None else measure.part
            rows = [row for row in tube if part[row] > 0.5]
            missing = float(part[list(tube)] @ (ideal - own)[list(tube)]) / float(np.mean(part[rows]))
            own[rows] = _with_courses(ideal[rows], own[rows], math.floor(missing + 0.5))
    changed = np.flatnonzero(own != planned.courses[first]).tolist()
    edges = labeled.side_edge[labeled.left_wale[first[changed]]].tolist()
    return {edge_name(labeled, edge): int(own[row]) for edge, row in zip(edges, changed, strict=True)}


def _with_courses(ideal: FloatArray, counts: IntArray, missing: int) -> IntArray:
    """Return numbers of courses with some more or less, which are as near to others as possible; each is at least 1."""
    counts = counts.copy()
    for _ in range(abs(missing)):
        step = 1 if missing > 0 else -1
        gain = step * (ideal - counts)
        gain[counts + step < 1] = -np.inf
        counts[int(np.argmax(np.round(gain, 6)))] += step
    return counts


def _rings(labeled: StitchMesh) -> list[_Ring]:
    """All rings of course edges, the lowest first; each starts at the place above the start of the ring below."""
    after = right_neighbours(labeled)
    found: dict[frozenset[int], _Ring] = {}
    start_of: dict[int, int] = {}
    for row in np.unique(labeled.row).tolist():
        faces = np.flatnonzero(labeled.row == row)
        if (after[faces] == BORDER).any():
            continue
        start = _above(labeled, start_of, row, int(faces[0]))
        ordered = [start]
        while int(after[ordered[-1]]) != start:
            ordered.append(int(after[ordered[-1]]))
        if len(ordered) != len(faces):
            continue
        start_of[row] = start
        for role, at_top in ((BOTTOM, False), (TOP, True)):
            edges = tuple(edge for face in ordered for edge in _edges(labeled, face, role))
            known = found.get(frozenset(edges), _Ring(edges, ()))
            if edges:
                found[frozenset(edges)] = _Ring(known.edges, (*known.ends, (row, at_top)))
    return list(found.values())


def _above(labeled: StitchMesh, start_of: Mapping[int, int], row: int, otherwise: int) -> int:
    """The face of a row above the first face of a row below it."""
    for start in start_of.values():
        for side in range(int(labeled.right_wale[start]) + 1, int(labeled.left_wale[start])):
            across = int(labeled.twin[side])
            if across != BORDER and labeled.row[labeled.side_face[across]] == row:
                return int(labeled.side_face[across])
    return otherwise


def _edges(labeled: StitchMesh, face: int, role: int) -> list[int]:
    """Course edges of a face from left to right; top sides run from right to left."""
    first, right, left = (int(part[face]) for part in (labeled.face_start, labeled.right_wale, labeled.left_wale))
    sides = range(first, right) if role == BOTTOM else range(left - 1, right, -1)
    return [int(labeled.side_edge[side]) for side in sides]


def _pattern_totals(
    labeled: StitchMesh, rings: Sequence[_Ring], regions: Sequence[PatternRegion], planned: PlannedStitches,
    courses: EdgeCounts, size: tuple[float, float], asked: frozenset[int],
) -> dict[_Ring, int]:  # fmt: skip
    """Return the numbers of stitches of the rings beside patterns."""
    wide = [region for region in regions if region.pattern.width > 1 and region.remainder != "stretch"]
    if not wide:
        return {}
    fabric = tessellate(labeled, stitch_width=size[0], stitch_height=size[1], counts=dict(courses))
    of_row = np.zeros(int(labeled.row.max()) + 1, dtype=np.int64)
    of_row[labeled.row] = planned.courses
    first_row = np.concatenate([[0], np.cumsum(of_row)])
    multiple: dict[_Ring, int] = {}
    bands = []
    for region in wide:
        covered = covered_rounds(fabric, region)
        band = [ring for ring in rings if _is_beside(ring, covered, first_row)]
        for ring in band:
            multiple[ring] = math.lcm(multiple.get(ring, 1), region.pattern.width)
        bands.append(band)
    length = labeled.side_length[labeled.edge_side]
    totals: dict[_Ring, int] = {}
    for band in bands:
        natural = {ring: float(planned.along[list(ring.edges)].sum()) for ring in band}
        ideal = {ring: float(length[list(ring.edges)].sum()) / size[0] for ring in band}
        spread = max(natural.values(), default=0.0) - min(natural.values(), default=0.0)
        fits = [
            natural[ring] % multiple[ring] == 0 and abs(natural[ring] - ideal[ring]) <= multiple[ring] / 2 + ROUNDED
            for ring in band
        ]
        # One number for all rings follows from the asked girth, if the pattern covers its ring.
        leading = [ideal[ring] for ring in band if asked.issuperset(ring.edges)] or list(ideal.values())
        for ring in band:
            width = multiple[ring]
            loops = float(np.mean(leading)) if spread < width else ideal[ring]
            whole = max(width, width * math.floor(loops / width + 0.5))
            totals.setdefault(ring, int(natural[ring]) if all(fits) else whole)
    return totals


def _is_beside(ring: _Ring, covered: set[int], first_row: IntArray) -> bool:
    """Whether a pattern covers a round in the nearer half of a row of panels that ends at a ring.

    Stitches are shaped in the middle of a row of panels if few are shaped there.
    """
    for row, at_top in ring.ends:
        low, high = int(first_row[row]), int(first_row[row + 1])
        half = range(low + (high - low) // 2, high) if at_top else range(low, high - (high - low) // 2)
        if not covered.isdisjoint(half):
            return True
    return False


def covered_rounds(fabric: StitchMesh, region: PatternRegion) -> set[int]:
    """Return the numbers of the closed rows of stitches that a pattern covers as a whole."""
    faces = np.arange(fabric.face_count) if region.on is None else select(fabric, region.on)
    count = int(fabric.row.max()) + 1
    inside, total = np.bincount(fabric.row[faces], minlength=count), np.bincount(fabric.row, minlength=count)
    is_open = np.zeros(count, dtype=bool)
    is_open[fabric.row[right_neighbours(fabric) == BORDER]] = True
    return set(np.flatnonzero((inside == total) & (total > 0) & ~is_open).tolist())


def _ring_counts(
    labeled: StitchMesh, rings: Sequence[_Ring], totals: Mapping[_Ring, int], along: IntArray
) -> EdgeCounts:
    """Return the numbers of stitches of the edges that change."""
    length = labeled.side_length[labeled.edge_side]
    done: dict[int, int] = {}
    before: IntArray = np.zeros(0, dtype=np.int64)
    for ring in rings:
        edges = list(ring.edges)
        given = [edge for edge in edges if edge in done]
        own = np.array([done.get(edge, along[edge]) for edge in edges])
        # Edges of rings that meet others at a branching keep the number that the first ring has given them.
        if not given and ring in totals and totals[ring] != own.sum():
            share = length[edges] / length[edges].sum() * totals[ring]
            start = before if len(before) == len(edges) else np.floor(share).astype(np.int64)
            own = _spread(share, start, totals[ring])
        done |= dict(zip(edges, own.tolist(), strict=True))
        before = own
    return {edge_name(labeled, edge): count for edge, count in done.items() if count != along[edge]}


def _spread(share: FloatArray, before: IntArray, total: int) -> IntArray:
    """Return whole numbers with a total, as near to the numbers before as their shares allow; each is at least 1.

    Edges with equal needs are taken at equal distances.
    """
    counts = np.maximum(1, before + np.trunc(share - before).astype(np.int64))
    while (missing := total - int(counts.sum())) != 0:
        step = 1 if missing > 0 else -1
        need = step * (share - counts)
        need[counts + step < 1] = -np.inf
        best = np.flatnonzero(need >= need.max() - TIE)
        if not np.isfinite(need.max()):
            return counts
        take = min(abs(missing), len(best))
        counts[best[np.arange(take) * len(best) // take]] += step
    return counts


def edge_name(labeled: StitchMesh, edge: int) -> tuple[int, int]:
    """Return the name of an edge: its two vertices."""
    side = int(labeled.edge_side[edge])
    return int(labeled.face_vertex[side]), int(labeled.face_vertex[labeled.side_next[side]])
