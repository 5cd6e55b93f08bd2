# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Paths of loads with friction that are stopped in any step end in the same bits; others are refused."""

from __future__ import annotations

import shutil
from dataclasses import asdict, replace
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stitchmesh.compute.shared_work import Call
from stitchmesh.errors import FileError, ParameterError
from stitchmesh.io.checkpoint_file import CheckpointFile, read_checkpoint, write_checkpoint
from stitchmesh.periodic.relaxation.continuation import size_of
from stitchmesh.quality import PRESETS
from stitchmesh.run import QUIET, Checkpoints, Run
from stitchmesh.time_limit import TimeLimit, limited_to
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import RelaxCell, observer
from stitchmesh.yarnrelax.cell_stress import cell_stress
from stitchmesh.yarnrelax.friction.friction import Friction
from stitchmesh.yarnrelax.load_steps import LoadStep, StepAtRest, relax_through_steps
from stitchmesh.yarnrelax.model.material import YarnMaterial
from stitchmesh.yarnrelax.together.steps_together import group_of_steps, relax_group_through_steps
from tests.yarnrelax.stockinette import periodic_patch

YARNS = periodic_patch(1, 1)
STEPS = [LoadStep(wale=40.0), LoadStep(wale=10.0), LoadStep(), LoadStep(friction=0.3), LoadStep(friction=0.0)]


def relaxed(yarns: YarnSet = YARNS, steps: list[LoadStep] = STEPS, **options: Any) -> list[StepAtRest]:
    return relax_through_steps(
        yarns, steps, material=YarnMaterial.named(), device="cpu",
        **({"terms": [Friction(0.2)], "cell": RelaxCell(shear=False), "quality": PRESETS["draft"]} | options),
    )  # fmt: skip


def bits(found: list[StepAtRest]) -> list[dict[str, Any]]:
    """The steps without times; arrays as bytes, because a comparison of arrays has no truth."""
    steps = [asdict(replace(step, seconds=0.0, yarns=None)) for step in found]  # type: ignore[arg-type]
    for own, step in zip(steps, found, strict=True):
        assert step.yarns.lattice is not None
        own["history"] = [{**entry, "seconds": 0.0} for entry in own["history"]]
        own["yarns"] = step.yarns.points.tobytes(), step.yarns.lattice.periods.tobytes()
    return steps


@pytest.fixture(scope="module")
def checkpoints(tmp_path_factory):
    """The steps of a path, and all checkpoints that it has written, by the number of steps that had ended."""
    folder, written = tmp_path_factory.mktemp("steps"), dict[int, Path]()
    write_state = observer.write_state

    def write_and_copy(path, inputs, state):
        write_state(path, inputs, state)
        written[len(state.ended)] = Path(shutil.copy(path, folder / f"{len(state.ended)}.smc"))

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(observer, "write_state", write_and_copy)
        found = relaxed(run=Run(checkpoints=Checkpoints(folder, every=1)))
    return found, written


def test_a_path_that_is_stopped_in_any_step_ends_in_the_same_bits(checkpoints):
    found, written = checkpoints
    whole = bits(relaxed())
    assert bits(found) == whole
    assert sorted(written) == list(range(len(STEPS)))
    for path in written.values():
        assert bits(relaxed(run=Run(resume=path))) == whole


def test_borders_are_held_by_the_loads_that_act_on_them(checkpoints):
    """Friction is part of the balance: what it holds needs no load."""
    for step, load in zip(checkpoints[0], STEPS, strict=True):
        assert step.border_forces == pytest.approx((load.course, load.wale), abs=1.5)  # the residual is 1 % of 100 dyn


def test_a_cell_without_friction_that_is_drawn_is_held_by_its_stress():
    steps = [LoadStep(stretch=(1.05, 1.0), friction=0.0), LoadStep(stretch=(1.05, 1.0), friction=0.0)]
    last = relaxed(steps=steps, cell=RelaxCell(None, 0.0, shear=False))[-1]
    (width, height), (width0, _) = size_of(last.yarns.lattice), size_of(YARNS.lattice)
    assert width == pytest.approx(1.05**2 * width0, rel=1e-6)  # float32
    stress = cell_stress(last.yarns, YarnMaterial.named(), quadrature_points=3, contact_samples=3, device="cpu")
    # both are those of one state, in float32 and in float64, whose forces of some 1,000 dyn nearly cancel
    assert last.border_forces == pytest.approx((stress.course * height, stress.wale * width), abs=0.5)


def test_a_path_that_the_time_ends_goes_on_with_more_time(tmp_path):
    """The time is over after some questions for it; the step in which that happens is not taken for an ended one."""
    readings = count()
    with limited_to(TimeLimit(np.inf, clock=lambda: float(next(readings)))):
        relaxed()
    half, readings = next(readings) / 2, count()
    with limited_to(TimeLimit(half, clock=lambda: float(next(readings)))):
        first = relaxed(run=Run(checkpoints=Checkpoints(tmp_path, every=1000)))
    assert 0 < len(first) < len(STEPS)
    assert first[-1].out_of_time and not first[-1].converged and not any(step.out_of_time for step in first[:-1])
    assert bits(relaxed(run=Run(resume=tmp_path / "checkpoint.smc"))) == bits(relaxed())


@pytest.mark.parametrize(
    ("options", "message"),
    [({"steps": STEPS[:-1]}, "steps is"), ({"yarns": YARNS.with_radius(YARNS.radius * 0.9)}, "yarns.radius is")],
)
def test_a_checkpoint_of_another_path_is_refused(checkpoints, options, message):
    with pytest.raises(ParameterError, match=f"is of a relaxation that was given something else: {message}"):
        relaxed(run=Run(resume=checkpoints[1][2]), **options)


@pytest.mark.parametrize("terms", [[], [Friction(0.2), Friction(0.3)]])
def test_a_path_has_one_friction(terms):
    with pytest.raises(ParameterError, match="terms of friction; expected one Friction"):
        relaxed(terms=terms)


def test_a_checkpoint_without_the_arrays_of_an_ended_step_is_damaged(checkpoints, tmp_path):
    content = read_checkpoint(checkpoints[1][2])
    arrays = {name: array for name, array in content.arrays.items() if name != "ended 1.points"}
    write_checkpoint(tmp_path / "cut.smc", CheckpointFile(content.header, arrays))
    with pytest.raises(FileError, match=r"'ended 1\.points' of the checkpoint is missing; begin without it"):
        relaxed(run=Run(resume=tmp_path / "cut.smc"))


def test_cells_that_are_loaded_together_come_to_the_sizes_that_they_have_alone():
    """Each goes on by itself, until friction changes; steps differ by what is left at rest, a thousandth in both."""
    quality = replace(PRESETS["draft"], tolerance=1e-3, largest_change=1e-3)
    wider = [replace(step, course=30.0 * step.wale) for step in STEPS]
    calls = [
        Call.of(
            relax_through_steps, YARNS, steps, terms=[Friction(0.2)], material=YarnMaterial.named(),
            quality=quality, cell=RelaxCell(shear=False), device="cpu", run=QUIET,
        )
        for steps in (STEPS, wider)
    ]  # fmt: skip
    assert group_of_steps(calls[0], 0) == group_of_steps(calls[1], 1)
    for together, steps in zip(relax_group_through_steps(calls), (STEPS, wider), strict=True):
        assert isinstance(together, list)
        for one, other in zip(together, relaxed(steps=steps, quality=quality), strict=True):
            assert one.converged and other.converged
            assert size_of(one.yarns.lattice) == pytest.approx(size_of(other.yarns.lattice), rel=2e-3)
            assert one.border_forces == pytest.approx(other.border_forces, abs=1.5)
