# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarns of a face mesh: the strands of its faces, joined to control polygons, as smooth curves.

The polygon of a yarn is the control polygon of a quadratic B-spline, as in the programs of the format's authors: the
curve touches the middle of each of its edges. It is sampled at equal arc lengths, and the yarn is the cubic B-spline
through the samples.

Checkpoints give the lengths of parts of yarns, and their order gives the direction of a yarn; other yarns run as the
labels of their sides say. The rest length of a part is distributed in proportion to its present length.
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from stitchmesh.errors import check_positive, first_few
from stitchmesh.faces.face_drawing import FaceLibrary
from stitchmesh.faces.face_mesh import Checkpoint, FaceMesh
from stitchmesh.faces.face_type import ENTERING, LEAVING, YARN
from stitchmesh.io.yarn_formats.midpoint_curve import MidpointCurve, midpoint_curve, through_samples
from stitchmesh.mesh import FloatArray
from stitchmesh.quality import DEFAULT_QUALITY, Quality, quality_named
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.radius_estimate import estimate_radius
from stitchmesh.yarn.rest_length import marked_stretches
from stitchmesh.yarngen.face_yarns.strands import (
    FREE,
    PlacedStrand,
    ends_by_side,
    partners_of_ends,
    place_drawings,
)  # fmt: skip

NO_LIBRARY = FaceLibrary()
"""A library without drawings; the drawings then come from stitches and labels."""

logger = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class FaceYarns:
    """The yarns of a face mesh."""

    yarns: YarnSet
    """The yarns."""
    by_labels: tuple[str, ...]
    """Names of the types of faces that were drawn from their labels, because no library has them."""


@dataclass(frozen=True, eq=False)
class _Chain:
    """The control polygon of a yarn."""

    points: FloatArray
    """Corners of the polygon [cm], shape (n, 3)."""
    closed: bool
    """Whether the last corner is followed by the first one."""
    corner_of_end: dict[int, int]
    """For each end of a strand of the yarn: its corner of the polygon."""


def face_yarns(
    mesh: FaceMesh, library: FaceLibrary = NO_LIBRARY, *, yarn_radius: float | None = None,
    quality: str | Quality = DEFAULT_QUALITY,
) -> FaceYarns:  # fmt: skip
    """Generate the yarns of a mesh of faces of any type.

    Args:
        mesh: the faces and their joins.
        library: drawings of types of faces; they are preferred to the drawings of the stitches.
        yarn_radius: radius of all yarns [cm]; if it is None, it is estimated from the distances of the yarns.
        quality: a preset, which gives the distance of control points.

    Raises:
        ParameterError: the quality is unknown, or the radius is not positive or cannot be estimated.
        YarnError: the faces have no yarn.
    """
    if yarn_radius is not None:
        check_positive("yarn_radius", yarn_radius, "cm")
    preset = quality_named(quality)
    placed = place_drawings(mesh, library)
    chains = _chains(mesh, placed.strands)
    curves = [midpoint_curve(chain.points, chain.closed) for chain in chains]
    if yarn_radius is None:
        yarn_radius = _estimated(curves, placed.strands)
    # Length of a plain loop of a template, in yarn radii. This length over the number of control points of a plain
    # stitch is the distance of samples.
    spacing = 35.0 * yarn_radius / preset.control_points_per_stitch
    sampled = [through_samples(curve, spacing) for curve in curves]
    yarns = YarnSet.from_curves(
        [control for control, _ in sampled], closed=[curve.closed for curve in curves], radius=yarn_radius
    )
    yarns = _with_lengths(mesh, placed.strands, chains, [places for _, places in sampled], yarns)
    names = tuple(dict.fromkeys(kind.name for kind in placed.by_labels))
    if names:
        logger.info("faces drawn from their labels, because no library has them: %s", first_few(names, 8))
    return FaceYarns(yarns, names)


def _estimated(curves: Sequence[MidpointCurve], strands: Sequence[PlacedStrand]) -> float:
    """Return the radius that the distances of the curves give, and say so."""
    steps = [np.linalg.norm(np.diff(strand.points, axis=0), axis=1).sum() for strand in strands]
    # Distance of the samples from which the radius is estimated, over the median length of a strand.
    fine = [through_samples(curve, 0.1 * float(np.median(steps)))[0] for curve in curves]
    estimate = estimate_radius(YarnSet.from_curves(fine, closed=[curve.closed for curve in curves], radius=1.0))
    logger.warning("yarn radius: %.4g cm, estimated from the distances between yarns; --yarn-radius sets it", estimate)
    return estimate


def _chains(mesh: FaceMesh, strands: Sequence[PlacedStrand]) -> list[_Chain]:
    """Return the yarns: open ones from their first ends, then closed ones."""
    partner = partners_of_ends(mesh, strands)
    used = [False] * len(strands)
    chains = []
    free = [end for end, other in enumerate(partner) if other == FREE]
    for first in [*free, *range(0, len(partner), 2)]:
        if used[first // 2]:
            continue
        entries, end = [], first
        while end != FREE and not used[end // 2]:
            used[end // 2] = True
            entries.append(end)
            end = partner[end ^ 1]
        chains.append(_chain(_directed(mesh, strands, entries), strands, closed=end != FREE))
    return chains


def _directed(mesh: FaceMesh, strands: Sequence[PlacedStrand], entries: list[int]) -> list[int]:
    """Return the ends at which a yarn enters its strands, in the direction that checkpoints or labels give."""
    order = _checkpoint_order(mesh, strands, entries)
    against = order[0] > order[-1] if len(order) > 1 else _votes(mesh, strands, entries) < 0
    return [end ^ 1 for end in reversed(entries)] if against else entries


def _votes(mesh: FaceMesh, strands: Sequence[PlacedStrand], entries: list[int]) -> int:
    """Return how many yarn sides a yarn passes in their direction, minus how many it passes against it."""
    votes = 0
    for end in entries:
        kind = mesh.type_of(strands[end // 2].face)
        enters, leaves = (strands[end // 2].ends[k] for k in (end % 2, 1 - end % 2))
        for crossing, direction in ((enters, ENTERING), (leaves, LEAVING)):
            side = kind.sides[crossing.side]
            votes += side.direction * direction * (side.kind == YARN)
    return votes


def _chain(entries: list[int], strands: Sequence[PlacedStrand], *, closed: bool) -> _Chain:
    """Join the polygons of strands; two ends that nearly coincide become one corner."""
    pieces = [strands[end // 2].points[:: 1 if end % 2 == 0 else -1] for end in entries]
    corners: list[FloatArray] = []
    corner_of_end: dict[int, int] = {}
    for end, piece in zip(entries, pieces, strict=True):
        merges = bool(corners) and _coincide(corners[-2:], piece[:2])
        if merges:
            corners[-1] = (corners[-1] + piece[0]) / 2
        corner_of_end[end] = len(corners) - merges
        corners += list(piece[1:] if merges else piece)
        corner_of_end[end ^ 1] = len(corners) - 1
    if closed and len(corners) > 3 and _coincide(corners[-2:], np.array(corners[:2])):
        corners[0] = (corners[0] + corners.pop()) / 2
        corner_of_end[entries[-1] ^ 1] = 0
    return _Chain(np.array(corners), closed, corner_of_end)


def _coincide(before: Sequence[FloatArray], after: FloatArray) -> bool:
    """Return whether a polygon ends where another one begins, up to a share of their steps."""
    gap = np.linalg.norm(after[0] - before[-1])
    steps = np.linalg.norm(after[1] - after[0]) + np.linalg.norm(before[-1] - before[0])
    # Two ends that meet become one point if their distance is below this share of the strands' steps there.
    return bool(gap <= 0.5 * steps)


def _checkpoint_order(mesh: FaceMesh, strands: Sequence[PlacedStrand], entries: list[int]) -> list[int]:
    """Return the numbers of the checkpoints of a yarn, in the order in which the yarn passes them."""
    if not mesh.checkpoints:
        return []
    numbers = _checkpoint_numbers(mesh.checkpoints)
    ranks = _crossing_numbers(mesh, strands)
    found = [numbers.get(ranks[end]) for entry in entries for end in (entry, entry ^ 1)]
    return list(dict.fromkeys(number for number in found if number is not None))


Key = tuple[int, int, int]
"""A face, a side of it, and the number of a crossing along the side."""


def _checkpoint_numbers(checkpoints: Sequence[Checkpoint]) -> dict[Key, int]:
    return {(c.face, c.side, c.crossing): number for number, c in enumerate(checkpoints)}


def _crossing_numbers(mesh: FaceMesh, strands: Sequence[PlacedStrand]) -> dict[int, Key]:
    """Return the crossing of each end of a strand."""
    return {
        end: (*mesh.side_at(corner), rank)
        for corner, ends in ends_by_side(mesh, strands).items()
        for rank, (_, _, end) in enumerate(ends)
    }


def _with_lengths(
    mesh: FaceMesh, strands: Sequence[PlacedStrand], chains: Sequence[_Chain], places: Sequence[FloatArray],
    yarns: YarnSet,
) -> YarnSet:  # fmt: skip
    """Set rest lengths from checkpoints.

    Args:
        mesh: the face mesh.
        strands: its strands.
        chains: the polygon of each yarn.
        places: for each yarn the place of each corner of its polygon, in segments from the start, shape (n,) each.
        yarns: the yarns.
    """
    if not mesh.checkpoints:
        return yarns
    numbers, keys = _checkpoint_numbers(mesh.checkpoints), _crossing_numbers(mesh, strands)
    rest = np.array(yarns.rest_length)
    for yarn, (chain, place) in enumerate(zip(chains, places, strict=True)):
        marked = [(keys[end], corner) for end, corner in chain.corner_of_end.items() if keys[end] in numbers]
        marks = {float(place[corner]): _length_after(mesh, mesh.checkpoints[numbers[key]]) for key, corner in marked}
        own = slice(int(yarns.segment_start[yarn]), int(yarns.segment_start[yarn + 1]))
        rest[own] *= marked_stretches(marks, yarns.lengths[own])
    return replace(yarns, rest_length=rest)


def _length_after(mesh: FaceMesh, checkpoint: Checkpoint) -> float:
    """Return the length of yarn from a checkpoint to the next one [cm]."""
    return sum(times * mesh.units[unit][1] for times, unit in checkpoint.lengths)
