# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Materials of triangles fitted to yarns: exact where the laws agree, and closed forms of a weave."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.mixed.crossings.crossing_material import CrossingMaterial, FabricMaterials
from stitchmesh.mixed.matching.cell_equilibrium import CellSolver
from stitchmesh.mixed.matching.cell_tests import BENDS, TESTS, LoadingCurve, run_tests
from stitchmesh.mixed.matching.cloth_match import (
    CURVATURES,
    STRAINS,
    ClothMatch,
    match_cloth,
    match_curves,
    write_match,
)
from stitchmesh.mixed.matching.fitted_material import respond
from stitchmesh.mixed.matching.yarn_cell import knit_cell, weave_cell
from stitchmesh.mixed.triangles.cloth_material import ClothMaterial
from stitchmesh.mixed.triangles.material_file import read_material

YARN = CrossingMaterial.named("gong-1")
ENDS, PICKS = 4.0, 5.0
KNIT = ClothMaterial("knit", 9e3, 5e3, 2e3, 0.35, 0.4, 0.2, 0.02, twist=0.15)
TABLE = ((-0.05, -40.0), (0.0, 0.0), (0.1, 300.0), (0.2, 1500.0))


@pytest.fixture(scope="module")
def weave() -> ClothMatch:
    return match_cloth(
        weave_cell([[1, 0], [0, 1]], ends=ENDS, picks=PICKS, materials=FabricMaterials.of(YARN)), name="plain"
    )


def curves_of(material: ClothMaterial, at_rest: float = 0.0) -> list[LoadingCurve]:
    """The tests of a material itself, with a tension at rest."""
    strain = np.unique([0.0, *STRAINS])
    empty = {test: LoadingCurve.of(test, strain, 0.0 * strain) for test in TESTS}
    found = {test: respond(material, curve) for test, curve in empty.items()}
    return [LoadingCurve.of(test, strain, tension + at_rest, side + at_rest) for test, (tension, side) in found.items()]


def test_a_linear_material_is_found_again() -> None:
    match = match_curves(curves_of(KNIT), name="knit", density=0.02)
    for name in ("stretch_course", "stretch_wale", "shear", "poisson", "bending_course", "bending_wale", "twist"):
        assert getattr(match.linear, name) == pytest.approx(getattr(KNIT, name), rel=1e-9), name  # rounding
    assert match.material is match.linear
    assert match.stretch_mismatch(match.linear) < 1e-9


def test_a_material_with_tables_is_found_again() -> None:
    strained = replace(KNIT, poisson=0.05, tension_course=TABLE, tension_wale=TABLE)
    strain = [point[0] for point in TABLE]
    curves = []
    for test in TESTS:
        curve = LoadingCurve.of(test, strain, np.zeros(4))
        curves.append(LoadingCurve.of(test, strain, *respond(strained, curve)))
    match = match_curves(curves, name="knit", density=0.02)
    assert match.material is match.tables
    assert np.allclose(match.tables.tension_course, TABLE, rtol=1e-9)
    # the coupling of the material, C_12, follows from the fitted moduli and the fitted poisson alike
    assert match.tables.moduli()[0, 1] == pytest.approx(strained.moduli()[0, 1], rel=1e-9)
    assert match.stretch_mismatch(match.tables) < 1e-9 < 0.1 < match.stretch_mismatch(match.linear)


def test_tension_at_rest_changes_nothing() -> None:
    one, other = (match_curves(curves_of(KNIT, tension), name="knit", density=0.02) for tension in (0.0, 250.0))
    assert one.linear.stretch_course == pytest.approx(other.linear.stretch_course, rel=1e-9)  # rounding
    assert one.linear.bending_course == pytest.approx(other.linear.bending_course, rel=1e-9)


def test_the_tension_of_a_weave_is_that_of_its_yarns(weave: ClothMatch) -> None:
    for axis, per_cm in (("course", PICKS), ("wale", ENDS)):
        table = np.array(getattr(weave.material, f"tension_{axis}"))
        assert np.allclose(table[:, 1], per_cm * YARN.stretch_stiffness * table[:, 0], rtol=1e-9, atol=1e-9)
    assert abs(weave.material.poisson) < 1e-9  # nodes of a plane have no Poisson effect


def test_the_shear_of_a_weave_is_that_of_its_crossings(weave: ClothMatch) -> None:
    modulus = 2.0 * YARN.shear * YARN.radius**2 * (ENDS + PICKS)
    # the yarns resist in proportion to the angle, the triangles to sin cos: 1 - 2/3 angle^2, on average 1 %
    assert weave.material.shear == pytest.approx(modulus, rel=0.02)


def test_the_bending_of_a_weave_is_that_of_its_yarns(weave: ClothMatch) -> None:
    # chords on a cylinder of radius 1 cm turn more than the arc by (L / R)^2 / 8 = 0.8 % for L = 2.5 mm
    assert weave.material.bending_course == pytest.approx(PICKS * YARN.bending_stiffness, rel=0.01)
    assert weave.material.bending_wale == pytest.approx(ENDS * YARN.bending_stiffness, rel=0.01)


def test_tables_pay_for_a_weave(weave: ClothMatch) -> None:
    assert weave.material is weave.tables
    # the law in Green strain is 17 % too soft at -5 % and 18 % too stiff at 20 %, that of shear fits both ways
    assert weave.stretch_mismatch(weave.linear) > 0.08
    assert weave.stretch_mismatch(weave.tables) < 0.01
    assert "kept: tables of tension" in str(weave)
    assert sum(line.startswith("course") for line in weave.lines) == len(STRAINS)
    assert sum(line.startswith("bend") for line in weave.lines) == len(BENDS) * len(CURVATURES)


@pytest.mark.parametrize(
    ("strains", "curvatures", "found"),
    [((), (1.0,), "strains"), ((0.1,), (np.nan,), "curvatures"), ((-1.0,), (1.0,), "above -1")],
)
def test_missing_or_impossible_strains_are_refused(strains: tuple, curvatures: tuple, found: str) -> None:
    solver = CellSolver(weave_cell([[1, 0], [0, 1]], ends=ENDS, picks=PICKS, materials=FabricMaterials.of(YARN)))
    with pytest.raises(ParameterError, match=found):
        run_tests(solver, strains, curvatures)


def test_missing_tests_are_refused() -> None:
    with pytest.raises(ParameterError, match="no test 'shear'"):
        match_curves([curve for curve in curves_of(KNIT) if curve.test != "shear"], name="knit", density=0.02)
    with pytest.raises(ParameterError, match="twice"):
        match_curves([*curves_of(KNIT), curves_of(KNIT)[0]], name="knit", density=0.02)


@pytest.mark.parametrize(
    ("strain", "tension", "found"),
    [
        ([0.1, 0.2], [1.0, 2.0], "one of them 0"),
        ([0.0, 0.1], [0.0, np.inf], "not finite"),
        ([0.0, 0.1], [0.0], "shapes"),
    ],
)
def test_curves_without_rest_or_numbers_are_refused(strain: list, tension: list, found: str) -> None:
    with pytest.raises(ParameterError, match=found):
        LoadingCurve.of("course", strain, tension, np.zeros(len(tension)))


def test_the_file_of_a_match_is_its_material_with_the_table_as_comments(weave: ClothMatch, tmp_path: Path) -> None:
    path = tmp_path / "plain.toml"
    write_match(path, weave)
    assert read_material(path) == weave.material
    text = path.read_text()
    assert all(f"# {line}".rstrip() in text for line in weave.lines)


def test_a_knit_that_is_held_by_friction_is_matched(tmp_path: Path) -> None:
    cell = knit_cell([[1]], wale_spacing=0.8, course_spacing=0.6, materials=FabricMaterials.of(YARN))
    match = match_cloth(cell, strains=(-0.02, 0.02), curvatures=(0.2,))
    assert match.material.stretch_wale > match.material.stretch_course
    assert 0.0 < match.material.poisson < 1.0
    assert "bend course" in match.lines[1]  # the curl, which triangles do not have
