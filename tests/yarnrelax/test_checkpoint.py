# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Resumed relaxations end in the same bits after any interruption. Checkpoints that do not match are refused."""

from __future__ import annotations

import shutil
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stitchmesh.errors import FileError, ParameterError
from stitchmesh.io.checkpoint_file import CheckpointFile, previous_path, read_checkpoint, write_checkpoint
from stitchmesh.mesh import Mesh
from stitchmesh.periodic.relaxation.continuation import stretch_cell
from stitchmesh.quality import PRESETS, Quality
from stitchmesh.run import Checkpoints, Run
from stitchmesh.simulation.dead_load import Gravity
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import Relaxation, RelaxCell, observer, relax_yarns
from stitchmesh.yarnrelax.assessment import Assessments
from stitchmesh.yarnrelax.constraints.pins import Pins
from stitchmesh.yarnrelax.energies.body import Body
from stitchmesh.yarnrelax.energies.twist import Twist
from stitchmesh.yarnrelax.friction.friction import Friction
from stitchmesh.yarnrelax.model.material import YarnMaterial
from stitchmesh.yarnrelax.newton_interval import STEP_COST
from stitchmesh.yarnrelax.relaxation_loop import RelaxationLoop
from stitchmesh.yarnrelax.simulation import YarnSimulation
from tests.yarnrelax.rings import ring
from tests.yarnrelax.stockinette import fabric_of, periodic_patch, tube

ROWS, STITCHES = 4, 6
QUALITY = replace(PRESETS["draft"], tolerance=1e-6, max_iterations=300)
"""Long enough for new candidate lists, changed margins and a full L-BFGS memory."""


def relaxed(quality: Quality = QUALITY, **options: Any) -> Relaxation:
    return relax_yarns(tube(ROWS, STITCHES), quality=quality, device="cpu", **options)


def same(first: Relaxation, second: Relaxation) -> bool:
    """Whether two results agree to the last bit, except for the seconds."""
    reports = [{**result.report, "seconds": 0.0} for result in (first, second)]
    histories = [[{**entry, "seconds": 0.0} for entry in result.history] for result in (first, second)]
    points = np.array_equal(first.yarns.points, second.yarns.points)
    return bool(points and reports[0] == reports[1] and histories[0] == histories[1])


@pytest.mark.parametrize(("solver", "precision"), [("quasistatic", "float64"), ("dynamics", "float32")])
def test_a_resumed_relaxation_ends_in_the_same_bits(tmp_path, solver, precision):
    quality = replace(QUALITY, max_iterations=120, solver=solver, precision=precision)
    options = {"material": YarnMaterial.named("leaf"), "terms": [Gravity()]}
    relaxed(replace(quality, max_iterations=60), run=Run(checkpoints=Checkpoints(tmp_path, 20)), **options)
    newest = tmp_path / "checkpoint.smc"
    whole = relaxed(quality, **options)
    for path, iteration in ((newest, 60), (previous_path(newest), 40)):
        assert read_checkpoint(path).header["iteration"] == iteration
        assert same(relaxed(quality, run=Run(resume=path), **options), whole)


def floor_below(yarns: YarnSet) -> Mesh:
    """A square whose normal points upwards, so near that gravity presses the yarns against it."""
    height = yarns.points[:, 1].min() - 0.15
    corners = [[-9, height, -9], [-9, height, 9], [9, height, 9], [9, height, -9]]
    return Mesh.from_polygons(corners, [[0, 1, 2, 3]])


def test_the_state_of_terms_is_resumed(tmp_path):
    """The yarns are twisted by more than a turn, which their positions alone do not say."""
    terms = [Gravity(), Friction(0.3), Twist(1.0, 8.0), Body(floor_below(tube(ROWS, STITCHES))), Pins([0, 5])]
    quality = replace(QUALITY, max_iterations=120)
    options = {"material": YarnMaterial.named("leaf"), "terms": terms}
    relaxed(replace(quality, max_iterations=80), run=Run(checkpoints=Checkpoints(tmp_path, 20)), **options)
    assert same(relaxed(quality, run=Run(resume=tmp_path / "checkpoint.smc"), **options), relaxed(quality, **options))


def test_the_step_scale_after_a_step_back_is_resumed(tmp_path, monkeypatch):
    # two assessments report an increased energy: the first one, and one after the checkpoint
    assess, count = YarnSimulation.assess_cells, iter(range(1000))

    def assess_with_increases(simulation: YarnSimulation, cells: np.ndarray | None = None) -> Assessments:
        found = assess(simulation, cells)
        if next(count) not in (1, 3):
            return found
        return replace(found, energies={name: 10.0 * energy for name, energy in found.energies.items()})

    monkeypatch.setattr(YarnSimulation, "assess_cells", assess_with_increases)
    uninterrupted = relaxed(replace(QUALITY, max_iterations=120))
    count = iter(range(1000))
    relaxed(replace(QUALITY, max_iterations=40), run=Run(checkpoints=Checkpoints(tmp_path, 20)))
    assert read_checkpoint(tmp_path / "checkpoint.smc").header["step_scale"] < 1.0
    again = relaxed(replace(QUALITY, max_iterations=120), run=Run(resume=tmp_path / "checkpoint.smc"))
    assert same(again, uninterrupted)


def test_a_finished_relaxation_is_resumed_to_the_same_result(tmp_path, monkeypatch):
    quality = replace(QUALITY, tolerance=0.02, max_iterations=20_000)
    options = {"quality": quality, "keep_shape": fabric_of(ROWS, STITCHES, closed=True)}
    uninterrupted = relaxed(run=Run(checkpoints=Checkpoints(tmp_path, 10_000)), **options)
    assert uninterrupted.report["converged"]
    monkeypatch.setattr(RelaxationLoop, "advance", None)  # no iteration and no Newton step may run
    again = relaxed(run=Run(resume=tmp_path / "checkpoint.smc"), **options)
    assert same(again, uninterrupted)
    assert again.report["seconds"] > uninterrupted.history[-1]["seconds"]


@pytest.mark.parametrize(
    ("yarns", "options", "precision"),
    [
        (periodic_patch(1, 1), {"cell": RelaxCell(), "terms": [Friction(0.3)]}, "float32"),
        (ring(1.5), {}, "float64"),
    ],
    ids=["a cell with friction", "a ring that leaves its plane"],
)
def test_a_relaxation_that_is_resumed_between_newton_steps_ends_in_the_same_bits(tmp_path, yarns, options, precision):
    """The first step of the ring moves away from a balance, without a force."""
    path, options = tmp_path / "checkpoint.smc", options | {"device": "cpu"}
    quality = replace(PRESETS["draft"], precision=precision, tolerance=1e-3, max_iterations=20_000)
    whole = relax_yarns(yarns, quality=quality, **options)
    assert whole.report["converged"]
    ends = [entry["iteration"] for entry in whole.history]
    steps = [end for before, end in pairwise(ends) if end - before == STEP_COST["cpu"]]
    assert len(steps) > 1
    for most in (steps[0] - STEP_COST["cpu"], steps[0], steps[-2]):
        stopped = replace(quality, max_iterations=most)
        relax_yarns(yarns, quality=stopped, run=Run(checkpoints=Checkpoints(tmp_path, 10_000)), **options)
        assert read_checkpoint(path).header["iteration"] == most
        assert same(relax_yarns(yarns, quality=quality, run=Run(resume=path), **options), whole)


def test_a_cell_that_has_strained_far_is_resumed_to_the_same_bits(tmp_path):
    """Its period has shrunk by a fifth: the lists are made again as they were at the periods of the last search."""
    yarns = stretch_cell(periodic_patch(1, 1), 1.0, 1.3)
    quality = replace(PRESETS["draft"], tolerance=1e-4, max_iterations=400)
    options = {"device": "cpu", "cell": RelaxCell()}
    kept = Run(checkpoints=Checkpoints(tmp_path, 10_000))
    whole = relax_yarns(yarns, quality=quality, **options)
    assert whole.yarns.lattice.periods[1, 1] < 0.8 * yarns.lattice.periods[1, 1]
    for most in (40, 80):
        relax_yarns(yarns, quality=replace(quality, max_iterations=most), run=kept, **options)
        resumed = relax_yarns(yarns, quality=quality, run=Run(resume=tmp_path / "checkpoint.smc"), **options)
        assert same(resumed, whole)


def test_checkpoints_are_written_at_assessments_with_at_least_the_given_interval(tmp_path, monkeypatch):
    written = []
    monkeypatch.setattr(observer, "write_state", lambda path, inputs, state: written.append(state.loop.iteration))
    relaxed(replace(QUALITY, max_iterations=140), run=Run(checkpoints=Checkpoints(tmp_path, 50)))
    assert written == [0, 60, 120, 140]


def test_an_interrupted_relaxation_writes_its_last_assessment(tmp_path, monkeypatch):
    quality = replace(QUALITY, max_iterations=120)
    uninterrupted = relaxed(quality)
    run, lengths = RelaxationLoop.iterate, iter([20, 20, 20, 7])

    def interrupted(loop: RelaxationLoop, count: np.ndarray) -> None:
        length = next(lengths)
        run(loop, length)
        if length < count[0]:
            raise KeyboardInterrupt

    with monkeypatch.context() as patch, pytest.raises(KeyboardInterrupt):
        patch.setattr(RelaxationLoop, "iterate", interrupted)
        relaxed(quality, run=Run(checkpoints=Checkpoints(tmp_path, 10_000)))
    assert read_checkpoint(tmp_path / "checkpoint.smc").header["iteration"] == 60
    assert same(relaxed(quality, run=Run(resume=tmp_path / "checkpoint.smc")), uninterrupted)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two checkpoints of a short relaxation."""
    folder = tmp_path_factory.mktemp("short")
    relaxed(replace(QUALITY, max_iterations=20), run=Run(checkpoints=Checkpoints(folder, 20)))
    return folder


def test_a_damaged_checkpoint_is_refused_and_the_previous_one_suggested(folder, tmp_path):
    path = Path(shutil.copytree(folder, tmp_path / "damaged")) / "checkpoint.smc"
    damaged = bytearray(path.read_bytes())
    damaged[len(damaged) // 2] ^= 1
    path.write_bytes(damaged)
    with pytest.raises(FileError, match=r"its checksum is wrong; .* use .*checkpoint\.previous\.smc$"):
        relaxed(run=Run(resume=path))
    quality = replace(QUALITY, max_iterations=40)
    assert same(relaxed(quality, run=Run(resume=previous_path(path))), relaxed(quality))


def test_a_checkpoint_of_another_relaxation_is_refused(folder):
    again, yarns = Run(resume=folder / "checkpoint.smc"), tube(ROWS, STITCHES)
    longer, fabric = replace(yarns, rest_length=1.1 * yarns.rest_length), fabric_of(ROWS, STITCHES, closed=True)
    material = YarnMaterial.named("kaldor-simulation")
    given = {
        "yarns.rest_length is": lambda: relax_yarns(longer, quality=QUALITY, device="cpu", run=again),
        "material.k_length is 0.0 and was 10000.0": lambda: relaxed(material=material, run=again),
        "quality.step_fraction is 0.1 and was 0.2;": lambda: relaxed(replace(QUALITY, step_fraction=0.1), run=again),
        "quality.solver is dynamics and was": lambda: relaxed(replace(QUALITY, solver="dynamics"), run=again),
        "term 0 is KeepShape and was absent": lambda: relaxed(keep_shape=fabric, run=again),
        "term 0 is Gravity and was absent": lambda: relaxed(terms=[Gravity()], run=again),
    }
    for message, resume in given.items():
        with pytest.raises(ParameterError, match=message) as caught:
            resume()
        assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("name", "other", "reason"),
    [
        ("listed_points", {}, "is missing"),
        ("points", {"points": np.zeros((3, 3), dtype=np.float32)}, r"has the shape \(3, 3\), expected \(\d+, 3\)"),
    ],
)
def test_a_checkpoint_whose_arrays_were_exchanged_is_refused(folder, tmp_path, name, other, reason):
    content = read_checkpoint(folder / "checkpoint.smc")
    arrays = {key: array for key, array in content.arrays.items() if key != name}
    write_checkpoint(tmp_path / "other.smc", CheckpointFile(content.header, arrays | other))
    with pytest.raises(ParameterError, match=f"resume: array '{name}' of the checkpoint {reason}"):
        relaxed(run=Run(resume=tmp_path / "other.smc"))


def test_an_older_checkpoint_with_masses_that_nothing_read_is_resumed(tmp_path):
    """Materials of other radii once had another mass; it decides nothing at rest without gravity."""
    few = replace(QUALITY, max_iterations=20)
    relaxed(few, run=Run(checkpoints=Checkpoints(tmp_path, every=20)))
    content = read_checkpoint(tmp_path / "checkpoint.smc")
    assert not [key for key in content.header["inputs"] if key.endswith("mass_per_length")]
    inputs = content.header["inputs"] | {"material.mass_per_length": "0.015"}
    write_checkpoint(tmp_path / "old.smc", CheckpointFile(content.header | {"inputs": inputs}, content.arrays))
    assert same(relaxed(few, run=Run(resume=tmp_path / "old.smc")), relaxed(few))


@pytest.mark.parametrize("options", [{"terms": [Gravity()]}, {"quality": replace(QUALITY, solver="dynamics")}])
def test_a_checkpoint_with_another_mass_is_refused_where_the_mass_decides(tmp_path, options):
    quality = replace(options.pop("quality", QUALITY), max_iterations=20)
    relaxed(quality, run=Run(checkpoints=Checkpoints(tmp_path, every=20)), **options)
    heavy = replace(tube(ROWS, STITCHES), mass_per_length=np.full(tube(ROWS, STITCHES).yarn_count, 0.01))
    with pytest.raises(ParameterError, match=r"yarns.mass_per_length is .* and was absent"):
        relax_yarns(heavy, quality=quality, device="cpu", run=Run(resume=tmp_path / "checkpoint.smc"), **options)
