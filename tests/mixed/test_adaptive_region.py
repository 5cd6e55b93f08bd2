# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Regions that a run chooses, and that grow and shrink while it goes on: what is kept, and what is resumed."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import warp as wp

from stitchmesh.compute.device import device_named
from stitchmesh.errors import ParameterError
from stitchmesh.io import read_yarns
from stitchmesh.mixed import automatic_region
from stitchmesh.mixed.automatic_region import node_budget, place_yarns, run_triangles
from stitchmesh.mixed.drape import Draped, drape
from stitchmesh.mixed.enrichment.region import TRIANGLES, YARNS, Region
from stitchmesh.mixed.memory import estimate_memory
from stitchmesh.mixed.placement.chosen_region import NodeBudget
from stitchmesh.mixed.region_change import momentum_about
from stitchmesh.mixed.scene.motion_section import AttachmentSection, BodySection, Keyframe
from stitchmesh.mixed.scene.region_section import BoxSection, RegionSection
from stitchmesh.mixed.scene.scene import (
    ClothSection,
    ContactSection,
    OutputSection,
    Scene,
    SceneSolverSection,
    YarnsSection,
)
from stitchmesh.mixed.scene.scene_fabric import PreparedScene, prepare, with_region
from stitchmesh.mixed.simulation import DynamicSimulation, StaticSimulation, begin_simulation
from stitchmesh.run import CHECKPOINT, Run
from tests.mixed.small_scene import stopping_after

CPU = device_named("cpu")
SIDE = 3.0
FLYING = Scene(
    cloth=ClothSection(rectangle=(SIDE, SIDE), edge_length=0.6),
    yarns=YarnsSection(weave="plain", ends=4.0, picks=4.0),
    region=RegionSection(yarns="chosen", faces=tuple(range(8))),
    mode="dynamic",
    duration=0.01,
    largest_step=0.002,
    disturbance=0.02,
    solver=SceneSolverSection(device="cpu", velocity_tolerance=0.1),
    output=OutputSection(picture=False),
)
"""A patch that falls freely, and swings because it is not flat."""
CORNER = AttachmentSection(
    boxes=(BoxSection(low=(-1.0, 2.0, -1.0), high=(1.0, 9.0, 1.0)),),
    keyframes=(Keyframe(time=0.0), Keyframe(time=0.01, displacement=(0.05, 0.0, 0.02))),
)


def moved(scene: Scene = FLYING, steps: int = 3) -> DynamicSimulation:
    simulation = begin_simulation(prepare(scene), wp.float64, CPU)
    assert isinstance(simulation, DynamicSimulation)
    for _ in range(steps):
        simulation.step()
    return simulation


def other_region(prepared: PreparedScene) -> Region:
    """A region that has lost some triangles, and has some more."""
    middle = prepared.fabric.cloth.rest.mean(axis=1)
    return with_region(prepared, np.flatnonzero((middle[:, 0] > 0.8) & (middle[:, 1] < 2.0))).region


def momentum(simulation: DynamicSimulation) -> np.ndarray:
    dynamics = simulation._dynamics
    dynamics.system.update_masses(dynamics.positions)
    return momentum_about(dynamics.system, dynamics.positions, dynamics.velocities, np.array([1.0, 2.0, 0.5]))


def test_both_momenta_are_kept() -> None:
    simulation = moved(replace(FLYING, attachments=(CORNER,)))
    before = momentum(simulation)
    simulation.change_region(other_region(simulation.prepared))
    assert np.abs(momentum(simulation) - before).max() < 1e-9 * np.abs(before).max()  # rounding of some 1,000 terms


def test_places_velocities_and_anchors_stay_where_nodes_stay() -> None:
    simulation = moved(replace(FLYING, attachments=(CORNER,)))
    old, terms = simulation.prepared.region, simulation._dynamics.system.terms
    before = simulation.positions
    kept = {term.name: {name: a.numpy() for name, a in term.carried_arrays().items()} for term in terms}
    new = other_region(simulation.prepared)
    stays = np.flatnonzero((old.node_kind == YARNS) & (new.node_kind == YARNS))
    stays = np.setdiff1d(stays, simulation.prepared.held[0].nodes)
    assert len(stays) >= 10
    simulation.change_region(new)
    here, there = new.node_number[stays], old.node_number[stays]
    assert np.array_equal(simulation.positions[1][here], before[1][there])
    for term in simulation._dynamics.system.terms:
        for name, array in term.carried_arrays().items():
            assert np.array_equal(array.numpy()[here], kept[term.name][name][there])
    names = {name for arrays in kept.values() for name in arrays}
    assert {"friction anchors", "yarn rest angles"} <= names


def marks(simulation: StaticSimulation) -> dict[str, np.ndarray]:
    """Eulerian coordinates, and what terms remember of each node."""
    found = {"sliding": simulation.positions[2]}
    for term in simulation._system.terms:
        found |= {name: array.numpy() for name, array in term.carried_arrays().items()}
    return found


def test_nodes_that_were_dropped_have_their_marks_again_also_in_a_resumed_run() -> None:
    simulation = StaticSimulation(prepare(replace(FLYING, mode="static")), wp.float64, CPU)
    small, large = other_region(simulation.prepared), simulation.prepared.region
    assert len(np.setdiff1d(large.nodes, small.nodes)) >= 10
    random, arrays = np.random.default_rng(17), [simulation._positions.sliding]
    arrays += [array for term in simulation._system.terms for array in term.carried_arrays().values()]
    for array in arrays:
        values = array.numpy()
        array.assign(values + random.normal(scale=0.01, size=values.shape))
    before = marks(simulation)
    assert {"sliding", "friction anchors", "yarn rest angles"} <= set(before)
    simulation.change_region(small)
    state = {name: array.copy() for name, array in simulation.arrays().items()}
    simulation = StaticSimulation(simulation.prepared, wp.float64, CPU)
    simulation.resume(state)
    simulation.change_region(large)
    for name, values in marks(simulation).items():
        assert np.array_equal(values, before[name])


def test_what_is_held_is_where_its_attachment_has_brought_it() -> None:
    simulation = moved(replace(FLYING, attachments=(CORNER,)))
    new = other_region(simulation.prepared)
    simulation.change_region(new)
    held = simulation.prepared.held[0]
    start = simulation.prepared.nodes
    own = new.node_number[held.nodes]
    own = own[own >= 0]
    assert len(own)
    wanted = held.motion.places_at(start[own], simulation.time)
    # the hybrid nodes around follow by a projection, which leaves what is fixed to rounding
    assert np.abs(simulation.positions[1][own] - wanted).max() < 1e-12


def test_anchors_on_a_body_stay() -> None:
    plate = BodySection(shape="box", centre=(1.5, 1.5, -0.54), size=(5.0, 5.0, 1.0))
    scene = replace(FLYING, bodies=(plate,), gravity=(2000.0, 0.0, -20000.0), disturbance=0.0, largest_step=5e-4)
    simulation = moved(replace(scene, contact=ContactSection(thickness=0.082)), 4)  # pressed on the plate
    before = next(term for term in simulation._dynamics.system.terms if term.name == "body friction").arrays()
    anchored = int((before["face"].numpy() >= 0).sum())
    assert anchored > 20
    simulation.change_region(with_region(simulation.prepared, np.zeros(0, dtype=np.int64)).region)
    after = next(term for term in simulation._dynamics.system.terms if term.name == "body friction").arrays()
    face, local = after["face"].numpy().copy(), after["local"].numpy().copy()
    assert (face >= 0).sum() > 10  # points on triangles keep theirs; those at nodes are gone
    known = {tuple(row) for row in before["local"].numpy()}
    assert all(tuple(row) in known for row in local[face >= 0])
    simulation.step()  # new points find theirs
    again = next(term for term in simulation._dynamics.system.terms if term.name == "body friction").arrays()
    assert (again["face"].numpy() >= 0).sum() > (face >= 0).sum()


def test_a_flat_cloth_at_rest_changes_its_region_without_energy() -> None:
    scene = replace(FLYING, disturbance=0.0, gravity=(0.0, 0.0, 0.0))
    simulation = moved(scene, 1)
    simulation.change_region(other_region(simulation.prepared))
    assert sum(simulation.energies().values()) < 1e-12
    assert np.abs(simulation.positions[0] - simulation.prepared.vertices).max() < 1e-9


SWINGING = replace(
    FLYING,
    region=RegionSection(yarns="automatic", nodes=90, adapt_every=2),
    attachments=(CORNER,),
    duration=0.016,
    gravity=(0.0, -981.0, 500.0),
    solver=replace(FLYING.solver, velocity_tolerance=1.0),
)


def kinds(run: Draped) -> list[int]:
    """Number of triangles with yarns in each frame."""
    return [int((frame.triangle_kind != TRIANGLES).sum()) for frame in run.frames]


def test_a_motion_begins_with_triangles_and_finds_its_region() -> None:
    run = drape(replace(SWINGING, output=replace(SWINGING.output, frames_per_second=250.0)))
    mixed = run.report["mixed"]
    assert kinds(run)[0] == 0
    assert kinds(run)[-1] > 0
    assert mixed["region_changes"] >= 1
    assert 0 < len(run.prepared.region.nodes) <= 90
    # Yarns laid on flat triangles are bent and stretched a little more than the triangles; see docs/mixed-solver.md.
    elastic = sum(value for name, value in mixed["energies"].items() if not name.startswith("gravity"))
    assert mixed["largest_energy_jump"] < 0.1 * elastic


def test_the_memory_is_that_of_the_largest_region(monkeypatch: pytest.MonkeyPatch) -> None:
    """A run that begins without yarns is refused if the nodes that it may have do not fit."""
    prepared = prepare(SWINGING)
    begins = estimate_memory(prepared.region, contact=False).total
    most = estimate_memory(prepared.region, contact=False, may_grow_to=90)
    assert most.total > begins + 90 * most.each_node - 1.0
    # no region has more than the nodes of the layout
    everywhere = estimate_memory(prepared.region, contact=False, may_grow_to=10**9)
    assert everywhere.total < estimate_memory(prepared.region, contact=True).total + 10**4 * everywhere.each_node
    monkeypatch.setattr("stitchmesh.mixed.drape.available_memory", lambda device: 0.5 * (begins + most.total))
    with pytest.raises(ParameterError, match="the scene with 90 yarn nodes needs"):
        drape(SWINGING)


def test_a_run_that_changes_its_region_resumes_to_the_same_bits(tmp_path: Path) -> None:
    whole = drape(SWINGING, tmp_path / "whole")
    folder = tmp_path / "cut"
    drape(SWINGING, folder, run=Run(control=stopping_after(5)))  # after the first change
    again = drape(SWINGING, folder, run=Run(resume=folder / CHECKPOINT))
    assert again.end.time == whole.end.time
    assert np.array_equal(again.end.triangle_kind, whole.end.triangle_kind)
    for name in ("vertices", "nodes", "sliding"):
        assert np.array_equal(getattr(again.end, name), getattr(whole.end, name))
    assert again.report["mixed"]["region_changes"] == whole.report["mixed"]["region_changes"]


def test_a_static_run_finds_its_equilibrium_again_with_yarns(tmp_path: Path) -> None:
    press = replace(CORNER, keyframes=(Keyframe(time=0.0), Keyframe(time=0.01, displacement=(0.2, -0.2, 0.1))))
    foot = AttachmentSection(boxes=(BoxSection(low=(-1.0, -1.0, -1.0), high=(9.0, 0.1, 1.0)),))
    region = RegionSection(yarns="automatic", nodes=100, adapt_every=1)
    scene = replace(SWINGING, mode="static", region=region, attachments=(press, foot), load_steps=1)
    scene = replace(scene, gravity=(0.0, 0.0, 0.0), solver=replace(scene.solver, force_tolerance=1.0))
    run = drape(scene, tmp_path)
    mixed = run.report["mixed"]
    assert mixed["converged"]
    assert len(run.frames) == 2  # the start and the equilibrium
    assert kinds(run)[0] == 0
    assert kinds(run)[1] > 0
    assert mixed["steps"] == 1 + mixed["region_changes"] == 2
    run.write(tmp_path)
    assert read_yarns(tmp_path / "animation.usdc").yarn_count == run.yarns.yarn_count
    from pxr import Usd, UsdGeom

    stage = Usd.Stage.Open(str(tmp_path / "animation.usdc"))
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath("/yarns/cloth"))
    for code in mesh.GetPointsAttr().GetTimeSamples():  # the topology of each frame fits its points
        corners = np.array(mesh.GetFaceVertexIndicesAttr().Get(code))
        assert corners.max() == len(mesh.GetPointsAttr().Get(code)) - 1


def test_a_time_is_turned_into_nodes_by_the_line_through_two_trials(monkeypatch: pytest.MonkeyPatch) -> None:
    timed = []

    def seconds(prepared: PreparedScene, _scalar: object, _device: object) -> float:
        nodes = len(prepared.region.nodes)
        timed.append(nodes)
        return 0.5 if nodes == 0 else 1.0 + 0.1 * nodes

    monkeypatch.setattr(automatic_region, "step_seconds", seconds)
    section = RegionSection(yarns="automatic", seconds=10.0)
    prepared = prepare(replace(FLYING, region=section))
    error = np.ones(len(prepared.fabric.cloth.triangles))
    assert node_budget(prepared, error, wp.float64, CPU).nodes == pytest.approx(90, abs=1)  # rounded down
    assert timed[0] == 0
    assert 0 < timed[1] < timed[2]
    with pytest.raises(ParameterError, match=r"region\.seconds: got 0\.4 s, and a step .* takes 0\.5"):
        node_budget(prepare(replace(FLYING, region=replace(section, seconds=0.4))), error, wp.float64, CPU)


@pytest.mark.parametrize("entries", [{"nodes": 5, "seconds": 1.0}, {"seconds": 0.0}, {"nodes": 5, "adapt_every": 0}])
def test_wrong_entries_are_refused(entries: dict[str, float]) -> None:
    with pytest.raises(ParameterError, match=r"region"):
        RegionSection(yarns="automatic", **entries)


def held(low: tuple[float, float], high: tuple[float, float], move: tuple[float, float, float]) -> AttachmentSection:
    box = BoxSection(low=(*low, -1.0), high=(*high, 1.0))
    return AttachmentSection(boxes=(box,), keyframes=(Keyframe(time=0.0), Keyframe(time=1.0, displacement=move)))


PUSHED = Scene(
    cloth=ClothSection(rectangle=(4.0, 4.0), edge_length=0.5),
    yarns=YarnsSection(weave="plain", ends=4.0, picks=4.0),
    region=RegionSection(yarns="automatic", nodes=120),
    gravity=(0.0, 0.0, 0.0),
    attachments=(held((-1.0, -1.0), (5.0, 0.1), (0.0, 0.0, 0.0)), held((2.9, 2.9), (5.0, 5.0), (0.0, -0.2, 0.0))),
    solver=SceneSolverSection(device="cpu", force_tolerance=1.0),
    output=OutputSection(picture=False),
)
"""A patch that is held along its lower side, and pressed down at its upper right corner."""


def placed(scene: Scene) -> PreparedScene:
    prepared = prepare(scene)
    error = run_triangles(prepared, wp.float64, CPU).error
    return place_yarns(prepared, error, NodeBudget(nodes=int(scene.region.nodes or 0)))


def test_the_region_keeps_to_its_nodes_and_lies_where_the_cloth_is_pressed() -> None:
    prepared = placed(PUSHED)
    assert 0 < len(prepared.region.nodes) <= 120
    full = prepared.region.triangle_alpha == 1.0
    assert prepared.fabric.cloth.rest.mean(axis=1)[full, 0].mean() > 2.0


def test_boxes_bound_the_region() -> None:
    box = BoxSection(low=(-1.0, -1.0, -1.0), high=(2.0, 5.0, 1.0))
    prepared = placed(replace(PUSHED, region=RegionSection(yarns="automatic", nodes=120, boxes=(box,))))
    full = prepared.region.triangle_alpha == 1.0
    assert (prepared.fabric.cloth.rest.mean(axis=1)[full, 0] < 2.0).all()


def test_too_few_nodes_are_refused() -> None:
    with pytest.raises(ParameterError, match="2 nodes hold no triangle"):
        placed(replace(PUSHED, region=RegionSection(yarns="automatic", nodes=2)))


@pytest.mark.parametrize(("yarns", "nodes"), [("automatic", None), ("automatic", 0), ("chosen", -1)])
def test_automatic_regions_need_a_number_of_nodes(yarns: str, nodes: int | None) -> None:
    with pytest.raises(ParameterError, match=r"region"):
        RegionSection(yarns=yarns, nodes=nodes)
