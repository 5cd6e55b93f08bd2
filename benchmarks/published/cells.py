# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Two relaxed cells of Sperl et al. 2021, relaxed again with their radius and their rest lengths.

The yarns of Sperl et al. are rods with a natural curvature, which the files state, and with stiffnesses, which the
files do not state but which follow from the balance of forces (``validation_rods``). The cells are therefore relaxed
both with straight yarns and with the natural curvature, for three materials: the published material; the same with
``k_len`` acting on the total length of a segment, because the vertices have uneven spacings and the speed of a spline
through them is uneven without a strain of the rods; and a material with the stiffnesses that follow from the forces.
"""

from __future__ import annotations

import logging
import tempfile
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from benchmarks.published import rod_model
from stitchmesh.io.yarn_formats.pyp import read_pyp
from stitchmesh.periodic.relaxation.continuation import size_of
from stitchmesh.quality import PRESETS, Quality
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import RelaxCell, YarnMaterial, relax_yarns
from stitchmesh.yarnrelax.cell_stress import cell_stress

CELLS = ("stockinette", "basket")
REPEAT = {"stockinette": (2, 2), "basket": (4, 4)}
"""Numbers of wales and courses, or of warps and wefts, of a cell."""
QUALITY = replace(PRESETS["reference"], max_iterations=30_000)
FREE = RelaxCell(shear=False)
DYN = 1e5 * rod_model.MODULUS
"""Dynes in the unit of force of the rods."""
DRIFT = 1e-3
"""Fraction of the stiffness of a segment that makes its parametrisation uniform."""
CONTACT = 7.3e-5
"""Contact stiffness over Young's modulus of the stockinette [m]; the basket weave has too few contacts for a value."""


@dataclass(frozen=True)
class Cell:
    """A cell of a published file."""

    rods: rod_model.Rods
    """Rods of the file, with the periods that fit the yarns."""
    stated: np.ndarray
    """Periods that the file states [cm], shape (2,)."""
    yarns: YarnSet
    """Splines in the periods that fit the yarns, with the ratios of length to rest length of the edges in the file."""

    @property
    def straight(self) -> YarnSet:
        """Return the same yarns without natural curvature."""
        return replace(self.yarns, natural_curvature=np.zeros(len(self.yarns.points)))

    @property
    def stiffness(self) -> rod_model.Stiffness:
        """Return the constants of the rods that follow from the balance of their forces."""
        return replace(rod_model.constants_of(self.rods), contact=CONTACT).stiffness(self.rods.radius)


def read_cell(path: Path) -> Cell:
    """Return a cell with its natural curvature."""
    rods = rod_model.read_rods(path)
    yarns = _read_with_periods(path, rods.periods)
    chords = []
    for knots, end in zip(yarns.sampled(1), _ends(yarns), strict=True):
        chords.append(np.linalg.norm(np.diff(np.concatenate([knots, end[None]]), axis=0), axis=1))
    at_rest = yarns.rest_length * yarns.lengths / np.concatenate(chords)
    natural = yarns.natural_curvature * yarns.rest_length.sum() / at_rest.sum()  # the same angle on a longer arc
    stated = np.array([float(word) for word in path.read_text().splitlines()[1].split()[:2]])
    return Cell(rods, 100 * stated, replace(yarns, rest_length=at_rest, natural_curvature=natural))


def _read_with_periods(path: Path, periods: np.ndarray) -> YarnSet:
    """Return the yarns of a file for other periods [m]."""
    lines = path.read_text().splitlines()
    lines[1] = " ".join([*map(repr, periods.tolist()), *lines[1].split()[2:]])
    says = logging.getLogger("stitchmesh.io.yarn_formats.pyp")
    level = says.level
    says.setLevel(logging.ERROR)  # that twists are dropped is known here
    try:
        with tempfile.TemporaryDirectory() as folder:
            copy = Path(folder) / path.name
            copy.write_text("\n".join(lines))
            return read_pyp(copy)
    finally:
        says.setLevel(level)


def _ends(yarns: YarnSet) -> np.ndarray:
    """Return the next periodic image of the first knot of each yarn [cm], shape (Y, 3)."""
    assert yarns.lattice is not None and yarns.lattice_step is not None
    return np.array([knots[0] for knots in yarns.sampled(1)]) + yarns.lattice.shift(yarns.lattice_step)


def periods_table(folder: Path) -> Iterable[list[object]]:
    """Compare the periods that the files state with those that fit the yarns."""
    yield ["cell", "periods stated [cm]", "periods of the yarns [cm]", "edges to directors at the border, stated",
           "strain of edges at the border, stated", "with the yarns' periods", "strain of the others"]  # fmt: skip
    for name in CELLS:
        cell = read_cell(folder / f"{name}.pyp")
        rods, across = cell.rods, cell.rods.shift.any(axis=1)
        as_stated = replace(rods, periods=cell.stated / 100)
        lean = np.degrees(np.arcsin(np.abs(_cosines(as_stated)[across]).max()))
        strains = [100 * (np.linalg.norm(of.edges, axis=1) / rods.rest_length - 1) for of in (as_stated, rods)]
        yield [name, _pair(cell.stated, "{:.4f}"), _pair(100 * rods.periods, "{:.4f}"), f"{90 - lean:.1f} degrees",
               f"{strains[0][across].mean():+.2f} %", f"{strains[1][across].mean():+.2f} %",
               f"{strains[1][~across].mean():+.2f} %"]  # fmt: skip


def _cosines(rods: rod_model.Rods) -> np.ndarray:
    edges = rods.edges
    return (edges * rods.directors).sum(axis=1) / np.linalg.norm(edges, axis=1)


def constants_table(folder: Path) -> Iterable[list[object]]:
    """Compare the constants from the balance of forces with the published material."""
    yield ["cell", "G / E", "torques left", "bending against a solid rod's", "contact / E [m]", "forces left",
           "bending / (contact d^3)", "published material"]  # fmt: skip
    for name in CELLS:
        cell = read_cell(folder / f"{name}.pyp")
        found = rod_model.constants_of(cell.rods)
        own, published = theirs(cell), published_material(cell)
        ratios = [2 * of.k_bend / (of.k_contact * (2 * cell.yarns.radius[0]) ** 3) for of in (own, published)]
        touch = f"{found.contact:.1e}" if name == "stockinette" else "no contact to tell"
        yield [name, f"{found.shear:.4f}", f"{100 * found.turning_left:.1f} %", f"{found.weakening:.4f}", touch,
               f"{100 * found.force_left:.0f} %", *(f"{ratio:.1e}" for ratio in ratios)]  # fmt: skip


def cells_table(folder: Path) -> Iterable[list[object]]:
    """Compare the spacings of free cells with those of the files, and give the displacements in the fixed periods."""
    yield ["cell", "yarn", "wale or warp spacing [cm]", "course or weft spacing [cm]", "change", "change",
           "from the periods stated", "yarns moved in their periods [radii]"]  # fmt: skip
    for name in CELLS:
        cell = read_cell(folder / f"{name}.pyp")
        yield [name, "theirs, as the file has it", *_spacings(name, 100 * cell.rods.periods), "", "", "", ""]
        for said, stiff in (("their rods, free", cell.stiffness), ("the same, published material", as_rods(cell))):
            rest = 100 * rod_model.relaxed(cell.rods, stiff).periods
            yield [name, said, *_spacings(name, rest), *_changes(rest, cell), ""]
        for said, yarns, material in variants(cell):
            rest = np.array(at_rest(yarns, material, FREE)[1])
            yield [name, said, *_spacings(name, rest), *_changes(rest, cell), f"{moved_by(yarns, material):.2f}"]


def variants(cell: Cell) -> Iterable[tuple[str, YarnSet, YarnMaterial]]:
    """Return the yarns and the materials with which a cell is relaxed."""
    materials = {"published material": published_material(cell), "the same, length held by the segment": held(cell),
                 "their stiffnesses": theirs(cell)}  # fmt: skip
    for said, material in materials.items():
        yield f"{said}, straight", cell.straight, material
        yield f"{said}, natural curvature", cell.yarns, material


def stress_table(folder: Path) -> Iterable[list[object]]:
    """Compare tensions in the periods of the files for the stiffnesses of the rods."""
    yield ["cell", "tensions of their rods [dyn/cm]", "here, straight", "here, natural curvature"]
    for name in CELLS:
        cell = read_cell(folder / f"{name}.pyp")
        rods = rod_model.tension(cell.rods, cell.stiffness)
        ours = [tension(yarns, theirs(cell)) for yarns in (cell.straight, cell.yarns)]
        yield [name, *(_pair(each, "{:.0f}") for each in (rods, *ours))]


def theirs(cell: Cell) -> YarnMaterial:
    """Return the material with the stiffnesses of the rods."""
    stiff = cell.stiffness
    along = DYN * stiff.stretch * cell.yarns.rest_length.mean() / 2
    bend, contact = DYN * stiff.bend * 1e4 / 2, DYN * stiff.contact * 1e-2  # cm in m
    return YarnMaterial(DRIFT * along, along, bend, contact, 0.0, 0.0, 0.0, 0.006)


def as_rods(cell: Cell) -> rod_model.Stiffness:
    """Return rod stiffnesses of the published material, with the ratio of twist to bending stiffness of the files."""
    material, own = published_material(cell), cell.stiffness
    stretch, bend = 2 * material.k_len / cell.yarns.rest_length.mean(), 2 * material.k_bend * 1e-4
    bend /= DYN
    return rod_model.Stiffness(stretch / DYN, bend, bend * own.twist / own.bend, material.k_contact * 1e2 / DYN)


def held(cell: Cell) -> YarnMaterial:
    """Return the published material with a length penalty on the total length of a segment."""
    material = published_material(cell)
    return replace(material, k_len=DRIFT * material.k_len, k_length=material.k_len)


def published_material(cell: Cell) -> YarnMaterial:
    """Return the published simulation material, scaled to the radius of the yarns."""
    return YarnMaterial.named("kaldor-simulation").of_radius(float(cell.yarns.radius[0]))


def tension(yarns: YarnSet, material: YarnMaterial, quality: Quality = QUALITY) -> np.ndarray:
    """Return the tensions along the periods of relaxed yarns [dyn/cm], shape (2,)."""
    rest = at_rest(yarns, material, None, quality)[0]
    counts = {"quadrature_points": quality.quadrature_points, "contact_samples": quality.contact_samples}
    stress = cell_stress(rest, material, **counts)
    return np.array([stress.course, stress.wale])


def moved_by(yarns: YarnSet, material: YarnMaterial, quality: Quality = QUALITY) -> float:
    """Return the root mean square displacement of yarns during the relaxation in their cell [radii]."""
    before, after = (np.concatenate(of.sampled(4)) for of in (yarns, at_rest(yarns, material, None, quality)[0]))
    way = after - before
    way -= way.mean(axis=0)
    return float(np.sqrt((way**2).sum(axis=1).mean()) / yarns.radius[0])


def at_rest(
    yarns: YarnSet, material: YarnMaterial, cell: RelaxCell | None, quality: Quality = QUALITY
) -> tuple[YarnSet, tuple[float, float]]:
    """Return relaxed yarns and the size of their cell."""
    rest = relax_yarns(yarns, material=material, quality=quality, device="cpu", cell=cell).yarns
    assert rest.lattice is not None
    return rest, size_of(rest.lattice)


def _spacings(name: str, size: np.ndarray) -> list[str]:
    return [f"{value:.4f}" for value in size / REPEAT[name]]


def _changes(size: np.ndarray, cell: Cell) -> list[str]:
    """Return the sizes from the periods that fit each yarn, and the stated sizes."""
    own = [f"{100 * change:+.1f} %" for change in size / (100 * cell.rods.periods) - 1]
    return [*own, _pair(100 * (size / cell.stated - 1), "{:+.1f} %")]


def _pair(values: np.ndarray, form: str) -> str:
    return ", ".join(form.format(value) for value in values)
