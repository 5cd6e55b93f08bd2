# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Check that relaxed loops are linked as their stitches require, and that the check finds a loop that is not.

For the second check, the loop of the knit or purl stitch nearest to the centre is pulled out: its head moves by eight
radii to the side from which it was drawn. The times are those of ``check_loops`` alone.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np
from scipy.spatial.transform import Rotation

import stitchmesh as sm
from benchmarks.measures.swatches.corpus import LEAF
from benchmarks.measures.swatches.gallery import RADIUS, swatch_of
from benchmarks.table import Rows
from stitchmesh.errors import YarnError
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.patterns import pattern_names
from stitchmesh.periodic.repeat.drawn_swatch import draw_swatch
from stitchmesh.periodic.swatch_options import SwatchOptions
from stitchmesh.quality import quality_named
from stitchmesh.yarn import YarnSet
from stitchmesh.yarngen.generate import yarns_along_routes
from stitchmesh.yarngen.loop_check.pieces import generation_radius, yarn_pieces

LIFT = 8.0
"""Displacement of the head of a loop that is pulled out, in yarn radii: two thicknesses of the fabric."""
NEIGHBOURHOOD = 48
"""Number of control points that determine the normal of the fabric at a loop: about two stitches."""
Scene = tuple[str, sm.StitchMesh, YarnSet]


def loops_at_rest(
    which: Literal["swatches", "cells", "free"], folder: Path | None = None, /, *, quality: str = "draft"
) -> Rows:
    """Yield the table."""
    scenes = {"swatches": lambda: swatches(folder), "cells": lambda: cells(quality),
              "free": lambda: free_cells(quality)}  # fmt: skip
    yield "pattern", "stitches", "linked as named", "seconds", "a lifted loop", "seconds"
    right, caught, count, total = 0, 0, 0, 0.0
    for name, fabric, yarns in scenes[which]():
        complaint, seconds = complaint_about(fabric, yarns)
        found, longer = complaint_about(fabric, lifted(fabric, yarns))
        right, caught, count, total = right + (not complaint), caught + bool(found), count + 1, total + seconds
        yield (
            name, fabric.face_count, complaint or "yes", f"{seconds:.2f}", "found" if found else "NOT FOUND",
            f"{longer:.2f}",
        )  # fmt: skip
    yield f"{right} of {count} linked as named in {total:.0f} s, {caught} of {count} lifted loops found"


def swatches(folder: Path) -> Iterator[Scene]:
    """Swatches that the gallery relaxed."""
    for name in pattern_names():
        if (folder / f"{name}.h5").exists():
            fabric = swatch_of(sm.read_pattern(name), "cpu")
            yarns = sm.read_yarns(folder / f"{name}.h5")
            first = sm.generate_yarns(fabric, yarn_radius=RADIUS)
            if len(first.points) == len(yarns.points):  # not a cell of the corpus, which may lie in the same folder
                yield name, fabric, yarns


def knits() -> list[str]:
    """The knits of the corpus."""
    return [name for name in LEAF if name in pattern_names()]


def cells(quality: str) -> Iterator[Scene]:
    """Return the corpus with the generated periods, as ``benchmarks/corpus.py`` relaxes it."""
    for name in knits():
        fabric, yarns = draw_swatch(sm.read_pattern(name), SwatchOptions(), quality_named(quality))
        assert fabric is not None
        leaf = sm.YarnMaterial.named("leaf")
        yield name, fabric, sm.relax_yarns(yarns, material=leaf, quality=quality, device="cpu").yarns


def free_cells(quality: str) -> Iterator[Scene]:
    """Return the corpus with free periods, lying on nothing."""
    for name in knits():
        swatch = sm.swatch(
            name, quality=quality, device="cpu", relax_cell=True, relaxation="frictionless", unsupported=True
        )
        assert swatch.fabric is not None
        yield name, swatch.fabric, swatch.yarns


def complaint_about(fabric: sm.StitchMesh, yarns: YarnSet) -> tuple[str, float]:
    """Return the result of ``check_loops`` and its time [s]."""
    began = time.perf_counter()
    try:
        sm.check_loops(fabric, yarns)
        complaint = ""
    except YarnError as error:
        complaint = str(error)
    return complaint, time.perf_counter() - began


def lifted(fabric: sm.StitchMesh, yarns: YarnSet) -> YarnSet:
    """Return the yarns after the head of one loop is pulled out of the loop that was drawn through it."""
    plain = np.flatnonzero(np.isin(fabric.stitch, [Stitch.KNIT, Stitch.PURL]))
    centre = np.add.reduceat(fabric.corner_position, fabric.face_start[:-1])[plain] / 4
    face = int(plain[np.linalg.norm(centre - fabric.vertices.mean(axis=0), axis=1).argmin()])
    head = (yarns.face == face) & (yarns.part == 0)
    side = 1.0 if fabric.stitch[face] == Stitch.KNIT else -1.0
    points = yarns.points.copy()
    points[head] += side * LIFT * yarns.radius[0] * front_at(fabric, yarns, head)
    return replace(yarns, points=points)


def front_at(fabric: sm.StitchMesh, yarns: YarnSet, where: np.ndarray) -> np.ndarray:
    """Return the unit normal of the fabric, towards the right side, near some control points."""
    drawn = yarns_along_routes(yarn_pieces(fabric, yarns).routes, generation_radius(fabric, yarns)).points
    near = np.argsort(np.linalg.norm(drawn - drawn[where].mean(axis=0), axis=1))[:NEIGHBOURHOOD]
    now, then = (places[near] - places[near].mean(axis=0) for places in (yarns.points, drawn))
    return Rotation.align_vectors(now, then)[0].apply([0.0, 0.0, 1.0])
