# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Find rows on many surfaces that have no modelled ones, and print how well the stitches fit.

Each line is one surface (``benchmarks/scenes/surfaces.py``).

- ``stitches``: seconds, stitches, increases and decreases a thousand, short rows, grafted edges, distance to the input
  (rms and largest, in stitch widths), rms deviation of the stretch of stitches and of edges after mesh relaxation, rows
  whose increases and decreases are at seams or spread, and with ``--relax`` the largest strain and the certificate of
  the yarns at ``draft``.
- ``panels``: rows of panels, divided into stitches: panels, rows of panels, stitches, stitches of ``auto_stitches``,
  whether both have the same borders and handles, and with ``--loops`` whether loops hold after mesh relaxation.
- ``modelled``: rows and stitches of the modelled garments, those that are found on their triangles, and differences.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeVar

import numpy as np
from tyro.conf import Positional

import stitchmesh as sm
from benchmarks.places import MESHES
from benchmarks.scenes.garments import Garment
from benchmarks.scenes.surfaces import Surface, garment, surfaces
from benchmarks.table import Rows
from stitchmesh.errors import StitchMeshError
from stitchmesh.mesh import StitchMesh
from stitchmesh.run import QUIET
from stitchmesh.shaping.auto_stitches import ShapedFabric
from stitchmesh.shaping.options import DEFAULT_PLACEMENT, PANEL_SIZE, Placement
from stitchmesh.shaping.report import shaping_report, topology

MOST_CHECKED = 10_000
"""Largest number of stitches whose loops are checked, which takes minutes beyond it."""


@dataclass(frozen=True)
class Options:
    """The surfaces."""

    files: Positional[tuple[Path, ...]] = ()
    """by default the shapes and the garments of the project"""
    unit: str = "cm"
    width: float = 0.8
    only: tuple[str, ...] = ()
    """names of surfaces"""
    loops: bool = False
    """check the loops of the yarns"""


@dataclass(frozen=True)
class ShapingOptions(Options):
    """The surfaces, and how their rows are found."""

    relax: bool = False
    """relax the yarns at draft"""
    device: str = "cpu"
    most_shaping: float | None = None
    """largest part of a row that is increases or decreases"""
    shaping: Placement = DEFAULT_PLACEMENT


@dataclass(frozen=True)
class PanelOptions(Options):
    """The surfaces, and the size of their panels."""

    panel_size: int = PANEL_SIZE


Chosen = TypeVar("Chosen", bound=Options)


def rows_of(chosen: Chosen, measure: Callable[[Surface, Chosen], tuple[object, ...]]) -> Rows:
    """Yield the row of each surface, or what refuses it."""
    logging.disable(logging.WARNING)
    np.seterr(all="ignore")
    for surface in surfaces(chosen.files, chosen.unit, chosen.width):
        if not chosen.only or surface.name in chosen.only:
            try:
                yield measure(surface, chosen)
            except StitchMeshError as error:
                yield surface.name, f"{type(error).__name__}: {error}"


def stitches(options: ShapingOptions) -> Rows:
    """Find rows of stitches."""
    titles = (
        "surface", "s", "stitches", "irregular / 1000", "short rows", "grafted", "rms", "max", "rms %", "edge %",
        "even", "seam", "spread",
    )  # fmt: skip
    yield *titles, *(("strain", "certificate", "rest", "s", "loops") if options.relax else ())
    yield from rows_of(options, stitches_of)


def stitches_of(surface: Surface, options: ShapingOptions) -> tuple[object, ...]:
    """Knit one surface, and return its row."""
    mesh = surface.make()
    start = time.perf_counter()
    shaping = sm.ShapingOptions(most_shaping=options.most_shaping, shaping=options.shaping)
    shaped = sm.shape_fabric(mesh, stitch_width=surface.width, options=shaping)
    seconds = time.perf_counter() - start
    made = sm.relax_mesh(shaped.fabric, surface=shaped.surface_mesh, device=options.device, run=QUIET)
    fabric, how = made.fabric, made.report
    fabric = sm.make_room(fabric).fabric
    report = shaping_report(fabric, shaped.given, surface.width, seconds)
    return (
        surface.name, f"{seconds:.1f}", report.stitches, f"{report.irregular_per_thousand:.1f}", report.short_rows,
        report.mismatched_edges, f"{report.rms_distance:.3f}", f"{report.largest_distance:.2f}",
        f"{100 * (report.rms_stretch or 0):.1f}", f"{100 * (report.rms_edge_stretch or 0):.1f}",
        "yes" if how.converged else "no", shaped.report.stacked_rows, shaped.report.spread_rows,
        *(relaxed(replace(shaped, fabric=fabric), options) if options.relax else ()),
    )  # fmt: skip


def relaxed(shaped: ShapedFabric, options: ShapingOptions) -> Iterator[object]:
    """Relax the yarns at ``draft``, and yield their figures."""
    start = time.perf_counter()
    yarns = sm.generate_yarns(shaped.fabric)
    result = sm.relax_yarns(yarns, quality="draft", keep_shape=shaped.fabric, device=options.device, run=QUIET)
    report = result.report
    yield from (f"{100 * report['max_strain']:.1f}", report["certificate"], "yes" if report["converged"] else "no")
    yield f"{time.perf_counter() - start:.1f}"
    yield loops_of(shaped.fabric, result.yarns) if options.loops else ""


def loops_of(fabric: StitchMesh, yarns: sm.YarnSet) -> str:
    """Return ``held`` if each loop is held as its stitch says, or what is wrong; nothing of a large fabric."""
    if fabric.face_count >= MOST_CHECKED:
        return ""
    try:
        sm.check_loops(fabric, yarns)
    except StitchMeshError as error:
        return str(error)[:100]
    return "held"


def panels(options: PanelOptions) -> Rows:
    """Find rows of panels."""
    yield "surface", "panels", "rows", "stitches", "direct", "same", "loops"
    yield from rows_of(options, panels_of)


def panels_of(surface: Surface, options: PanelOptions) -> tuple[object, ...]:
    """Label and divide one surface, and return its row."""
    mesh, width = surface.make(), surface.width
    labeled = sm.auto_labels(mesh, stitch_width=width, panel_size=options.panel_size, progress=False)
    # Turns of short rows would be borders that panels do not have.
    direct = sm.auto_stitches(mesh, stitch_width=width, options=sm.ShapingOptions(short_rows=False))
    fabric = sm.tessellate(labeled, stitch_width=width)
    same = topology(labeled) == topology(fabric) == topology(direct)
    held = ""
    if options.loops and fabric.face_count < MOST_CHECKED:
        even = sm.relax_mesh(fabric, surface=mesh, run=QUIET).fabric
        try:
            held = loops_of(even, sm.generate_yarns(even))
        except StitchMeshError as error:
            held = str(error)[:80]
    counts = labeled.face_count, labeled.row.max() + 1, fabric.face_count, direct.face_count
    return surface.name, *counts, "yes" if same else "no", held


def modelled(names: tuple[str, ...] = (), /) -> Rows:
    """Compare rows that are found on triangles with modelled rows.

    Args:
        names: names of garments, such as hat; all of them without any
    """
    logging.disable(logging.WARNING)
    yield "garment", "width", "rows", "found", "%", "stitches", "found", "%"
    for path in sorted(MESHES.glob("*.obj")):
        if names and path.stem not in names:
            continue
        surface = garment(path)
        try:
            made = Garment(path.stem, surface.width).divided()
            found = sm.auto_stitches(surface.make(), stitch_width=surface.width)
        except StitchMeshError as error:
            yield path.name, f"{type(error).__name__}: {error}"
            continue
        cells: list[object] = []
        for counts in zip(size(made), size(found), strict=True):
            cells += [*counts, f"{100 * (counts[1] / counts[0] - 1):+.1f}"]
        yield path.name, f"{surface.width:.2f}", *cells


def size(fabric: StitchMesh) -> tuple[int, int]:
    """Return the numbers of rows and of stitches of a fabric."""
    return len(np.unique(fabric.row)), fabric.face_count


ACTIONS = (stitches, panels, modelled)
