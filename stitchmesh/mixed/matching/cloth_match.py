# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Triangles that match yarns: the fitted materials, and their difference from the yarns over a range of strains.

Casafranca et al. 2020 (section 7) estimate the parameters of the triangles so that energies agree under uniform stretch
and bending. Here two laws are fitted, one with constant moduli and one with tables of tension (``fitted_material``).
The tables are kept if they decrease the mismatch enough.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import ParameterError
from stitchmesh.io.contents import FilePath
from stitchmesh.mixed.matching.cell_equilibrium import CellSolver
from stitchmesh.mixed.matching.cell_tests import BENDS, LoadingCurve, run_tests
from stitchmesh.mixed.matching.fitted_material import fit_linear, fit_tables, respond
from stitchmesh.mixed.matching.yarn_cell import YarnCell
from stitchmesh.mixed.triangles.cloth_material import ClothMaterial
from stitchmesh.mixed.triangles.material_file import write_material
from stitchmesh.progress import Progress, shown_stages

Numbers = NDArray[np.float64]
STRAINS = (-0.05, -0.02, 0.02, 0.05, 0.1, 0.15, 0.2)
"""Strains of the tests."""
CURVATURES = (-1.0, -0.5, 0.5, 1.0)
"""Curvatures of the tests [1/cm]."""


@dataclass(frozen=True, eq=False)
class ClothMatch:
    """Tests of yarns, and the materials of triangles that are nearest to them."""

    curves: tuple[LoadingCurve, ...]
    """The tests of the yarns."""
    linear: ClothMaterial
    """The material of constant moduli."""
    tables: ClothMaterial
    """The material with tables of tension along both axes."""

    @property
    def material(self) -> ClothMaterial:
        """The material to use: with tables if they decrease the mismatch of stretch by over a fifth, from above 1 %."""
        linear, tables = self.stretch_mismatch(self.linear), self.stretch_mismatch(self.tables)
        return self.tables if linear > 0.01 and tables < 0.8 * linear else self.linear

    def mismatch(self, material: ClothMaterial) -> dict[str, float]:
        """Relative difference of a material in each test: sqrt(sum (|dT| / strain)^2 / sum (|T| / strain)^2).

        T is the pair of tension and side tension of the yarns beyond their values at rest, and the sums are over the
        strains.
        """
        return {curve.test: _mismatch(material, curve) for curve in self.curves}

    def stretch_mismatch(self, material: ClothMaterial) -> float:
        """Root mean square of the relative differences in the tests without bending."""
        values = [value for test, value in self.mismatch(material).items() if test not in BENDS]
        return float(np.sqrt(np.mean(np.square(values))))

    @property
    def lines(self) -> list[str]:
        """The table of mismatch: test, strain, tension of yarns, tension of triangles, relative difference."""
        material = self.material
        linear, tables = (100.0 * self.stretch_mismatch(each) for each in (self.linear, self.tables))
        kept = "tables of tension" if material is self.tables else "constant moduli"
        lines = [
            f"mismatch of stretch and shear: constant moduli {linear:.1f} %, tables of tension {tables:.1f} %; "
            f"kept: {kept}",
            *_at_rest(self.curves),
            f"{'test':<12} {'strain':>8} {'yarns':>12} {'triangles':>12} {'difference':>11}",
        ]
        for curve in self.curves:
            lines += _rows(material, curve)
        return lines

    def __str__(self) -> str:
        """The table of mismatch."""
        return "\n".join(self.lines)


def match_cloth(
    cell: YarnCell,
    *,
    name: str = "matched",
    strains: Iterable[float] = STRAINS,
    curvatures: Iterable[float] = CURVATURES,
    sliding: bool = False,
    progress: Progress | Literal[False] | None = None,
) -> ClothMatch:
    """Fit the stiffnesses of triangles to a fabric of crossing yarns.

    Args:
        cell: the repeat of the fabric.
        name: name of the material.
        strains: strains of the tests of stretch and of shear [-, rad].
        curvatures: curvatures of the tests of bending [1/cm].
        sliding: whether yarns slide through their crossings without friction; otherwise friction holds them.
        progress: called with the completed part and the name of each test before it runs; by default a line shows them
            on a terminal or in a notebook, and False shows nothing.

    Raises:
        ParameterError: strains or curvatures are missing or out of range.
        SolverError: a state of the cell finds no equilibrium; smaller strains help.
    """
    with shown_stages(progress) as report:
        curves = run_tests(CellSolver(cell, sliding=sliding), strains, curvatures, report)
    width, height = cell.period
    yarns = "yarns slide" if sliding else "friction holds the yarns"
    source = f"fitted to {cell.node_count} crossings on {width:g} x {height:g} cm, where {yarns}"
    match = match_curves(curves, name=name, density=cell.density, source=source)
    linear, tables = (_damped(material, cell) for material in (match.linear, match.tables))
    return replace(match, linear=linear, tables=tables)


def match_curves(curves: Iterable[LoadingCurve], *, name: str, density: float, source: str = "") -> ClothMatch:
    """Fit the stiffnesses of triangles to tests of a fabric from any source.

    Args:
        curves: ``course``, ``wale``, ``shear`` and the three tests of bending, and ``both`` if there is one.
        name: name of the material.
        density: mass per area [g/cm^2].
        source: where the tests come from.

    Raises:
        ParameterError: a test is missing or occurs twice, or the fabric does not resist stretch or bending.
    """
    tests = tuple(curves)
    by_name: dict[str, LoadingCurve] = {curve.test: curve for curve in tests}
    if len(by_name) != len(tests):
        raise ParameterError("match: got a test twice; expected each test once")
    linear = fit_linear(by_name, name, density, source)
    return ClothMatch(tests, linear, fit_tables(by_name, linear))


def write_match(path: FilePath, match: ClothMatch) -> None:
    """Write the material of a match, with the table of mismatch as comments.

    Raises:
        FileError: the file cannot be written, or its suffix is not ``.toml``.
    """
    write_material(path, match.material, notes=match.lines)


def _damped(material: ClothMaterial, cell: YarnCell) -> ClothMaterial:
    return replace(
        material, damping=cell.materials.weft.damping_stiffness, mass_damping=cell.materials.weft.damping_mass
    )


def _differences(material: ClothMaterial, curve: LoadingCurve) -> tuple[Numbers, Numbers]:
    """Difference of the tensions of triangles and yarns, and size of the tensions of yarns, at strains other than 0."""
    (tension, side), (own, own_side) = curve.rise, respond(material, curve)
    loaded = curve.loaded
    return np.hypot(own - tension, own_side - side)[loaded], np.hypot(tension, side)[loaded]


def _mismatch(material: ClothMaterial, curve: LoadingCurve) -> float:
    strain = curve.strain[curve.loaded]
    apart, size = (float(np.linalg.norm(part / strain)) for part in _differences(material, curve))
    return apart / size if size > 0.0 else float(apart > 0.0)


def _at_rest(curves: tuple[LoadingCurve, ...]) -> list[str]:
    """The tensions and moments with which the fabric is laid out, and which triangles do not have."""
    kinds = ("course", "dyn/cm"), ("wale", "dyn/cm"), ("bend course", "dyn"), ("bend wale", "dyn")
    stiffness = {curve.test: float(np.abs(curve.rise[0]).max()) for curve in curves}
    at_rest = {curve.test: curve.at_rest[0] for curve in curves}
    parts = [
        f"{test} {at_rest[test]:.3g} {unit}"
        for test, unit in kinds
        if test in at_rest and abs(at_rest[test]) > 1e-6 * stiffness[test]
    ]
    return [f"yarns as laid out have, and triangles have not: {', '.join(parts)}"] if parts else []


def _rows(material: ClothMaterial, curve: LoadingCurve) -> list[str]:
    """The lines of one test."""
    tension, own = curve.rise[0], respond(material, curve)[0]
    apart, size = _differences(material, curve)
    part = np.zeros(len(tension))
    part[curve.loaded] = apart / np.maximum(size, np.finfo(np.float64).tiny)
    return [
        f"{curve.test:<12} {strain:>8.3f} {yarns:>12.5g} {triangles:>12.5g} {100.0 * apart:>9.1f} %"
        for strain, yarns, triangles, apart in zip(curve.strain, tension, own, part, strict=True)
        if strain != 0.0
    ]
