# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Every pattern of the library laid over every other one, on a swatch and on a garment.

A pair succeeds if the second pattern covers as much of the fabric as it covers of the plain fabric, up to one stitch in
a hundred. Each result is checked: the stitch mesh is valid, its cables are whole, its borders have as many loops as
before, and the inverse changes restore every array. For a sample of the pairs, yarns are generated and their loops
checked.
"""

from __future__ import annotations

import re
import time
from collections import Counter
from dataclasses import dataclass, field, fields
from itertools import product

import numpy as np

from benchmarks.table import Rows
from stitchmesh.editing.edit import apply_changes
from stitchmesh.errors import StitchMeshError, YarnError
from stitchmesh.io import read_mesh
from stitchmesh.labeling import label
from stitchmesh.mesh import Mesh, StitchMesh
from stitchmesh.mesh.cable_groups import cable_groups
from stitchmesh.meshrelax import relax_mesh
from stitchmesh.patterns import LaidPattern, Pattern, lay_pattern, pattern_names, read_pattern
from stitchmesh.patterns.placement.columns import is_elastic, keeps_counts
from stitchmesh.tessellate import tessellate
from stitchmesh.yarngen import check_loops, generate_yarns

MESHES = (("assets/meshes/swatch.obj", 0.8), ("assets/meshes/dress.obj", 1.6))
"""Meshes and their stitch widths [cm]."""
ALLOWANCE = 0.01
"""Share of the faces that may be left out in addition to those left out on the plain fabric."""
SAMPLE = 70
"""Yarns are generated for every n-th pair whose second pattern has no floats."""
KINDS = ("knit and purl", "slipped and coloured", "cables", "lace and tucks")


@dataclass
class Results:
    """Results on one mesh."""

    succeeded: Counter[tuple[str, str]] = field(default_factory=Counter)
    tried: Counter[tuple[str, str]] = field(default_factory=Counter)
    reasons: Counter[str] = field(default_factory=Counter)
    seconds: list[float] = field(default_factory=list)
    least: float = 1.0
    """Smallest share of the faces that a second pattern covers, relative to the plain fabric."""
    yarns: Counter[str] = field(default_factory=Counter)


@dataclass(frozen=True)
class Options:
    """What is measured."""

    mesh: str | None = None
    stitch_width: float = 0.8
    every: int = 1
    """try every N-th pair"""


def pattern_pairs(given: Options) -> Rows:
    """Yield a table for each mesh."""
    for path, width in MESHES if given.mesh is None else ((given.mesh, given.stitch_width),):
        mesh = read_mesh(path)
        fabric = tessellate(label(mesh), stitch_width=width)
        yield f"{path}, stitch width {width} cm, {fabric.face_count} stitches"
        yield from shown(try_pairs(mesh, fabric, given.every))


def try_pairs(mesh: Mesh, fabric: StitchMesh, every: int) -> Results:
    """Lay every second pattern over every first one."""
    results, without_floats = Results(), 0
    plain = {name: laid_or_reason(fabric, name) for name in pattern_names()}
    for number, (first, second) in enumerate(product(pattern_names(), pattern_names())):
        below, wanted = plain[first], plain[second]
        if number % every or isinstance(below, str):
            continue
        kinds = kind_of(read_pattern(first)), kind_of(read_pattern(second))
        results.tried[kinds] += 1
        start = time.perf_counter()
        laid = laid_or_reason(below.fabric, second)
        results.seconds.append(time.perf_counter() - start)
        if isinstance(laid, str):
            results.reasons[laid] += 1
            results.succeeded[kinds] += isinstance(wanted, str)
            continue
        check(fabric, below.fabric, laid)
        share = 1.0 if isinstance(wanted, str) else share_of(laid) / share_of(wanted)
        results.least = min(results.least, share)
        results.succeeded[kinds] += share > 1.0 - ALLOWANCE
        if share <= 1.0 - ALLOWANCE:
            results.reasons[f"{second} over {first}: {share:.1%} of the stitches; {laid.left_out[0]}"] += 1
        if kinds[1] != KINDS[1]:
            without_floats += 1
            if without_floats % SAMPLE == 0:
                found = loops_of(relax_mesh(laid.fabric, surface=mesh).fabric)
                plain = lay_pattern(fabric, second).fabric
                alone = found == "right" or loops_of(relax_mesh(plain, surface=mesh).fabric)
                results.yarns[found + ("" if found == "right" else f"; {second} over {first}, on plain: {alone}")] += 1
    return results


def loops_of(fabric: StitchMesh) -> str:
    """Generate yarns and check their loops; return "right", or the message without its numbers."""
    try:
        check_loops(fabric, generate_yarns(fabric, quality="draft"))
    except YarnError as error:
        return re.sub(r"-?[0-9.]+", "#", str(error))
    return "right"


def laid_or_reason(fabric: StitchMesh, name: str) -> LaidPattern | str:
    """Lay a pattern; return the result, or the message if the pattern fits nowhere."""
    try:
        return lay_pattern(fabric, name)
    except StitchMeshError as error:
        return str(error)


def share_of(laid: LaidPattern) -> float:
    """Return the share of the faces that are in the pattern, of all that could be."""
    return laid.faces_laid / (laid.faces_laid + sum(len(part.faces) for part in laid.left_out))


def kind_of(pattern: Pattern) -> str:
    """Return the kind of a pattern."""
    if not keeps_counts(pattern):
        return KINDS[3]
    if not is_elastic(pattern):
        return KINDS[2]
    plain = all(cell.stitch.name in ("KNIT", "PURL") and not cell.yarn for row in pattern.rows for cell in row.cells)
    return KINDS[0] if plain else KINDS[1]


def check(plain: StitchMesh, before: StitchMesh, laid: LaidPattern) -> None:
    """Check a result; an error ends the benchmark."""
    made = laid.fabric
    StitchMesh(**{part.name: getattr(made, part.name) for part in fields(StitchMesh)})
    cable_groups(made)
    borders = [sorted(len(loop) for loop in fabric.boundary_loops) for fabric in (plain, made)]
    if borders[0] != borders[1]:
        raise RuntimeError(f"borders: got {borders[1]} edges, expected {borders[0]}")
    edited = apply_changes(before, laid.changes)
    restored = apply_changes(edited.fabric, edited.inverse).fabric
    for part in fields(StitchMesh):
        if not np.array_equal(getattr(restored, part.name), getattr(before, part.name)):
            raise RuntimeError(f"undo: {part.name} differs")


def shown(results: Results) -> Rows:
    """Yield the matrix of kinds, the reasons and the times."""
    yield "over", *KINDS
    for second in KINDS:
        cells = [f"{results.succeeded[first, second]} of {results.tried[first, second]}" for first in KINDS]
        yield second, *cells
    tried, succeeded = results.tried.total(), results.succeeded.total()
    yield f"{succeeded} of {tried} pairs succeed; least coverage, relative to the plain fabric: {results.least:.1%}"
    median, slow = 1e3 * np.percentile(results.seconds, [50, 95])
    yield "all meshes valid, cables whole, undo exact; loops of a sample of yarns:"
    for found, count in results.yarns.most_common():
        yield f"- {count}: {found}"
    yield f"one pattern over another: median {median:.0f} ms, 95th percentile {slow:.0f} ms"
    for reason, count in results.reasons.most_common():
        yield f"- {count}: {reason}"
