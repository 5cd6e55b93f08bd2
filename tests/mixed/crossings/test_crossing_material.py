# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Materials of crossing yarns: published values in CGS, files, and what is refused."""

from __future__ import annotations

from dataclasses import asdict, replace

import numpy as np
import pytest

from stitchmesh.errors import FileError, ParameterError
from stitchmesh.mixed.crossings.crossing_material import NAMED_FILE, CrossingMaterial

PUBLISHED = {
    "gong-1": (0.002, 5e5, 1.4e-4, 1000),
    "gong-2": (0.0025, 1.7e5, 1.1e-4, 700),
    "gong-3": (0.0024, 1.2e5, 9e-5, 200),
}
"""Density [kg/m], Y [Pa], B [N] and S [Pa] of Gong et al. 2022, for R = 0.5 mm, mu = 0.5, k_c = k_f = 1000 in SI."""


@pytest.mark.parametrize("name", PUBLISHED)
def test_named_yarns_are_the_published_ones_in_cgs(name):
    yarn = CrossingMaterial.named(name)
    density, young, bending, shear = PUBLISHED[name]
    radius = 0.5e-3
    assert yarn.radius == pytest.approx(radius * 100)
    assert yarn.density == pytest.approx(density * 1e3 / 1e2)
    # forces from SI: 1 N = 1e5 dyn; rigidity 1 N m^2 = 1e9 dyn cm^2
    assert yarn.stretch_stiffness == pytest.approx(young * np.pi * radius**2 * 1e5)
    assert yarn.bending_stiffness == pytest.approx(bending * np.pi * radius**2 * 1e9)
    assert yarn.shear * yarn.radius**2 == pytest.approx(shear * radius**2 * 1e5)
    assert yarn.contact == pytest.approx(1000 * 10) and yarn.friction_stiffness == pytest.approx(1000 * 1e3)
    assert yarn.friction == 0.5
    # as is stated in the file, with four digits at least
    assert yarn.wrapping == pytest.approx(yarn.bending_stiffness / (6 * yarn.radius) ** 2, rel=1e-3)
    assert yarn.stitch_length == pytest.approx(yarn.stretch_stiffness, rel=1e-3)


def test_a_file_of_the_user_is_read_like_that_of_the_package(tmp_path):
    path = tmp_path / "yarns.toml"
    path.write_text(NAMED_FILE.read_text().replace("[gong-1]", "[mine]"))
    assert CrossingMaterial.read(path, "mine") == CrossingMaterial.named("gong-1")


def test_an_unknown_name_is_answered_by_the_nearest_one():
    with pytest.raises(
        ParameterError, match="got 'gong1'; expected a name of the named materials: did you mean 'gong-1'"
    ):
        CrossingMaterial.named("gong1")


def test_values_out_of_range_are_refused():
    yarn = replace(CrossingMaterial.named(), bending=0.0, friction=0, yield_curvature=float("inf"))
    wrong = [(field, value) for field in asdict(yarn) for value in (-1.0, float("nan"), "soft", True)]
    for field, value in (*wrong, ("radius", 0.0), ("density", 0.0), ("young", 0.0), ("friction", float("inf"))):
        with pytest.raises(ParameterError, match=f"crossing material: {field} is"):
            replace(yarn, **{field: value})


def test_files_that_are_no_materials_are_refused_in_one_line(tmp_path):
    path = tmp_path / "yarns.toml"
    with pytest.raises(FileError, match="there is no such file; check the path"):
        CrossingMaterial.read(path, "mine")
    text = NAMED_FILE.read_text()
    for content, message in (
        ("radius = [", "no TOML"),
        ("radius = 1.0", "radius is 1.0; expected a table"),
        (text.replace("young = 5e6\n", ""), "material 'gong-1' has no young"),
        (text.replace("young = 5e6", "young = 5e6\ncolour = 1"), "material 'gong-1' has an unknown field colour"),
    ):
        path.write_text(content)
        with pytest.raises(FileError, match=message) as error:
            CrossingMaterial.read(path, "gong-1")
        assert "\n" not in str(error.value)
    path.write_text("")
    with pytest.raises(FileError, match="the file is empty"):
        CrossingMaterial.read(path, "mine")
    path.write_text("# no table\n")
    with pytest.raises(ParameterError, match="the file holds no material"):
        CrossingMaterial.read(path, "mine")


def test_finer_yarns_make_a_cloth_that_is_as_heavy_and_as_stiff():
    """n times as many yarns on each cm; the stitch contacts of a knit are n^2 times as many and 1 / n as long."""
    yarn, n = CrossingMaterial.named("gong-1"), 4.0
    fine = yarn.finer(n)
    for name in ("density", "stretch_stiffness", "bending_stiffness", "wrapping", "stitch_length"):
        assert n * getattr(fine, name) == pytest.approx(getattr(yarn, name), rel=1e-12), name
    assert n * fine.shear * fine.radius**2 == pytest.approx(yarn.shear * yarn.radius**2, rel=1e-12)
    assert fine.radius == yarn.radius / n and yarn.finer(1.0) == yarn
