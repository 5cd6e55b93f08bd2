# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Two relaxed cells of another group (Sperl et al. 2021), relaxed here with their radius and rest lengths.

Their yarns are rods of a natural curvature, which the files state; ours are straight at rest. By how much of their
curvature they are bent at rest is read from the files: of the bending forces that straight yarns would exert in their
cell, theirs exert what is left. Relaxed here in their periods with bending weakened so, their cells should be free of
stress; how far a cell would go from there follows from its stiffness, to first order. Only sizes of curvatures are
compared: which way a rod is bent at rest would need its frames.
"""

from __future__ import annotations

import logging
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from stitchmesh.io.pyp import read_pyp
from stitchmesh.periodic.growing import size_of, stretched
from stitchmesh.quality import PRESETS, Quality
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import REFERENCE_RADIUS, RelaxCell, YarnMaterial, relax_yarns
from stitchmesh.yarnrelax.stress import cell_stress

CELLS = ("stockinette", "basket")
REPEAT = {"stockinette": (2, 2), "basket": (4, 4)}
"""Wales and courses, or warps and wefts, of a cell."""
STEP = 0.005
"""Strain by which stiffness is measured."""
QUALITY = replace(PRESETS["reference"], max_iterations=30_000)
FREE = RelaxCell(shear=False)


@dataclass(frozen=True)
class Rods:
    """A cell of the files."""

    yarns: YarnSet
    """As splines; rest lengths are those of arcs, in the proportion in which the file's are those of chords."""
    set_curvature: float
    """Natural curvature of the rods over the curvature that they have, by size, a fit through all vertices."""


def read_rods(path: Path) -> Rods:
    """A cell with its natural curvature."""
    says = logging.getLogger("stitchmesh.io.pyp")
    level = says.level
    says.setLevel(logging.ERROR)  # that twists and curvatures are dropped is known here
    try:
        yarns = read_pyp(path)
    finally:
        says.setLevel(level)
    chords = []
    for knots, end in zip(yarns.sampled(1), _ends(yarns), strict=True):
        chords.append(np.linalg.norm(np.diff(np.concatenate([knots, end[None]]), axis=0), axis=1))
    at_rest = yarns.rest_length * yarns.lengths / np.concatenate(chords)
    return Rods(replace(yarns, rest_length=at_rest), set_curvature(path))


def _ends(yarns: YarnSet) -> np.ndarray:
    """Where the first knot of each yarn lies one image on [cm], shape (Y, 3)."""
    assert yarns.lattice is not None and yarns.lattice_step is not None
    return np.array([knots[0] for knots in yarns.sampled(1)]) + yarns.lattice.shift(yarns.lattice_step)


def set_curvature(path: Path) -> float:
    """Natural curvature over curvature, by least squares through the vertices of the file's polylines."""
    blocks = _blocks(path)
    place, (width, height) = blocks["Q"][:, :3], blocks["pattern"][0, :2]
    edges = blocks["E"].astype(int)
    leaving = np.zeros_like(place)
    before = np.zeros(len(place), dtype=int)
    leaving[edges[:, 0]] = place[edges[:, 1]] + edges[:, 2:] * [width, height] @ np.eye(2, 3) - place[edges[:, 0]]
    before[edges[:, 1]] = edges[:, 0]
    out = leaving / np.linalg.norm(leaving, axis=1)[:, None]
    into = out[before]
    bent = 2 * np.linalg.norm(np.cross(into, out), axis=1) / (1 + (into * out).sum(axis=1))
    natural = np.linalg.norm(blocks["RK"], axis=1)
    return float((natural * bent).sum() / (bent * bent).sum())


def _blocks(path: Path) -> dict[str, np.ndarray]:
    """The numbers of each block of a file."""
    found: dict[str, list[list[float]]] = {}
    name = ""
    for line in path.read_text().splitlines():
        words = line.partition("#")[0].split()
        if words and words[0].startswith("*"):
            name = words[0][1:]
            found[name] = []
        elif words:
            found[name].append([float(word) for word in words])
    return {name: np.array(rows) for name, rows in found.items()}


def cells_table(folder: Path) -> Iterable[list[object]]:
    """Their spacings, and ours of free cells of straight yarns."""
    yield ["cell", "yarn of a loop or crossing / d", "wale or warp spacing [cm]", "course or weft spacing [cm]",
           "here", "here", "change", "change"]  # fmt: skip
    for name in CELLS:
        rods = read_rods(folder / f"{name}.pyp")
        assert rods.yarns.lattice is not None
        theirs = np.array(size_of(rods.yarns.lattice))
        ours = np.array(_rest(rods.yarns, material_of(rods.yarns), FREE)[1])
        length = rods.yarns.lengths.sum() / np.prod(REPEAT[name]) / (2 * rods.yarns.radius[0])
        sizes = [f"{value:.4f}" for value in (*theirs / REPEAT[name], *ours / REPEAT[name])]
        yield [name, f"{length:.2f}", *sizes, *(f"{100 * change:+.1f} %" for change in ours / theirs - 1)]


def stress_table(folder: Path) -> Iterable[list[object]]:
    """Stress in their periods with the whole of bending and with what natural curvature leaves, and what follows."""
    yield ["cell", "natural over actual curvature", "tension, straight yarns [dyn/cm]", "tension, bending weakened",
           "change that follows by the stiffness of the free cell", "by that in their periods",
           "yarns moved [radii], straight", "weakened"]  # fmt: skip
    for name in CELLS:
        rods = read_rods(folder / f"{name}.pyp")
        material = material_of(rods.yarns)
        weak = replace(material, k_bend=material.k_bend * (1.0 - rods.set_curvature))
        straight, bent = (tension(rods.yarns, of) for of in (material, weak))
        bases = (_rest(rods.yarns, material, cell)[0] for cell in (FREE, None))
        changes = [-np.linalg.solve(stiffness(base, material), bent) for base in bases]
        numbers = [", ".join(f"{value:.0f}" for value in pair) for pair in (straight, bent)]
        moved = [f"{moved_by(rods.yarns, of):.1f}" for of in (material, weak)]
        follows = [", ".join(f"{100 * value:+.1f} %" for value in change) for change in changes]
        yield [name, f"{rods.set_curvature:.3f}", *numbers, *follows, *moved]


def tension(yarns: YarnSet, material: YarnMaterial, quality: Quality = QUALITY) -> np.ndarray:
    """Tensions along the periods of yarns at rest in their cell [dyn/cm], shape (2,)."""
    rest = _rest(yarns, material, None, quality)[0]
    counts = {"quadrature_points": quality.quadrature_points, "contact_samples": quality.contact_samples}
    stress = cell_stress(rest, material, **counts)
    return np.array([stress.course, stress.wale])


def moved_by(yarns: YarnSet, material: YarnMaterial) -> float:
    """Distance of places of yarns at rest in their cell from where they were [radii], root mean square."""
    before, after = (np.concatenate(state.sampled(4)) for state in (yarns, _rest(yarns, material, None)[0]))
    way = after - before
    way -= way.mean(axis=0)
    return float(np.sqrt((way**2).sum(axis=1).mean()) / yarns.radius[0])


def stiffness(yarns: YarnSet, material: YarnMaterial) -> np.ndarray:
    """Change of the tensions by strains of yarns at rest [dyn/cm], shape (2, 2)."""
    columns = []
    for factors in ((STEP, 0.0), (0.0, STEP)):
        ends = [tension(stretched(yarns, 1 + side * factors[0], 1 + side * factors[1]), material) for side in (1, -1)]
        columns.append((ends[0] - ends[1]) / (2 * STEP))
    return np.stack(columns, axis=1)


def material_of(yarns: YarnSet) -> YarnMaterial:
    """The published simulation material, scaled to the yarns' radius."""
    return YarnMaterial.named("kaldor-simulation").scaled(float(yarns.radius[0]) / REFERENCE_RADIUS)


def _rest(
    yarns: YarnSet, material: YarnMaterial, cell: RelaxCell | None, quality: Quality = QUALITY
) -> tuple[YarnSet, tuple[float, float]]:
    """Yarns at rest, and the size of their cell."""
    rest = relax_yarns(yarns, material=material, quality=quality, device="cpu", cell=cell).yarns
    assert rest.lattice is not None
    return rest, size_of(rest.lattice)
