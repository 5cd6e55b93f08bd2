# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Materials of cloth: moduli, measured materials by name, and files."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.errors import FileError, ParameterError
from stitchmesh.mixed.triangles.cloth_material import ClothMaterial
from stitchmesh.mixed.triangles.material_file import (
    material_names,
    material_of,
    named_material,
    read_material,
    write_material,
)

KNIT = ClothMaterial("knit", 1000.0, 3000.0, 400.0, 0.4, 5.0, 2.0, 0.02, twist=0.9, damping=0.01)


def test_the_moduli_are_the_inverse_of_the_compliance_of_strips():
    compliance = np.linalg.inv(KNIT.moduli())
    np.testing.assert_allclose(1.0 / np.diag(compliance), [1000.0, 3000.0, 400.0], rtol=1e-12)
    contraction = -compliance[1, 0] / compliance[0, 0]  # across the courses, of a strip along them
    assert contraction == pytest.approx(0.4 * 3.0**-0.5, rel=1e-12)
    np.testing.assert_allclose(1.0 / np.diag(np.linalg.inv(KNIT.rigidities())), [5.0, 2.0, 0.9], rtol=1e-12)


def test_an_isotropic_material_has_the_same_moduli_in_all_axes():
    material = ClothMaterial.isotropic("plate", 100.0, 0.25, 7.0, 0.02)
    angle = 0.3
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[c * c, s * s, c * s], [s * s, c * c, -c * s], [-2 * c * s, 2 * c * s, c * c - s * s]])
    for matrix in (material.moduli(), material.rigidities()):
        np.testing.assert_allclose(turn.T @ matrix @ turn, matrix, rtol=0, atol=1e-12 * matrix[0, 0])
    assert material.rigidities()[0, 0] == pytest.approx(7.0)  # the flexural rigidity D


def test_measured_materials_are_stable_and_of_the_size_of_cloth():
    for name in material_names():
        material = named_material(name)
        for matrix in (material.moduli(), material.rigidities()):
            assert np.linalg.eigvalsh(matrix)[0] > 0.0, name
        assert 0.01 < material.density < 0.04, name  # 100 to 400 g/m^2
        assert 5.0 < material.bending_course < 500.0, name  # Kawabata: 0.005 to 0.5 gf cm^2/cm for clothing


def test_a_measured_material_has_the_numbers_of_its_source():
    denim = named_material("Denim")
    moduli = denim.moduli()
    # twice 232.027634 and 1051.55712 N/m, the sum of 40.646339 and 40.917892 N/m, and 83.99202 N/m
    np.testing.assert_allclose(moduli[[0, 1, 0, 2], [0, 1, 1, 2]], [464055.268, 2103114.24, 81564.231, 83992.02])
    assert denim.density == pytest.approx(0.0324)  # 0.324 kg/m^2
    assert denim.bending_wale == pytest.approx(64.196457e-6 / 4.0 * 1e7)


def test_unknown_names_are_refused_with_the_nearest_one():
    with pytest.raises(ParameterError, match=r"material: got 'denin'; did you mean 'denim'\?"):
        named_material("denin")
    with pytest.raises(ParameterError, match="material: got 'xyz'; expected one of interlock, rib-knit"):
        material_of("xyz")


def test_files_keep_every_number(tmp_path):
    path = tmp_path / "cloth.toml"
    table = ((-0.1, -9000.0), (0.0, 0.0), (0.2, 123456.789e1))
    full = replace(KNIT, poisson=0.01, tension_course=table, shear_table=table[1:], source='a "b" \\ c')
    for one in (KNIT, full):
        write_material(path, one, ["how it fits: [table]", "two\nlines = 1"])
        assert read_material(path) == one and material_of(path) == one


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("name = ", "is no TOML"),
        ("name = 'a'", "needs 'stretch_course'"),
        (
            "name='a'\nstretch_course=1\nstretch_wale='x'\nshear=1\npoisson=0\nbending_course=1\nbending_wale=1\ndensity=1",
            'stretch_wale is "x"; expected a number',
        ),
        (
            "name='a'\nstretch_course=1\nstretch_wale=1\nshear=1\npoisson=1\nbending_course=1\nbending_wale=1\ndensity=1",
            "poisson is 1.0; expected between -1 and 1",
        ),
    ],
)
def test_wrong_files_are_refused_on_one_line(text, message, tmp_path):
    path = tmp_path / "cloth.toml"
    path.write_text(text)
    with pytest.raises(FileError, match=message) as error:
        read_material(path)
    assert "\n" not in str(error.value) and str(path) in str(error.value)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"stretch_course": 0.0}, "stretch_course is 0.0; expected a positive number"),
        ({"damping": -0.1}, "damping is -0.1; expected a not negative number"),
        ({"bending_poisson": -1.5}, "bending_poisson is -1.5; expected between -1 and 1"),
        ({"tension_wale": ((0.0, 0.0, 1.0), (0.1, 1.0))}, r"expected pairs of strain \(above -1\) and tension"),
        ({"shear_table": ((-0.1, -1.0), (0.0, 0.0))}, r"shear_table: begins with \(-0.1, -1.0\); expected \(0, 0\)"),
        ({"coupling_table": ((0.0, 0.0), (0.1, 1e4))}, "coupling_table and course: point 1 is not above point 0"),
        ({"tension_wale": ((0.0, 0.0),)}, "tension_wale: got 1 points; expected at least two"),
        ({"tension_wale": ((0.1, 1.0), (0.2, 2.0))}, r"no point is \(0, 0\)"),
        (
            {"tension_course": ((0.0, 0.0), (0.1, 1.0))},
            "the smallest stiffness of both axes is .* choose a smaller poisson",
        ),
    ],
)
def test_unstable_and_impossible_materials_are_refused(change, message):
    with pytest.raises(ParameterError, match=message) as error:
        replace(KNIT, **change)
    assert str(error.value).startswith("material 'knit': ")
