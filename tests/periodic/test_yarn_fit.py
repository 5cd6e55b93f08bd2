# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A fit gives the yarn of synthetic curves back, and says what curves do not tell; derivatives of tensions."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stitchmesh as sm
from stitchmesh.cli import main as cli
from stitchmesh.compute.device import device_named
from stitchmesh.errors import ParameterError
from stitchmesh.io.measured_curves import MeasuredCurve
from stitchmesh.io.yarn_files import read_yarn, write_yarn
from stitchmesh.periodic.fabric_response import FabricResponse, KnittedYarn, first_response
from stitchmesh.periodic.fit_settings import VALUES
from stitchmesh.periodic.relaxation.continuation import size_of
from stitchmesh.periodic.stretch import refine_for_tension
from stitchmesh.quality import quality_named
from stitchmesh.run import QUIET
from stitchmesh.yarn.yarn_description import YarnDescription
from stitchmesh.yarnrelax import RelaxCell, YarnMaterial
from stitchmesh.yarnrelax.cell_stress import cell_stress
from stitchmesh.yarnrelax.energies.term import INPUTS
from stitchmesh.yarnrelax.relaxation_inputs import RelaxationInputs
from stitchmesh.yarnrelax.rest_derivatives import polished, rest_derivatives
from tests.nightly import at_night, mostly_at_night

TRUE = YarnDescription(
    linear_density="400 tex", diameter="2 mm", core_diameter="1.2 mm", bending_rigidity="0.008 cN cm2",
    axial_stiffness="6 N", transverse_modulus="0.12 MPa", gauge="20",
)  # fmt: skip
DRAFT: dict[str, Any] = {"quality": "draft", "device": "cpu", "run": QUIET}
ENDS = {"course": 1.1, "wale": 0.5}
"""Strains up to which the yarn itself is stretched, so that its axial stiffness shows."""


@cache
def synthetic(noise: float = 0.0) -> tuple[tuple[MeasuredCurve, ...], str]:
    """Curves of the true yarn, by the stretch test, with relative noise; and its gauge."""
    yarn, random, curves = TRUE.yarn(), np.random.default_rng(1), []
    for direction, end in ENDS.items():
        path = sm.StretchPath(**{direction: (end / 5.0, end)}, steps=5)  # type: ignore[arg-type]
        drawn = sm.stretch_test(
            "stockinette", path, material=YarnMaterial.of_yarn(yarn), yarn_radius=yarn.core_radius,
            loop_length=yarn.loop_length, **DRAFT,
        )  # fmt: skip
        tension = drawn.tension * (1.0 + noise * random.standard_normal(5))
        curves.append(MeasuredCurve(drawn.direction, drawn.column("strain"), tension))
    gauge = drawn.free.report["gauge"]
    return tuple(curves), f"{gauge['stitches']:.6g}x{gauge['rows']:.6g}"


def start(bending: float, contact: float) -> YarnDescription:
    """The true yarn with other stiffnesses."""
    return replace(
        TRUE, bending_rigidity=f"{0.008 * bending} cN cm2", axial_stiffness=f"{6.0 * bending} N",
        transverse_modulus=f"{0.12 * contact} MPa",
    )  # fmt: skip


def true_values() -> dict[str, float]:
    yarn = TRUE.yarn()
    return {"bending_rigidity": 8.0, "axial_stiffness": 6e5, "transverse_modulus": 1.2e6, "core_diameter": 0.12,
            "loop_length": yarn.loop_length}  # fmt: skip


@pytest.mark.parametrize(("bending", "contact"), [(2.0, 0.5), *at_night((0.5, 2.0))])
def test_curves_give_the_stiffnesses_back(bending: float, contact: float) -> None:
    curves, _gauge = synthetic()
    fit = sm.fit_yarn(curves, "stockinette", yarn=start(bending, contact), tension_error=0.005, **DRAFT)
    assert fit.converged
    for name, expected in true_values().items():
        assert fit[name].value == pytest.approx(expected, rel=0.03)  # what is asked of a fit of exact curves
        assert fit[name].low <= expected * (1.0 + 1e-6) and expected * (1.0 - 1e-6) <= fit[name].high
    assert fit.error < 0.005 and not fit.cannot_tell


def test_intervals_of_noisy_curves_with_a_gauge_hold_all_values() -> None:
    curves, gauge = synthetic(0.01)
    fit = sm.fit_yarn(
        curves, "stockinette", yarn=start(1.2, 0.9), gauge=gauge, tension_error=0.01, size_error=0.003,
        fit=VALUES, **DRAFT,
    )  # fmt: skip
    for name, expected in true_values().items():
        assert fit[name].low < expected < fit[name].high
        assert fit[name].found
    assert fit["bending_rigidity"].high / fit["bending_rigidity"].low < 1.15
    np.testing.assert_allclose(fit.correlation.diagonal(), 1.0)
    assert fit.error < 0.02


def test_a_size_alone_gives_lengths_and_says_that_it_tells_no_stiffness() -> None:
    _curves, gauge = synthetic()
    fit = sm.fit_yarn((), "stockinette", yarn=start(1.0, 1.0), gauge=gauge, **DRAFT)
    assert [each.name for each in fit.values if each.found] == ["core_diameter", "loop_length"]
    blind = sm.fit_yarn(
        (), "stockinette", yarn=start(2.0, 2.0), gauge=gauge, fit=("bending_rigidity", "loop_length"), **DRAFT
    )  # fmt: skip
    assert len(blind.cannot_tell) == 1 and "multiplies bending_rigidity by" in blind.cannot_tell[0]
    assert blind["bending_rigidity"].high / blind["bending_rigidity"].low > 100.0


@cache
def response() -> FabricResponse:
    yarn = TRUE.yarn()
    curves = [MeasuredCurve("course", np.array([0.3]), np.ones(1)), MeasuredCurve("wale", np.array([0.2]), np.ones(1)),
              MeasuredCurve("wale", np.array([0.1]), np.ones(1), "held")]  # fmt: skip
    knitted = KnittedYarn(
        material=YarnMaterial.of_yarn(yarn), core_radius=yarn.core_radius, loop_length=yarn.loop_length
    )  # fmt: skip
    pattern = sm.resolve_pattern("rib1x1")
    assert isinstance(pattern, sm.Pattern)
    return first_response(pattern, knitted, curves, refine_for_tension(quality_named("draft")), "cpu")


def test_tensions_are_proportional_to_all_stiffnesses_and_scale_with_all_lengths() -> None:
    """With all lengths times g, EI times g^3, EA times g and the modulus over g, tensions stay, and sizes follow."""
    found, (bend, along, across, thick, loop) = response(), np.eye(len(VALUES))
    lengths = thick + loop + 3.0 * bend + along - across
    # differences of forces with steps of 1e-6
    np.testing.assert_allclose(found.tension_slopes @ (bend + along + across), found.tension, rtol=1e-6)
    np.testing.assert_allclose(found.tension_slopes @ lengths / found.tension, 0.0, atol=1e-4)
    np.testing.assert_allclose(found.size_slopes @ (bend + along + across), 0.0, atol=1e-7)
    np.testing.assert_allclose(found.size_slopes @ lengths, 1.0, rtol=1e-4)


@pytest.mark.parametrize("name", mostly_at_night([each for each in INPUTS if each != "planes"], by_day=["loop_length"]))
def test_reactions_are_the_differences_of_the_forces_at_held_strains(name: str) -> None:
    found, step = response(), 1e-5
    prepared, yarns, material = found.prepared, found.drawn[-1], found.yarn.material

    def at(factor: float) -> tuple[np.ndarray, Any]:
        changed, own = yarns, material
        if name == "loop_length":
            changed = replace(yarns, rest_length=factor * yarns.rest_length)
        elif name == "radius":
            changed = yarns.with_radius(factor * yarns.radius)
        else:
            own = replace(material, **{name: factor * getattr(material, name)})
        loop = polished(RelaxationInputs(changed, own, prepared.quality, device_named("cpu"), prepared.terms,
                                         cell=RelaxCell(None, None, shear=False)))  # fmt: skip
        rest = loop.simulation.good_yarns()
        stress = cell_stress(rest, own, quadrature_points=prepared.quality.quadrature_points,
                             contact_samples=prepared.quality.contact_samples, device="cpu")  # fmt: skip
        assert rest.lattice is not None
        width, height = size_of(rest.lattice)
        return width * height * np.array([stress.course, stress.wale]), loop.simulation

    reaction = rest_derivatives(at(1.0)[1]).reactions[name][:2]
    expected = -(at(1.0 + step)[0] - at(1.0 - step)[0]) / (2.0 * step)
    np.testing.assert_allclose(reaction, expected, rtol=1e-4)  # pairs of samples that begin to touch within the step


def test_the_description_of_a_fit_is_read_as_the_same_yarn(tmp_path: Path) -> None:
    write_yarn(tmp_path / "yarn.toml", TRUE)
    assert replace(read_yarn(tmp_path / "yarn.toml"), name="") == TRUE.yarn()


def test_the_command_writes_a_yarn_that_other_commands_take(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    curves, _gauge = synthetic()
    sm.write_measured_curves(tmp_path / "curve.csv", curves[1:])
    write_yarn(tmp_path / "start.toml", start(1.2, 1.2))
    out = tmp_path / "made" / "yarn.toml"
    words = ["fit", str(tmp_path / "curve.csv"), "--pattern", "stockinette", "--yarn", str(tmp_path / "start.toml"),
             "--fit", "bending_rigidity", "--strains", "2", "--quality", "draft", "--device", "cpu"]  # fmt: skip
    assert cli.main([*words, "-o", str(out)]) == 0
    printed = capsys.readouterr().out
    assert "bending_rigidity" in printed and "axial_stiffness    7.2 N, given" in printed
    assert {path.name for path in out.parent.iterdir() if path.suffix} == {"yarn.toml", "yarn.csv", "yarn.png"}
    assert (out.parent / "yarn.csv").read_text().startswith("direction,other,strain [%],load [N/m],fitted load [N/m]\n")
    assert cli.main(["yarn", "show", str(out)]) == 0
    assert cli.main([*words, "-o", str(tmp_path / "curve.txt")]) == 2
    assert "expected the name of a description" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ({"curves": ()}, "got no measurement"),
        ({"curves": (1,)}, "curves"),
        ({"pattern": "plain"}, "got a weave"),
        ({"fit": ("friction",)}, "got 'friction'; expected some of bending_rigidity"),
        ({"gauge": "many"}, "gauge: got 'many'"),
        ({"tension_error": 0.0}, "tension error: got 0"),
        ({"yarn": "woolly"}, "woolly"),
    ],
)
def test_wrong_arguments_are_refused_in_one_line(given: dict[str, Any], expected: str) -> None:
    curve = MeasuredCurve("wale", np.array([0.1]), np.array([1.0]))
    arguments = {"curves": (curve,), "pattern": "stockinette"} | DRAFT | given
    with pytest.raises(ParameterError, match=expected) as caught:
        sm.fit_yarn(**arguments)
    assert "\n" not in str(caught.value)
