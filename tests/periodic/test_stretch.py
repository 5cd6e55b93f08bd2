# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Stretch tests: sizes, tensions and work; refused arguments; the table, the plot and the command."""

from __future__ import annotations

import csv
import itertools
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from stitchmesh.cli.main import main
from stitchmesh.errors import ParameterError
from stitchmesh.periodic.relaxation import drawn_cell
from stitchmesh.periodic.relaxation.continuation import size_of
from stitchmesh.periodic.relaxation.drawn_cell import draw_without_friction
from stitchmesh.periodic.stretch import StretchCurve, StretchPath, stretch_test, write_stretch
from stitchmesh.quality import PRESETS
from stitchmesh.render.plots.stretch_plot import plot_stretch
from stitchmesh.yarnrelax import YarnMaterial
from stitchmesh.yarnrelax.relaxation_result import Relaxation
from tests.nightly import at_night
from tests.periodic.free_cells import from_generated_yarns

pytestmark = pytest.mark.usefixtures("first_state")
KALDOR = YarnMaterial.named("kaldor-simulation")
EXACT = replace(PRESETS["reference"], quadrature_points=5, tolerance=3e-5, largest_change=1e-5)
"""With fewer contact samples, contact spheres interlock, and the tension varies by the force of one sphere."""
MOST, STEPS = 0.2, 11
ENERGY = {"low": lambda strain: 1.0 + strain**2, "high": lambda strain: 1.02 + (strain - 0.15) ** 2}
"""Energies of the two shapes of a spring by the strain."""
CASES = [("wale", "held"), *at_night(("course", "free"), ("course", "held"), ("wale", "free"))]


def path_along(direction: str, most: float, **others: Any) -> StretchPath:
    """The path from the free size to a strain in a direction."""
    return StretchPath(**{direction: (0.0, most)}, **others)


@cache
def curve_of(direction: str, other: str) -> StretchCurve:
    """The stretch curve of stockinette in a direction, with the other size free or held."""
    path = path_along(direction, MOST, other=other, steps=STEPS)
    with from_generated_yarns():
        return stretch_test("stockinette", path, material=KALDOR, quality=EXACT, device="cpu")


@pytest.mark.parametrize(("direction", "other"), CASES)
def test_the_cell_has_the_sizes_of_the_given_strains(direction: str, other: str) -> None:
    curve = curve_of(direction, other)
    assert all(point.converged for point in curve.points)
    rest = dict(zip(("course", "wale"), size_of(curve.free.lattice), strict=True))
    sizes = {"course": curve.column("width"), "wale": curve.column("height")}
    across = "wale" if direction == "course" else "course"
    strain = np.linspace(0.0, MOST, STEPS)
    np.testing.assert_allclose(sizes[direction], (1.0 + strain) * rest[direction], rtol=1e-9)  # rounding
    if other == "held":
        np.testing.assert_allclose(sizes[across], rest[across], rtol=1e-9)
        assert curve.column(f"{across}_tension")[-1] > 1.0
    else:
        assert (np.diff(sizes[across]) < 0.0).all()  # the free size contracts
        assert np.abs(curve.column(f"{across}_tension")).max() < 0.01 * curve.tension.max()  # the residual is 1e-5


@pytest.mark.parametrize(("direction", "other"), CASES)
def test_tension_rises_and_is_the_slope_of_the_energy(direction: str, other: str) -> None:
    """Virtual work: the change of energy between two strains equals the integral of the tension (Simpson's rule)."""
    curve = curve_of(direction, other)
    strain, energy, tension = curve.column("strain"), curve.column("energy"), curve.tension
    assert abs(tension[0]) < 0.01 * tension[-1] and (np.diff(tension) > 0.0).all()
    work = (tension[:-2:2] + 4 * tension[1:-1:2] + tension[2::2]) / 3 * (strain[1] - strain[0])
    # third order in steps of 2 %: opening contacts bend the curve within a step, by a few percent at first
    np.testing.assert_allclose(energy[2::2] - energy[:-2:2], work, rtol=0.03, atol=0.01 * work.max())
    assert work.sum() == pytest.approx(energy[-1] - energy[0], rel=0.005)
    assert curve.snaps == []


@pytest.mark.nightly
def test_every_preset_gives_the_correct_tension() -> None:
    """The preset is refined: with the control points of ``draft`` the tensions would be 65 and 81 % too high."""
    for case, quality in (("course", "held"), "draft"), (("wale", "free"), "standard"):
        path = path_along(case[0], MOST, other=case[1], steps=3)
        curve = stretch_test("stockinette", path, material=KALDOR, quality=quality, device="cpu")
        # five contact samples for each segment, and longer steps, which may end in another state of rest of the loops
        np.testing.assert_allclose(curve.tension[1:], curve_of(*case).tension[[5, 10]], rtol=0.1)


@pytest.mark.nightly
def test_knits_have_the_published_order_of_stiffness_except_garter_along_the_wales() -> None:
    """Loops of 15 yarn diameters stretched by 45 % (Singal et al. 2024).

    Along the wales the order of seed and garter is reversed, because without friction the ridges of garter close.
    """
    tension: dict[str, dict[str, float]] = {"course": {}, "wale": {}}
    for direction, pattern in itertools.product(tension, ("stockinette", "garter", "seed", "rib1x1")):
        path = path_along(direction, 0.45, steps=2)
        curve = stretch_test(
            pattern, path, material=KALDOR, quality="standard", device="cpu", loop_length=15 * 0.25
        )  # fmt: skip
        tension[direction][pattern] = float(curve.tension[-1])
    # adjacent values differ by at least a tenth; the contacts of the preset cause errors of a few percent
    expected = {
        "course": ("stockinette", "garter", "seed", "rib1x1"),
        "wale": ("stockinette", "rib1x1", "seed", "garter"),
    }
    for direction, order in expected.items():
        found = [tension[direction][pattern] for pattern in order]
        assert all(after < 0.9 * before for before, after in itertools.pairwise(found)), direction


def test_a_weave_can_be_stretched_and_compressed() -> None:
    path = StretchPath(course=(0.02, -0.02), steps=2, other="held")
    curve = stretch_test("plain", path, material=KALDOR, quality="draft", device="cpu")
    assert curve.tension[0] > 0.0 > curve.tension[1]


@pytest.mark.decides
def test_a_rib_stays_a_rib_while_it_is_stretched() -> None:
    """In the whole repeat every second course falls over at 60 %, and the rib pushes instead of pulling."""
    curve = stretch_test("rib1x1", path_along("course", 0.6, steps=3), quality="draft", device="cpu")
    assert (np.diff(curve.tension) > 0.0).all()
    assert curve.column("height")[-1] > 0.8 * curve.column("height")[0]  # fallen over, a rib is half as high
    for state, point in zip(curve.states, curve.points, strict=True):  # the images of the smallest cell
        assert size_of(state.lattice) == pytest.approx((point.width, point.height), rel=1e-9)


def spring(drawn: Any, shape: Any, strain: float) -> Relaxation:
    """The spring at rest at a strain: it snaps above 0.25, and back below 0.05."""
    shape = "high" if strain > 0.25 else "low" if strain < 0.05 else shape
    report = {"energy": ENERGY[shape](strain), "residual": 0.0, "converged": True, "out_of_time": False}
    return Relaxation(shape, report, [])


@pytest.mark.parametrize(
    ("strains", "branches"),
    [
        ([0.0, 0.1, 0.2], [1, 1, 1]),
        ([0.0, 0.1, 0.2, 0.1, 0.0], [1, 1, 1, 1, 1]),
        ([0.0, 0.1, 0.2, 0.3, 0.4], [1, 1, 1, 2, 2]),
        ([0.0, 0.1, 0.2, 0.3, 0.2, 0.1, 0.0], [1, 1, 1, 2, 2, 2, 1]),
    ],
)
def test_a_shape_that_does_not_come_back_is_another_branch(
    strains: list[float], branches: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(drawn_cell, "relax_at", spring)
    monkeypatch.setattr(drawn_cell, "_tension", lambda drawn, yarns: (0.0, 0.0))
    cell: Any = type("Cell", (), {"free": "low"})()
    assert [state.branch for state in draw_without_friction(cell, strains)] == branches


def test_friction_takes_work_and_its_curve_has_a_branch_for_each_way() -> None:
    given: Any = {"material": KALDOR, "quality": "draft", "device": "cpu"}
    path = path_along("course", 0.1, steps=3)
    curve = stretch_test("stockinette", replace(path, cycles=1, friction=0.3), **given)
    assert curve.column("branch").tolist() == [1, 1, 1, 2, 2] and curve.snaps == []
    without = stretch_test("stockinette", path, **given).tension
    stretched, let_back = curve.tension[:3], curve.tension[:1:-1]
    assert (without[1:] < stretched[1:]).all() and (let_back[:-1] < stretched[:-1]).all()
    assert let_back[0] < -1.0  # a part of the stretch is held: at its first size the fabric pushes


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({}, "got neither of course and wale"),
        ({"course": (0.0, 0.1), "wale": (0.0, 0.1)}, "got both of course and wale"),
        ({"course": (-0.95, 0.1)}, "course: got -95 % to 10 %; expected strains of -90 % to 900 %"),
        ({"wale": (0.0, float("nan"))}, "wale: got 0 % to nan %"),
        ({"wale": (0.1, 0.1)}, "got 10 % twice"),
        ({"wale": (0.0, 0.1), "steps": 1}, "steps: got 1; expected at least 2"),
        ({"wale": (0.0, 0.1), "other": "loose"}, "other: got 'loose'; expected free or held"),
        ({"wale": (0.0, 0.1), "cycles": -1}, "cycles: got -1; expected at least 0"),
        ({"wale": (0.0, 0.1), "friction": 5.0}, r"friction: got coefficients \(5.0, 5.0\)"),
    ],
)
def test_bad_requests_are_refused(given: dict[str, Any], message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        StretchPath(**given)


def test_a_period_is_refused() -> None:
    with pytest.raises(ParameterError, match="period: got one for a stretch"):
        stretch_test("stockinette", path_along("wale", 0.1), device="cpu", period=(1.0, None))


def test_strains_include_both_ends() -> None:
    path = StretchPath(wale=(-0.1, 0.2), steps=4)
    assert path.direction == "wale"
    np.testing.assert_allclose(path.strains, [-0.1, 0.0, 0.1, 0.2], atol=1e-15)
    there = path_along("course", 0.5, steps=2)
    assert replace(there, cycles=1).strains.tolist() == [0.0, 0.5, 0.0]
    assert replace(there, cycles=2).strains.tolist() == [0.0, 0.5, 0.0, 0.5, 0.0]


def test_the_table_and_the_plot_hold_every_point(tmp_path: Path) -> None:
    curve = curve_of("wale", "held")
    write_stretch(tmp_path / "stretch.csv", curve)
    with open(tmp_path / "stretch.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["wale_tension_dyn_per_cm"]) for row in rows] == curve.tension.tolist()
    for row in rows:  # 1 N/m is 100,000 dyn per 100 cm
        newtons = float(row["wale_tension_newton_per_metre"])
        assert 1000 * newtons == pytest.approx(float(row["wale_tension_dyn_per_cm"]))
        assert (row["converged"], row["snapped"]) == ("True", "False")
    plot_stretch(curve, tmp_path / "stretch.png")
    with Image.open(tmp_path / "stretch.png") as picture:
        assert len(np.unique(np.asarray(picture.convert("RGB")).reshape(-1, 3), axis=0)) > 10


def test_the_command_writes_a_table_and_a_plot(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["stretch", "stockinette", "--course", "0:20%", "--wale", "held", "--steps", "3", "--device", "cpu"]
    assert main([*words, "--quality", "draft", "-o", str(tmp_path / "new")]) == 0
    with open(tmp_path / "new" / "stretch.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["strain"]) for row in rows] == pytest.approx([0.0, 0.1, 0.2])
    assert rows[0]["height_cm"] == rows[-1]["height_cm"]  # the height is held
    assert (tmp_path / "new" / "stretch.png").is_file()
    *states, ranges = capsys.readouterr().out.splitlines()
    assert len(states) == 3 and ranges.startswith("Not validated: the tension of stockinette along the courses with ")
    assert "the material stitchmesh is that of no measured yarn" in ranges


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ([], "got --course free and --wale free; expected a range"),
        (["--course", "0:10%", "--wale", "0:10%"], "got --course 0:10% and --wale 0:10%"),
        (["--course", "0:x"], "--course: got '0:x'; expected two strains"),
        (["--wale", "0:inf"], "--wale: got '0:inf'"),
        (["--course=-95%:0"], "course: got -95 % to 0 %"),
    ],
)
def test_the_command_prints_an_error_in_one_line(
    words: list[str], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["stretch", "stockinette", *words, "-o", str(tmp_path / "new")]) == 2
    assert not (tmp_path / "new").exists()
    errors = capsys.readouterr().err.splitlines()
    assert len(errors) == 1 and message in errors[0]
