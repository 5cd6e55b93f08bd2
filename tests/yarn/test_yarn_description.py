# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarns as mills and laboratories describe them."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import stitchmesh as sm
from stitchmesh.errors import FileError, ParameterError
from stitchmesh.io.yarn_files import read_yarn, yarn_of
from stitchmesh.recipe.recipe import recipe_options
from stitchmesh.yarn.quantities import LENGTH, LINEAR_DENSITY, PER_LENGTH, PRESSURE, RIGIDITY, in_cgs
from stitchmesh.yarn.yarn_description import LIBRARY
from stitchmesh.yarnrelax.model.material import pressure_of_parallel_yarns
from stitchmesh.yarnrelax.yarn_figures import yarn_figures
from tests.nightly import at_night
from tests.physics.test_yarn_closed_forms import straight

COTTON: dict[str, Any] = {"linear_density": "28.1 tex", "diameter": "0.169 mm", "tensile_modulus": "815 MPa",
                          "bending_rigidity": "0.0013 cN cm2"}  # fmt: skip


@pytest.mark.parametrize(
    ("text", "unit", "expected"),
    [
        ("1 tex", LINEAR_DENSITY, 1e-5),
        ("9 denier", LINEAR_DENSITY, 1e-5),
        ("10 dtex", LINEAR_DENSITY, 1e-5),
        ("2/28 Nm", LINEAR_DENSITY, 1e-2 / 14.0),  # 28 m of each of two plies weigh 1 g
        ("Nm 28/2", LINEAR_DENSITY, 1e-2 / 14.0),
        ("28/2 Nm", LINEAR_DENSITY, 1e-2 / 14.0),
        ("Nm 14", LINEAR_DENSITY, 1e-2 / 14.0),
        ("tex 72", LINEAR_DENSITY, 72e-5),
        ("20/2 Ne", LINEAR_DENSITY, 453.59237 / (10.0 * 840.0 * 91.44)),  # 840 yards of Ne 1 weigh a pound
        ("12 wpi", PER_LENGTH, 12.0 / 2.54),
        ("850/m", PER_LENGTH, 8.5),
        ("850 turns/m", PER_LENGTH, 8.5),
        ("22 um", LENGTH, 22e-4),
        ("815 MPa", PRESSURE, 8.15e9),
        ("0.004 cN cm2", RIGIDITY, 4.0),
        ("1e-9 N m^2", RIGIDITY, 1.0),
    ],
)
def test_units_of_the_trade(text: str, unit: str, expected: float) -> None:
    assert in_cgs(text, unit, "quantity") == pytest.approx(expected, rel=1e-9)  # pint's factors


@pytest.mark.parametrize("text", ["28 mm", "28", "tex", "-3 tex", "0 tex", "9**9 tex", "1/0 Nm", "3 ells", "nan tex"])
def test_other_texts_are_refused_in_one_line(text: str) -> None:
    with pytest.raises(ParameterError, match=r"linear_density: got .*for example 72 tex, 2/28 Nm") as caught:
        in_cgs(text, LINEAR_DENSITY, "linear_density")
    assert "\n" not in str(caught.value)


def test_a_monofilament_of_free_fibres_is_a_solid_rod() -> None:
    yarn = sm.Yarn.named("nylon-monofilament")
    assert yarn.mechanics is not None
    solid = yarn.mechanics.axial_stiffness * (2.0 * yarn.core_radius) ** 2 / 16.0  # E pi D^4 / 64 of E pi D^2 / 4
    # the fibre's modulus over density is 2.6 N/tex, the yarn's modulus 3 GPa at 1.14 g/cm^3
    assert yarn.mechanics.flexural_rigidity == pytest.approx(solid, rel=0.02)


def test_the_material_has_the_stiffnesses_of_the_yarn() -> None:
    yarn = sm.described_yarn(**COTTON, transverse_modulus="300 kPa")
    material = sm.YarnMaterial.of_yarn(yarn)
    area = math.pi * 0.0169**2 / 4.0
    assert material.axial_stiffness == pytest.approx(8.15e9 * area, rel=1e-9)
    assert material.flexural_rigidity == pytest.approx(1.3, rel=1e-9)
    assert material.transverse_modulus(yarn.core_radius) == pytest.approx(3e6, rel=1e-9)
    assert material.mass_per_length == pytest.approx(28.1e-5, rel=1e-9)


def test_a_torque_is_that_of_its_residual_twist() -> None:
    """M = 2 pi GJ tau, and Z twist is positive."""
    z_twist = sm.described_yarn(**COTTON, torsional_rigidity="0.5 cN mm2", residual_twist="120/m")
    assert z_twist.mechanics is not None and z_twist.mechanics.residual_twist == pytest.approx(1.2)
    assert sm.YarnMaterial.of_yarn(z_twist).torsional_rigidity == pytest.approx(5.0, rel=1e-9)
    torque = f"{-2.0 * math.pi * 5.0 * 1.2 * 1e-7} N m"
    s_twist = sm.described_yarn(**COTTON, torsional_rigidity="0.5 cN mm2", torque=torque)
    assert s_twist.mechanics is not None and s_twist.mechanics.residual_twist == pytest.approx(-1.2, rel=1e-9)
    shown = {figure.name: figure.value for figure in yarn_figures(s_twist)}
    assert shown["residual twist"] == "120 turns/m S" and shown["torque"].startswith("-3.77e+03 nN m")


def test_without_a_torsional_rigidity_a_yarn_is_a_solid_rod_in_torsion() -> None:
    yarn = sm.described_yarn(**COTTON, residual_twist=1.2)
    material = sm.YarnMaterial.of_yarn(yarn)
    assert material.torsional_rigidity == pytest.approx(2.0 / 3.0 * material.flexural_rigidity)
    assert material.changed({"k_twist": 0.1}).scaled(2.0).k_twist == pytest.approx(0.2)


def test_parallel_yarns_press_with_the_transverse_modulus() -> None:
    """The pressure between two straight yarns, from the forces of the simulation on the middle of one of them."""
    radius, distance = 0.125, 0.9
    lines = [straight((0.0, 1.0, 0.0), (0.0, 0.0, 0.0)), straight((0.0, 1.0, 0.0), (2.0 * radius * distance, 0.0, 0.0))]
    yarns = sm.YarnSet.from_curves(lines, closed=[False, False], radius=radius)
    material = sm.YarnMaterial(0.0, 0.0, 0.0, 3250.0, 0.0, 0.0, 0.0, 0.006)
    forces = sm.yarn_forces(yarns, material)
    middle = slice(len(lines[0]) // 2 - 5, len(lines[0]) // 2 + 5)
    spacing = abs(lines[0][1, 1] - lines[0][0, 1])
    pressure = -forces[middle, 0].mean() / spacing / (2.0 * radius)
    # samples along the yarn, a tenth of a radius apart
    assert pressure == pytest.approx(3250.0 * pressure_of_parallel_yarns(distance, radius), rel=0.01)


def test_a_named_yarn_is_a_material_for_its_radius() -> None:
    yarn = sm.Yarn.named("cotton-28-tex")
    by_name, own = sm.YarnMaterial.named("cotton-28-tex").of_radius(yarn.core_radius), sm.YarnMaterial.of_yarn(yarn)
    for name in ("axial_stiffness", "flexural_rigidity", "k_contact", "mass_per_length"):
        assert getattr(by_name, name) == pytest.approx(getattr(own, name), rel=1e-12)


def test_the_twist_angle_of_a_published_yarn_follows_from_its_diameter_and_twist() -> None:
    """Xiong et al. 2026 state 28.9 degrees for cotton of 28.1 tex with 10.4 turns/cm."""
    figures = {figure.name: figure.value + figure.meaning for figure in yarn_figures(sm.Yarn.named("cotton-28-tex"))}
    assert "28.9 degrees" in figures["twist"] and "28.1 tex" in figures["linear density"]


def test_a_file_with_a_curve_is_read_beside_itself(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text(
        'linear_density = "2/28 Nm"\nwraps = "60 wpi"\nfibre = "wool"\nfibre_diameter = "21 um"\n'
        'load_extension = "curve.csv"\nup_to = 2.0\n'
    )
    (tmp_path / "curve.csv").write_text("strain %,tension cN\n0,0\n1,15\n2,30\n10,400\n")
    yarn = yarn_of(str(tmp_path / "mine.toml"))
    assert yarn.mechanics is not None and yarn.name == "mine"
    assert yarn.mechanics.axial_stiffness == pytest.approx(1.5e6, rel=1e-12)  # 15 cN at 1 %
    assert yarn.apparent_radius == pytest.approx(2.54 / 60 / 2, rel=1e-12)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"diameter": None}, "diameter: got none; expected it, wraps, or fibre and packing"),
        ({"tensile_modulus": None}, "axial_stiffness: got none; expected it, tensile_modulus"),
        ({"bending_rigidity": None}, "bending_rigidity: got none"),
        ({"wraps": "12 wpi"}, "wraps: got one beside diameter; give one of the two"),
        ({"axial_stiffness": "3 N"}, "tensile_modulus: got one beside axial_stiffness"),
        ({"fibre": "wol", "fibre_diameter": "20 um"}, "fibre: got 'wol'; expected one of wool"),
        ({"load_extension": "x.csv", "tensile_modulus": None}, "load_extension: got 'x.csv'; expected pairs"),
        ({"load_extension": ((1.0, -2.0),), "tensile_modulus": None}, "tensions that fall"),
    ],
)
def test_descriptions_that_do_not_suffice_say_what_is_missing(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        sm.described_yarn(**{key: value for key, value in (COTTON | changes).items() if value is not None})


def test_unknown_keys_and_bad_files_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match="got 'colour'; expected name, linear_density"):
        sm.described_yarn(**COTTON, colour="red")
    with pytest.raises(ParameterError, match="linear_density: got none"):
        sm.described_yarn(diameter="1 mm")
    (tmp_path / "bad.toml").write_text('linear_density = "72 tex"\ncolour = "red"\n')
    with pytest.raises(FileError, match=r"bad\.toml: .*colour"):
        read_yarn(tmp_path / "bad.toml")
    with pytest.raises(ParameterError, match="yarn: got 'coton'; expected"):
        yarn_of("coton")


def test_a_recipe_finds_a_yarn_beside_itself_and_holds_its_values(tmp_path: Path) -> None:
    """A kept stage is made again when the description changes, because its options hold the values."""
    (tmp_path / "garment.toml").write_text('mesh = "hat"\nyarn = "mine.toml"\n')
    found = []
    for rigidity in (1.0, 2.0):
        (tmp_path / "mine.toml").write_text(
            f'linear_density = "72 tex"\ndiameter = "1 mm"\naxial_stiffness = "15 N"\nbending_rigidity = {rigidity}\n'
        )
        recipe = sm.read_recipe(tmp_path / "garment.toml")
        assert recipe.yarn == str(tmp_path / "mine.toml")
        found.append(recipe_options(recipe).relaxation.material)
    soft, stiff = found
    assert isinstance(soft, sm.YarnMaterial)
    assert stiff == replace(soft, k_bend=2.0 * soft.k_bend, k_contact=2.0 * soft.k_contact)


@pytest.mark.parametrize(("name", "least", "most"), [("cotton-28-tex", 5.0, 54.0), *at_night(("wool-2-28", 4.0, 54.0))])
def test_industrial_yarns_carry_as_much_as_measured_knits(name: str, least: float, most: float) -> None:
    """Wang et al. 2011 measured 5 to 54 N/m at 10 % for five knits, along both directions."""
    yarn = sm.Yarn.named(name)
    size = {"yarn_radius": yarn.core_radius, "loop_length": yarn.loop_length}
    for direction in ("course", "wale"):
        curve = sm.stretch_test(
            "stockinette", sm.StretchPath(**{direction: (0.0, 0.1)}, steps=2), quality="draft", device="cpu",
            material=sm.YarnMaterial.of_yarn(yarn), **size,
        )  # fmt: skip
        assert least < curve.tension[-1] / 1e3 < most


@pytest.mark.parametrize("name", ["dk", *at_night("lace", "super-bulky")])
def test_hand_knitting_yarns_come_to_their_gauge_with_their_own_stiffness(name: str) -> None:
    yarn = sm.Yarn.named(name)
    made = sm.swatch(
        "stockinette", relaxation="full", quality="draft", device="cpu", progress=False,
        material=sm.YarnMaterial.of_yarn(yarn), yarn_radius=yarn.core_radius, loop_length=yarn.loop_length,
    )  # fmt: skip
    found = (10.0 / made.report["wale_spacing"], 10.0 / made.report["course_spacing"])
    # the bar for gauges; draft is 0.5 % off
    assert found == pytest.approx((yarn.gauge.stitches, yarn.gauge.rows), rel=0.05)


@pytest.mark.parametrize("name", LIBRARY)
def test_each_measured_yarn_states_its_source_and_bends_no_less_than_its_fibres(name: str) -> None:
    yarn = sm.Yarn.named(name)
    assert yarn.mechanics is not None and len(yarn.mechanics.source) > 20
    assert yarn.mechanics.flexural_rigidity >= 0.99 * (yarn.mechanics.least_rigidity or 0.0)
    assert all(figure.good for figure in yarn_figures(yarn))
