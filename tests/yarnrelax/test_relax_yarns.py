# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Whole relaxations: convergence, progress reports, reproducibility and bad input."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.compute.device import device_named
from stitchmesh.errors import ParameterError, SolverError
from stitchmesh.mesh import StitchMesh
from stitchmesh.quality import PRESETS
from stitchmesh.run import Run
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import YarnMaterial, observer, relax_yarns, yarn_energies
from stitchmesh.yarnrelax.constraints.borders import KeepBorders
from stitchmesh.yarnrelax.energies.shape import KeepShape
from stitchmesh.yarnrelax.relaxation_loop import SMALLEST_STEP_SCALE, RelaxationLoop
from stitchmesh.yarnrelax.simulation import YarnSimulation
from stitchmesh.yarnrelax.solvers.lbfgs_steps import PAIRS, STEP_SCALE
from tests.yarnrelax.stockinette import fabric_of, hopf_link, tube

DRAFT = PRESETS["draft"]
ROWS, STITCHES = 4, 6


@pytest.fixture(scope="module")
def knit() -> YarnSet:
    return tube(ROWS, STITCHES)


def test_a_knitted_tube_relaxes_to_rest_and_the_report_says_so(knit: YarnSet) -> None:
    result = relax_yarns(
        knit, quality=replace(DRAFT, tolerance=5e-3), device="cpu", keep_shape=fabric_of(ROWS, STITCHES, closed=True)
    )
    report = result.report
    assert report["converged"]
    assert report["residual"] < 5e-3
    assert report["pull_throughs"] == 0
    assert report["certificate"] == "unchanged"
    assert report["max_strain"] < 0.05
    assert 1.5 < report["min_distance_over_radius"] <= 2.0
    material = YarnMaterial.named("kaldor-simulation")
    start = sum(yarn_energies(knit, material, quadrature_points=3, contact_samples=3).values())
    assert report["energy"] < start


def test_the_result_does_not_depend_on_the_unit_of_length(knit: YarnSet) -> None:
    gamma = 1e3
    scaled = replace(knit, points=gamma * knit.points, rest_length=gamma * knit.rest_length, radius=gamma * knit.radius)
    quality = replace(DRAFT, precision="float64", tolerance=1e-6, max_iterations=40)
    small, large = (relax_yarns(yarns, quality=quality, device="cpu").yarns for yarns in (knit, scaled))
    # The rounding of float64 is 1e-15. The iterations amplify it by orders of magnitude, because this tube without
    # held borders curls.
    np.testing.assert_allclose(large.points / gamma, small.points, atol=1e-8)


def test_the_result_does_not_depend_on_the_distance_from_the_origin(knit: YarnSet) -> None:
    quality = replace(DRAFT, tolerance=1e-6, max_iterations=40)
    near = relax_yarns(knit, quality=quality, device="cpu").yarns.points
    away = replace(knit, points=knit.points + 1e4)
    far = relax_yarns(away, quality=quality, device="cpu").yarns.points - 1e4
    # At 1e4 cm, float64 rounds coordinates to 1e-12 cm. A float32 coordinate may then round to the neighbouring number,
    # 1e-7 cm away, and 40 iterations amplify this difference.
    np.testing.assert_allclose(far, near, atol=1e-4)


def started(yarns: YarnSet, material: YarnMaterial, fabric: StitchMesh | None = None) -> YarnSimulation:
    terms, constraints = ([KeepShape(fabric)], [KeepBorders(fabric)]) if fabric else ([], [])
    return YarnSimulation.start(yarns, material, DRAFT, device_named("cpu"), terms, constraints)


def kernels(simulation: YarnSimulation) -> set[str]:
    return {launch.kernel.key.split("__")[0] for launch in simulation.iterations.launches}


def test_terms_that_are_not_used_launch_no_kernel(knit: YarnSet) -> None:
    plain = kernels(started(knit, YarnMaterial.named("kaldor-simulation")))
    assert plain == {
        "samples_and_segment_forces",
        "contact_forces",
        "gather_forces",
        "find_preconditioner",
        "compare_forces",
        "update_memories",
        "apply_preconditioner",
        "update_directions",
        "propose_moves",
        "apply_moves",
    }
    fabric = fabric_of(ROWS, STITCHES, closed=True)
    full = kernels(started(knit, YarnMaterial.named("leaf"), fabric))
    added = {"clear_vectors", "displace_loops", "pull_patches", "add_shape_forces", "centre_forces", "hold_loops"}
    assert full - plain == added and plain <= full


def test_a_step_back_restores_the_last_accepted_state_and_clears_the_memory(knit: YarnSet) -> None:
    simulation = started(knit, YarnMaterial.named("kaldor-simulation"))
    loop, every = RelaxationLoop(simulation, tolerance=0.0), np.ones(1, dtype=bool)
    loop.iterate(20)
    loop.accept(every)
    good = simulation.good_yarns().points
    loop.iterate(20)
    loop.step_back(every)
    np.testing.assert_array_equal(simulation.state.points.numpy(), simulation.good_points.numpy())
    np.testing.assert_array_equal(simulation.good_yarns().points, good)
    assert loop.step_scale == 0.5
    pairs, scale = simulation.solver.arrays()["record"].numpy()[0, [PAIRS, STEP_SCALE]]
    assert pairs == 0 and scale == 0.5  # the memory holds no pairs of the rejected steps
    loop.iterate(20)
    assert simulation.assess_cells()[0].finite
    loop.accept(every)
    assert loop.step_scale == simulation.solver.arrays()["record"].numpy()[0, STEP_SCALE] == 0.6


def test_the_error_at_the_smallest_step_scale_names_energy_yarn_and_face(knit: YarnSet) -> None:
    simulation = started(knit, YarnMaterial.named("kaldor-simulation"))
    loop = RelaxationLoop(simulation, tolerance=0.0)
    loop.step_scale[:] = SMALLEST_STEP_SCALE / 2
    with pytest.raises(
        SolverError, match=r"(stretch|bend|contact) energy of yarn \d \(control point \d+, stitch face \d+\)"
    ):
        loop.step_back(np.ones(1, dtype=bool))


def test_a_keyboard_interrupt_passes_on_the_last_accepted_state(knit: YarnSet, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(observer, "PROGRESS_SECONDS", 0.0)
    states: list[YarnSet] = []

    def interrupt(stage: str, done: float, note: str) -> None:
        if note.startswith("iteration 40,"):
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        relax_yarns(
            knit, quality=replace(DRAFT, tolerance=1e-9), device="cpu", run=Run(interrupt, on_state=states.append)
        )
    expected = relax_yarns(knit, quality=replace(DRAFT, tolerance=1e-9, max_iterations=40), device="cpu").yarns
    assert np.array_equal(states[-1].points, expected.points)


def test_an_unfinished_relaxation_logs_a_warning(knit: YarnSet, caplog: pytest.LogCaptureFixture) -> None:
    result = relax_yarns(knit, quality=replace(DRAFT, tolerance=1e-9, max_iterations=20), device="cpu")
    assert not result.report["converged"]
    (record,) = caplog.records
    assert "yarns are not at rest" in record.message and "max_iterations" in record.message


def test_a_pull_through_is_detected_and_its_yarns_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    rings = hopf_link(1.0)
    rings = replace(rings, face=np.repeat([5, 8], np.diff(rings.start)))

    def pull_apart(loop: RelaxationLoop, count: np.ndarray) -> None:
        simulation = loop.simulation
        points = simulation.state.points.numpy()
        points[rings.start[1] :] += 40.0  # in radii; the second ring is now far from the first
        simulation.state.points.assign(points)
        simulation.search_contacts()

    monkeypatch.setattr(RelaxationLoop, "iterate", pull_apart)
    quality = replace(DRAFT, tolerance=1e-9, max_iterations=20)
    named = r"yarns 0 and 1 \(stitch faces \[5\] \.\.\. and \[8\] \.\.\.\): their linking number changed"
    with pytest.raises(SolverError, match=named):
        relax_yarns(rings, quality=quality, device="cpu")


def test_yarns_that_intersect_at_the_start_are_named() -> None:
    line = np.stack([np.arange(-1.0, 1.0, 0.2), np.zeros(10), np.zeros(10)], axis=1)
    crossing = YarnSet.from_curves([line, line[:, [1, 0, 2]]], closed=[False] * 2, radius=0.125)
    with pytest.raises(SolverError, match=r"yarn \d"):
        relax_yarns(crossing, quality=DRAFT, device="cpu")


@pytest.mark.parametrize("device", ["cuda:9", "tpu"])
def test_the_error_for_an_unknown_device_lists_the_known_devices(knit: YarnSet, device: str) -> None:
    with pytest.raises(ParameterError, match=f"device: got '{device}'; expected one of cpu") as caught:
        relax_yarns(knit, device=device)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("bad", [{"precision": "float16"}, {"quadrature_points": 0}, {"contact_samples": 0}])
def test_bad_sampling_is_refused(knit: YarnSet, bad: dict[str, object]) -> None:
    with pytest.raises(ParameterError, match=next(iter(bad))):
        yarn_energies(knit, YarnMaterial.named("leaf"), **bad)


@pytest.mark.parametrize("length", [1e5, 1e40])
def test_a_segment_that_is_far_longer_than_its_radius_is_refused(length: float) -> None:
    points = length * np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [3.0, 0.0, 0.0]])
    yarns = YarnSet.from_curves([points], closed=[False], radius=0.125)
    with pytest.raises(ParameterError, match="so long that it needs more than 10000 contact samples"):
        relax_yarns(yarns, quality="draft", device="cpu")
