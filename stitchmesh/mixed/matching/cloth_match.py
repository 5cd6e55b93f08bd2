# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Triangles that match yarns: the fitted materials, and how far they are from the yarns over a range of strains.

Casafranca et al. 2020 (section 7) estimate the parameters of the triangles so that energies agree under uniform stretch
and bending. Here a law with constant moduli and one with tables of tension are fitted (``fitted_material``), and the
tables are kept where they decrease the mismatch enough.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import ParameterError
from stitchmesh.io.contents import FilePath
from stitchmesh.mixed.matching.cell_equilibrium import CellSolver
from stitchmesh.mixed.matching.cell_tests import run_tests
from stitchmesh.mixed.matching.fitted_material import fit_linear, fit_tables
from stitchmesh.mixed.matching.loading_curve import BENDS, LoadingCurve
from stitchmesh.mixed.matching.triangle_response import respond
from stitchmesh.mixed.matching.yarn_cell import YarnCell
from stitchmesh.mixed.triangles.cloth_material import ClothMaterial

Numbers = NDArray[np.float64]
STRAINS = (-0.05, -0.02, 0.02, 0.05, 0.1, 0.15, 0.2)
"""Strains of the tests."""
CURVATURES = (-1.0, -0.5, 0.5, 1.0)
"""Curvatures of the tests [1/cm]."""
WORTH = 0.8
"""Largest mismatch of stretch with tables over that of the linear law with which tables are kept."""
CLOSE = 0.01
"""Mismatch of the linear law up to which tables are not needed."""


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
        """The one to use: with tables if these decrease the mismatch of stretch by a fifth or more, from above 1 %."""
        linear, tables = self.stretch_mismatch(self.linear), self.stretch_mismatch(self.tables)
        return self.tables if linear > CLOSE and tables < WORTH * linear else self.linear

    def mismatch(self, material: ClothMaterial) -> dict[str, float]:
        """Relative difference of a material in each test: root mean square over the strains of |dT| / |T|.

        T is the pair of tension and side tension of the yarns beyond those at rest.
        """
        return {curve.test: float(np.sqrt((_differences(material, curve) ** 2).mean())) for curve in self.curves}

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
    report: Callable[[str], None] = lambda _test: None,
) -> ClothMatch:
    """Fit the stiffnesses of triangles to a fabric of crossing yarns.

    Args:
        cell: the repeat of the fabric.
        name: name of the material.
        strains: strains of the tests of stretch and of shear [-, rad].
        curvatures: curvatures of the tests of bending [1/cm].
        report: called with the name of each test before it runs.

    Raises:
        ParameterError: strains or curvatures are missing or out of range.
        SolverError: a state of the cell finds no equilibrium; smaller strains help.
    """
    curves = run_tests(CellSolver(cell), strains, curvatures, report)
    width, height = cell.period
    source = f"fitted to {cell.node_count} crossings on {width:g} x {height:g} cm of yarn"
    match = match_curves(curves, name=name, density=cell.density, source=source)
    linear, tables = (_damped(material, cell) for material in (match.linear, match.tables))
    return replace(match, linear=linear, tables=tables)


def match_curves(curves: Iterable[LoadingCurve], *, name: str, density: float, source: str = "") -> ClothMatch:
    """Fit the stiffnesses of triangles to tests of a fabric, whatever they come from.

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
    from stitchmesh.mixed.triangles.material_file import write_material

    write_material(path, match.material, notes=match.lines)


def _damped(material: ClothMaterial, cell: YarnCell) -> ClothMaterial:
    """The material with the damping of the yarns."""
    return replace(material, damping=cell.material.damping_stiffness, mass_damping=cell.material.damping_mass)


def _differences(material: ClothMaterial, curve: LoadingCurve) -> Numbers:
    """Relative difference at each strain that is not 0."""
    (tension, side), (own, own_side) = curve.rise, respond(material, curve)
    apart, size = np.hypot(own - tension, own_side - side), np.hypot(tension, side)
    loaded = curve.loaded
    smallest = np.finfo(np.float64).tiny
    result: Numbers = apart[loaded] / np.maximum(size[loaded], smallest)
    return result


def _rows(material: ClothMaterial, curve: LoadingCurve) -> list[str]:
    """The lines of one test."""
    tension, own = curve.rise[0], respond(material, curve)[0]
    part = np.zeros(len(tension))
    part[curve.loaded] = _differences(material, curve)
    return [
        f"{curve.test:<12} {strain:>8.3f} {yarns:>12.5g} {triangles:>12.5g} {100.0 * apart:>9.1f} %"
        for strain, yarns, triangles, apart in zip(curve.strain, tension, own, part, strict=True)
        if strain != 0.0
    ]
