# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Wind on yarns, on a swatch and on a draped cloth: one term in three simulations."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Literal

import numpy as np
import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.lattice import lattice_frame
from stitchmesh.mixed.assembly import fabric_masses
from stitchmesh.mixed.drape import drape
from stitchmesh.mixed.scene.scene_fabric import prepare
from stitchmesh.periodic.swatch import swatch
from stitchmesh.quality import PRESETS
from stitchmesh.run import Run
from stitchmesh.simulation.dead_load import EARTH
from stitchmesh.simulation.wind import AIR, DRAG, Wind
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import YarnMaterial, relax_yarns
from stitchmesh.yarnrelax.constraints.pins import Pins
from stitchmesh.yarnrelax.energies.confinement import STIFFNESS, Confinement
from stitchmesh.yarnrelax.model.material import carried_lengths
from tests.mixed.small_scene import SWINGING
from tests.yarnrelax.one_term import OneTerm, on_device

RADIUS = 0.1
SPEED = 400.0
PRESSURE = 0.5 * AIR * DRAG * SPEED**2


def straight(length: float = 6.0) -> YarnSet:
    """A straight yarn along x that is as long as it wants to be."""
    points = np.linspace(0.0, length, 13)[:, None] * [1.0, 0.0, 0.0]
    return YarnSet.from_curves([points], closed=[False], radius=RADIUS)


def test_a_yarn_catches_the_wind_with_its_diameter_times_its_length() -> None:
    yarns = straight()
    force = OneTerm.of(on_device(yarns), Wind((0.0, 0.0, SPEED))).forces().sum(axis=0)
    caught = PRESSURE * 2.0 * RADIUS * yarns.rest_length.sum()
    np.testing.assert_allclose(force, [0.0, 0.0, caught], rtol=1e-14)  # rounding of a sum of a dozen terms


def test_a_yarn_that_is_held_at_both_ends_bows_with_the_wind() -> None:
    yarns = straight()
    ends = Pins(points=[0, 1, len(yarns.points) - 2, len(yarns.points) - 1])
    quality = replace(PRESETS["reference"], max_iterations=4000)
    bow = relax_yarns(
        yarns, material=YarnMaterial.named("leaf"), quality=quality, device="cpu",
        terms=[Wind((0.0, SPEED, 0.0)), ends],
    ).yarns.points  # fmt: skip
    assert bow[3:-3, 1].min() > 0.0 and abs(bow[:, 2]).max() < 1e-6  # it leaves its line along the wind alone
    np.testing.assert_allclose(bow[:, 1], bow[::-1, 1], atol=1e-4 * np.ptp(bow[:, 1]))  # the tolerance of rest


def test_a_swatch_between_planes_leans_on_the_one_in_the_lee() -> None:
    terms = [Wind((0.0, 0.0, SPEED)), Confinement(0.12)]
    options: dict[str, Any] = {"quality": replace(PRESETS["draft"], tolerance=1e-4), "device": "cpu"}
    made = swatch("stockinette", relax_cell=False, progress=False, terms=terms, **options)
    assert made.at_rest is not None and made.report["converged"] and made.report["energies"]["wind"] != 0.0
    given, material = made.yarns, made.at_rest.material
    yarns = relax_yarns(given, material=material, terms=terms, **options).yarns
    assert yarns.lattice is not None
    normal = lattice_frame(yarns.lattice.periods)[2]
    height = (yarns.points - on_device(given).cells[0].origin) @ normal
    beyond = np.sign(height) * np.maximum(np.abs(height) - 0.12, 0.0)
    carried = carried_lengths(yarns.rest_length, yarns.segment_points, len(yarns.points))
    stiffness = STIFFNESS * material.k_bend / float(yarns.radius.mean()) ** 4
    caught = PRESSURE * normal[2] * 2.0 * (yarns.radius[yarns.point_yarn] * carried).sum()
    # the forces that are left are below the tolerance of the residual, of the forces between yarns
    assert (stiffness * carried * beyond).sum() == pytest.approx(caught, rel=0.02)


@pytest.mark.parametrize("yarns", ["none", "chosen"])
def test_on_a_hanging_cloth_a_wind_is_a_gravity(yarns: Literal["none", "chosen"]) -> None:
    """Vertices and nodes have areas in proportion to their masses; only the weight of yarn that slides differs."""
    scene = replace(SWINGING, mode="static", gravity=EARTH, region=replace(SWINGING.region, yarns=yarns))
    prepared = prepare(scene)
    mass = fabric_masses(prepared.fabric, prepared.region).total
    across = PRESSURE * float(prepared.fabric.cloth.rest_area.sum()) / mass
    blown = drape(scene, terms=[Wind((0.0, 0.0, SPEED))], run=Run(progress=False))
    tilted = drape(replace(scene, gravity=(0.0, -981.0, across)), run=Run(progress=False))
    assert blown.report["mixed"]["converged"] and "wind" in blown.report["mixed"]["energies"]
    expected = tilted.end.vertices[:, 2]
    assert expected.max() > 0.5
    # the tolerance of the forces; with yarns, those that slide in the wind also change their height
    np.testing.assert_allclose(blown.end.vertices[:, 2], expected, atol=(1e-4 if yarns == "none" else 1e-2) * 3.0)


@pytest.mark.parametrize("numbers", [(0.0, 300.0), (0.0, np.nan, 0.0), (0.0, 0.0, 2e4), 300.0])
def test_a_velocity_must_be_three_numbers_below_the_speed_of_a_storm(numbers: Any) -> None:
    with pytest.raises(ParameterError, match=r"wind: got velocity .* expected three numbers of at most 10000 cm/s"):
        Wind(numbers)


@pytest.mark.parametrize("choice", [Confinement(0.1), 3])
def test_a_cloth_takes_only_loads_that_act_on_it(choice: Any) -> None:
    with pytest.raises(ParameterError, match=r"drape, terms: got .*expected loads that act on cloth too, such as Wind"):
        drape(SWINGING, terms=[choice])


def test_a_load_on_a_swatch_needs_its_final_size() -> None:
    with pytest.raises(ParameterError, match=r"swatch, terms: got gamma 1.1, .*expected gamma 1"):
        swatch("stockinette", gamma=1.1, relax_cell=False, device="cpu", terms=[Wind((0.0, 0.0, SPEED))])
