# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A load that yarns cannot take at once is applied in steps, and the state of rest is one of the whole load."""

from __future__ import annotations

import logging
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stitchmesh.compute.device import device_named
from stitchmesh.errors import SolverError
from stitchmesh.io.checkpoint_file import previous_path, read_checkpoint
from stitchmesh.quality import PRESETS, Quality
from stitchmesh.run_control import RunControl
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import Relaxation, RelaxCell, YarnMaterial, relax_yarns
from stitchmesh.yarnrelax.checkpoint import Checkpoints
from stitchmesh.yarnrelax.linking.certificate import changed_pairs, doubled_linking
from stitchmesh.yarnrelax.load_path import LoadPath, StepInputs
from stitchmesh.yarnrelax.load_position import AT_ONCE, SMALLEST_STEP
from tests.yarnrelax.stockinette import periodic_patch, tube

STITCHMESH = YarnMaterial.named("stitchmesh")
FIFTH = 0.2
QUALITY = replace(PRESETS["draft"], max_iterations=20_000)


def short_tube() -> YarnSet:
    """A tube whose yarn is a fifth as long at rest as it is drawn."""
    yarns = tube(4, 6)
    return replace(yarns, rest_length=FIFTH * yarns.rest_length)


def relaxed(quality: Quality = QUALITY, **given: Any) -> Relaxation:
    return relax_yarns(short_tube(), quality=quality, device="cpu", **given)


@pytest.fixture(scope="module")
def fifth() -> Relaxation:
    return relaxed()


def same(first: Relaxation, second: Relaxation) -> bool:
    """Whether two results agree to the last bit, except for the seconds."""
    reports = [{**result.report, "seconds": 0.0} for result in (first, second)]
    histories = [[{**entry, "seconds": 0.0} for entry in result.history] for result in (first, second)]
    return np.array_equal(first.yarns.points, second.yarns.points) and reports[0] == reports[1] and (
        histories[0] == histories[1])  # fmt: skip


def test_a_fifth_of_the_rest_lengths_at_once_comes_to_rest(fifth: Relaxation) -> None:
    yarns = short_tube()
    assert fifth.report["converged"] and fifth.report["load_steps"]["share"] == 1.0
    assert fifth.report["load_steps"]["refused"] > 0 and "too close" in fifth.report["load_steps"]["reason"]
    np.testing.assert_array_equal(fifth.yarns.rest_length, yarns.rest_length)
    np.testing.assert_array_equal(fifth.yarns.radius, yarns.radius)
    assert fifth.report["max_strain"] < 0.01  # the yarn has followed: it was stretched by 400 % at the start
    assert len(changed_pairs(doubled_linking(yarns, device="cpu"), doubled_linking(fifth.yarns, device="cpu"))) == 0


def test_the_state_is_one_of_rest_without_steps_too(fifth: Relaxation) -> None:
    again = relax_yarns(fifth.yarns, quality=QUALITY, device="cpu")
    assert again.report["load_steps"] is None
    # the energy that is left to fall is far below the tolerance of the residual
    assert again.report["energy"] == pytest.approx(fifth.report["energy"], rel=1e-3)


def test_yarns_that_take_their_load_at_once_have_no_steps() -> None:
    given = {"quality": "draft", "device": "cpu", "cell": RelaxCell()}
    free, whole = (relax_yarns(periodic_patch(1, 1), load_steps=steps, **given) for steps in (False, True))
    assert free.report["load_steps"] is None and same(free, whole)


def test_without_steps_the_load_is_refused() -> None:
    with pytest.raises(SolverError, match=r"yarn \d .*: too close to yarn \d"):
        relaxed(load_steps=False)


def test_one_line_says_that_there_are_steps_and_why(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING):
        relaxed(replace(QUALITY, max_iterations=400))
    assert sum("the load is applied in steps, because" in line for line in caplog.messages) == 1


@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_a_relaxation_that_stops_within_a_step_is_resumed_to_the_same_bits(tmp_path: Path, precision: str) -> None:
    quality = replace(QUALITY, precision=precision, max_iterations=2000)
    whole = relaxed(quality)
    for most in (100, 420, 1200):
        folder = tmp_path / str(most)
        stopped = relaxed(replace(quality, max_iterations=most), checkpoint=Checkpoints(folder, 40))
        assert not stopped.report["converged"] and stopped.report["load_steps"]["share"] < 1.0
        newest = folder / "checkpoint.smc"
        assert read_checkpoint(newest).header["position"]["share"] < 1.0
        for path in (newest, previous_path(newest)):
            assert same(relaxed(quality, resume=path), whole)


def test_a_relaxation_that_stops_within_a_step_has_the_yarns_that_were_asked_for(caplog: Any) -> None:
    found = relaxed(replace(QUALITY, max_iterations=420))
    np.testing.assert_array_equal(found.yarns.rest_length, short_tube().rest_length)
    assert "of the load" in caplog.messages[-1] and "max_iterations" in caplog.messages[-1]


def test_a_user_stops_within_a_step() -> None:
    control: RunControl[YarnSet] = RunControl(watch=lambda shown: control.stop() if shown.iteration > 300 else None,
                                              seconds=0.0)  # fmt: skip
    found = relaxed(control=control)
    assert found.report["stopped"] and not found.report["converged"]
    assert found.report["load_steps"]["share"] < 1.0


def test_the_history_counts_iterations_through_all_steps(fifth: Relaxation) -> None:
    counts = [entry["iteration"] for entry in fifth.history]
    assert counts == sorted(counts) and counts[-1] == fifth.report["iterations"]


def test_a_contact_that_is_too_soft_is_refused_with_the_share_of_the_load() -> None:
    soft = replace(STITCHMESH, k_contact=1e-7 * STITCHMESH.k_contact)
    with pytest.raises(SolverError, match=r"the yarns took 0\.\d+ of the load \(k_contact x 1e-07\)") as caught:
        relax_yarns(periodic_patch(1, 1), material=soft, quality="draft", device="cpu", cell=RelaxCell())
    assert "\n" not in str(caught.value) and "k_contact (--stiffness)" in str(caught.value)


def path_of(yarns: YarnSet, material: YarnMaterial = STITCHMESH, cell: RelaxCell | None = None) -> LoadPath:
    return LoadPath(StepInputs(yarns, material, QUALITY, device_named("cpu"), cell=cell))


def test_the_path_begins_without_load_and_ends_with_the_inputs() -> None:
    stiff = replace(STITCHMESH, k_bend=1e4 * STITCHMESH.k_bend, k_contact=1e-4 * STITCHMESH.k_contact)
    path = path_of(short_tube(), stiff)
    first, last = path.inputs_at(replace(AT_ONCE, share=0.0)), path.inputs_at(AT_ONCE)
    np.testing.assert_allclose(first.yarns.strain, 0.0, atol=1e-12)  # rounding of the lengths
    assert first.material == STITCHMESH
    assert last is not None and last.material == stiff and last.quality == QUALITY
    np.testing.assert_array_equal(last.yarns.rest_length, short_tube().rest_length)


def test_half_of_the_path_is_the_geometric_mean() -> None:
    stiff = replace(STITCHMESH, k_bend=1e4 * STITCHMESH.k_bend)
    path = path_of(short_tube(), stiff, RelaxCell(8.0, None))
    ends = [path.inputs_at(replace(AT_ONCE, share=share)) for share in (0.0, 1.0)]
    half = path.inputs_at(replace(AT_ONCE, share=0.5))
    lengths = [end.yarns.rest_length for end in ends]
    np.testing.assert_allclose(half.yarns.rest_length**2, lengths[0] * lengths[1], rtol=1e-12)  # rounding
    assert half.material.k_bend == pytest.approx(1e2 * STITCHMESH.k_bend)
    assert half.cell == RelaxCell(4.0, None)


def test_thinner_yarn_at_the_start_has_the_material_of_its_radius() -> None:
    at = path_of(tube(4, 6)).inputs_at(replace(AT_ONCE, share=0.0, thin=0.6))
    np.testing.assert_allclose(at.yarns.radius, 0.6 * tube(4, 6).radius, rtol=1e-15)  # one product
    assert at.material == STITCHMESH.scaled(0.6)


def test_a_path_of_any_scale_of_stiffness_is_the_same() -> None:
    """All energies times one number: the yarns move as before."""
    many = {name: 1e3 * getattr(STITCHMESH, name) for name in ("k_len", "k_length", "k_bend", "k_contact")}
    at = replace(AT_ONCE, share=0.0)
    soft = path_of(tube(4, 6), replace(STITCHMESH, k_contact=1e-4 * STITCHMESH.k_contact)).inputs_at(at).material
    hard = replace(STITCHMESH, **many | {"k_contact": 1e-1 * STITCHMESH.k_contact})
    assert path_of(tube(4, 6), hard).inputs_at(at).material.k_contact == pytest.approx(1e3 * soft.k_contact)


def test_steps_become_longer_after_success_and_are_halved_after_a_refusal() -> None:
    yarns = tube(4, 6)
    at = replace(AT_ONCE, share=0.0).after_step(yarns, 300)
    assert (at.reached, at.share, at.steps, at.iterations) == (0.0, 0.25, 1, 300)
    half = at.after_refusal("too close", 340, began=True)
    assert half is not None and (half.reached, half.share, half.refusals) == (0.0, 0.125, 1)
    assert half.after_step(yarns, 640).share == pytest.approx(0.125 + 1.5 * 0.125)


def test_the_samples_are_doubled_where_the_smallest_step_is_refused_and_then_nothing_is_left() -> None:
    at, factors = replace(AT_ONCE, share=0.25, reached=0.0, points=np.zeros((1, 3))), [1]
    while True:
        following = at.after_refusal("too close", at.iterations + 20, began=True)
        if following is None:
            break
        assert following.share - 0.0 >= SMALLEST_STEP
        if following.finer != factors[-1]:
            factors.append(following.finer)
        at = following
    assert factors == [1, 2, 4, 8]


def test_yarns_that_start_too_close_get_more_samples_and_then_start_thinner() -> None:
    at, tried = AT_ONCE, []
    while at is not None:
        tried.append((at.share, at.finer, at.thin))
        at = at.after_refusal("too close", 0, began=False)
    assert tried[:4] == [(1.0, 1, 1.0), (1.0, 2, 1.0), (0.0, 2, 1.0), (0.0, 2, 0.6)]
    assert tried[-1][2] > 0.1


def test_yarn_that_starts_too_close_relaxes_from_thinner_yarn() -> None:
    """Two crossing yarns that overlap by 99.9 %: at draft, the contact samples cannot separate them."""
    place = np.linspace(-1.5, 1.5, 13)
    lower = np.stack([place, 0 * place, 0 * place], axis=1)
    upper = np.stack([0 * place, place, np.full(13, 1e-3 * 0.125)], axis=1)
    yarns = YarnSet.from_curves([lower, upper], closed=[False, False], radius=0.125)
    found = relax_yarns(yarns, quality="draft", device="cpu").report
    assert found["converged"] and found["min_distance_over_radius"] > 1.5


def test_loads_on_the_borders_of_a_cell_grow_in_steps() -> None:
    found = relax_yarns(periodic_patch(1, 1), quality="draft", device="cpu", cell=RelaxCell(1e4, 1e4, shear=False))
    assert found.report["load_steps"] is not None and found.report["converged"]
