# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Every stitch beside and above every other stitch: number of yarns, linking of the loops, and smallest distances.

A piece is a pair of stitches among knit stitches, with a cast-on and a bind-off. The tests use the same pieces.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import product

import numpy as np
from scipy.spatial import cKDTree

from benchmarks.table import Rows
from stitchmesh.mesh import IntArray, StitchMesh
from stitchmesh.mesh.stitch import VOCABULARY, Stitch
from stitchmesh.yarn import YarnSet
from stitchmesh.yarngen import generate_yarns, mean_stitch_width
from stitchmesh.yarngen.clearance import SAMPLES_PER_SEGMENT, may_touch
from stitchmesh.yarngen.loop_check.loop_linking import expected_linking, loop_linking
from stitchmesh.yarngen.loop_check.loops import find_arcs
from stitchmesh.yarngen.templates.template import RADIUS_OVER_WIDTH
from tests.yarngen.samplers import Block, above, beside, placements, sampler, side_by_side, sides_of, tops

BATCH = 80
"""Number of pieces that are generated at once."""
WITHIN = 1.6
"""Largest distance between yarns that is searched, in radii."""


@dataclass
class Tally:
    """Results for the pieces of one kind."""

    pieces: int = 0
    yarns: int = 0
    threadings: int = 0
    wrong: int = 0
    distances: dict[Stitch, float] = field(default_factory=dict)
    """Smallest distance of any piece with a stitch in it [radii]."""


def stitch_pairs(*, quality: str = "draft", every: int = 1) -> Rows:
    """Yield both tables.

    Args:
        every: examine every N-th pair
    """
    tallies = {name: tally(pairs[::every], quality) for name, pairs in kinds().items()}
    yield "pairs", "pieces", "yarns", "threadings defined", "wrong", "smallest distance [r]"
    for name, found in tallies.items():
        yield name, found.pieces, found.yarns, found.threadings, found.wrong, f"{min(found.distances.values()):.2f}"
    yield ""
    yield "stitch", *tallies
    for stitch, making in VOCABULARY.items():
        cells = [f"{found.distances.get(stitch, np.nan):.2f}" for found in tallies.values()]
        yield f"`{making.code}`", *cells


def kinds() -> dict[str, list[tuple[Stitch, Stitch, Block]]]:
    """Return all pairs and their pieces."""
    every = list(VOCABULARY)
    worked = [stitch for stitch in every if sides_of(stitch)[0]]
    return {
        "side by side": [(a, b, beside(a, b)) for a, b in product(every, every)],
        "on top": [(a, b, above(a, b)) for a, b in product(every, worked)],
        "overlapping": [(a, b, above(a, b, k)) for a, b in product(every, worked) for k in placements(a, b) if k],
    }


def tally(pairs: list[tuple[Stitch, Stitch, Block]], quality: str) -> Tally:
    """Generate and examine all pieces."""
    found = Tally()
    for first in range(0, len(pairs), BATCH):
        some = pairs[first : first + BATCH]
        pieces = [[*block, [Stitch.KNIT] * tops(block[-1])] for _, _, block in some]
        parts = [sampler(piece) for piece in pieces]
        fabric = side_by_side(parts)
        yarns = generate_yarns(fabric, quality=quality)
        arcs = find_arcs(fabric, yarns)
        named, are = expected_linking(arcs), loop_linking(arcs, yarns)
        found.pieces += len(some)
        found.yarns += yarns.yarn_count
        found.threadings += named.threadings.count_nonzero() + len(named.turns)
        found.wrong += int((abs(named.threadings - are.threadings) > 0.5).sum()) + int((named.turns != are.turns).sum())
        nearest = distances(fabric, yarns, np.repeat(np.arange(len(parts)), [part.face_count for part in parts]))
        for (a, b, _), distance in zip(some, nearest, strict=True):
            for stitch in (a, b):
                found.distances[stitch] = min(found.distances.get(stitch, np.inf), distance)
    return found


def distances(fabric: StitchMesh, yarns: YarnSet, piece: IntArray) -> list[float]:
    """Smallest distance within each piece [radii at an eighth of the stitch width]; ``piece`` is that of each face."""
    points = np.concatenate(
        [
            curve[: len(curve) // SAMPLES_PER_SEGMENT * SAMPLES_PER_SEGMENT]
            for curve in yarns.sampled(SAMPLES_PER_SEGMENT)
        ]
    )
    segment = np.repeat(np.arange(len(yarns.segment_yarn)), SAMPLES_PER_SEGMENT)
    radius = RADIUS_OVER_WIDTH * mean_stitch_width(fabric)
    pairs = cKDTree(points).query_pairs(WITHIN * radius, output_type="ndarray")
    pairs = pairs[may_touch(yarns, segment[pairs[:, 0]], segment[pairs[:, 1]])]
    apart = np.linalg.norm(points[pairs[:, 0]] - points[pairs[:, 1]], axis=1) / radius
    nearest = np.full(piece.max() + 1, WITHIN)
    np.minimum.at(nearest, piece[yarns.face[yarns.segment_points[segment[pairs[:, 0]], 1]]], apart)
    return nearest.tolist()
