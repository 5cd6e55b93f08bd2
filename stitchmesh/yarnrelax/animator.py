# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarns that a moving cloth carries: from one frame of the cloth to the next, on the device.

The yarns come to rest on the cloth of the first frame, and are bound to it (``motion.carried_points``). At a frame k,
let h_k be the places to which the cloth carries the control points, and Q_k their frames. The relaxed yarns x_k differ
from h_k by a correction, in the frames c_k = Q_k^T (x_k - h_k). It changes smoothly where the cloth moves smoothly, so
a frame begins at

    h_(k+1) + (1 - iterations / EFFORT) Q_(k+1) (c_k + AHEAD (c_k - c_(k-1)))

and the solver then does a fixed number of iterations, in which the garment keeps the shape h_(k+1)
(``energies.shape``). AHEAD = 1 would repeat what one frame leaves unfinished twice in the next one.

The correction fades, because a fabric has motions that are so soft that a relaxation ends long before they have.
Without fading, the frames would go on with these motions for as long as the animation lasts, and two frames of the same
cloth would differ. With it, yarns have at any frame done about EFFORT iterations, whatever the number for each frame
is. EFFORT is measured: with fewer, motions that a relaxation finds are lost; with more, yarns go beyond what it finds.

The yarns travel to the beginning of a frame along straight lines, as far as the guard allows (``motion.travel_guard``),
with new candidate lists after each travel. If the guard stops them, the shape that they keep is the same part of the
way from h_k to h_(k+1): contacts push them apart there, and they travel on after the iterations, up to ``ATTEMPTS``
times. A frame that is still not reached is missed; the next one begins where its yarns are. In the iterations the balls
of ``collision.step_limit`` keep yarns from passing through each other. So no yarn passes through another one at any
time between the first frame and the last one.

The iterations are done once more with shorter steps if they made the forces grow, and undone if they do so again: a
frame whose cloth stretches the yarns without measure is reported as not relaxed.

All iterations of a frame are launched at once, and the host reads one array after each travel and one at the end. It
says whether the lists were long enough; if not, the iterations are done again with longer ones.

Coordinates move with the cloth: the best rigid motion of all its vertices is taken out of every frame, so the yarns
follow a rigid motion of any size exactly, and single precision keeps its digits far from the origin.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.captured import CapturedLaunches, CopyArray
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.partial_sums import chunk_of, least_parts, parts_for
from stitchmesh.compute.precision import Scalar, Vec2, Vec3
from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.vertex_motion import MovingMesh, RigidPlace, best_rigid_place
from stitchmesh.quality import Quality
from stitchmesh.simulation.bodies.mesh_features import feature_topology
from stitchmesh.simulation.captures import Captures
from stitchmesh.simulation.term import check_arrays
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.collision.narrow_phase import WIDEST_MARGIN
from stitchmesh.yarnrelax.collision.step_limit import nearest_arcs
from stitchmesh.yarnrelax.constraints.borders import Borders, KeepBorders
from stitchmesh.yarnrelax.energies.shape import KeepShape, Shape
from stitchmesh.yarnrelax.model.material import YarnMaterial
from stitchmesh.yarnrelax.motion.carried_points import CarryingSurface, carried_place, direction_of, place_corners
from stitchmesh.yarnrelax.motion.travel_guard import LARGEST_NEED, PASSED, STEP, TravelGuard
from stitchmesh.yarnrelax.relaxation_loop import RelaxationLoop
from stitchmesh.yarnrelax.simulation import YarnSimulation
from stitchmesh.yarnrelax.solvers.lbfgs import LBFGS
from stitchmesh.yarnrelax.solvers.lbfgs_steps import FIRST_GRADIENT, LAST_GRADIENT
from stitchmesh.yarnrelax.solvers.solver import ASSESSMENT_INTERVAL

AHEAD = 0.8
"""Part of the change of a correction that is expected to happen again."""
EFFORT = 600
"""Iterations in which a correction fades."""
STRICTER = 0.1
"""Tolerances of the rest at the first frame, over those of the quality."""
TRAVELS = 12
"""Largest number of travels of an attempt; most frames need one."""
ATTEMPTS = 6
"""Times that the iterations of a frame are done if the guard stopped its travel."""
LISTS_LAST = 5
"""Iterations between two searches."""
NEAR_LISTS_LAST = 10
"""Iterations after which a search makes new near lists too; older ones would often have lost pairs."""
FIGURES = wp.constant(6)
"""Numbers that the host reads before the extremes of the searches: the progress of the guard, and those below."""
NEAREST, FORCE_BEFORE, FORCE_AFTER = wp.constant(3), wp.constant(4), wp.constant(5)
"""Numbers of the smallest distance of two yarns over their radius, and of the norms of the first and the last force."""
STEP_SCALES = 1.0, 0.25
"""Scales of the steps with which the iterations of a frame are tried, until they do not make the forces grow."""
LARGEST_GROWTH = 2.0
"""Growth of the forces with which the iterations of a frame are not accepted."""


@wp.func
def in_frame(vector: Vec3, across: Vec3, normal: Vec3) -> Any:
    """Coordinates of a vector in the frame with the directions ``across`` and ``normal``."""
    return type(vector)(wp.dot(vector, across), wp.dot(vector, wp.cross(normal, across)), wp.dot(vector, normal))


@kernel
def aim(
    # model
    place: wp.array[wp.int32],
    face: wp.array[wp.int32],
    weight: wp.array[Vec2],
    local: wp.array[Vec3],
    ahead: Scalar,
    kept: Scalar,
    # state in
    corners: wp.array[Vec3],
    normals: wp.array[Vec3],
    points: wp.array[Vec3],
    home: wp.array[Vec3],
    # state in and out
    across: wp.array[Vec3],
    normal: wp.array[Vec3],
    correction: wp.array[Vec3],
    # state out
    start: wp.array[Vec3],
    end: wp.array[Vec3],
    target: wp.array[Vec3],
    way: wp.array[Vec3],
) -> None:
    """Where the cloth carries each control point, its new frame, and its way there with the expected correction."""
    i = wp.tid()
    where, first, third = carried_place(corners, normals, place, face[i], weight[i], local[i])
    now = in_frame(points[i] - home[i], across[i], normal[i])
    expected = (now + (now - correction[i]) * ahead) * kept
    aimed = where + first * expected[0] + wp.cross(third, first) * expected[1] + third * expected[2]
    across[i] = first
    normal[i] = third
    correction[i] = now
    start[i] = home[i]
    end[i] = where
    target[i] = aimed
    way[i] = aimed - points[i]


@kernel
def set_home(
    # state in
    start: wp.array[Vec3],
    end: wp.array[Vec3],
    progress: wp.array[wp.float64],
    # state out
    home: wp.array[Vec3],
) -> None:
    """The place that each control point keeps, at the part of the way that is passed."""
    i = wp.tid()
    left = type(home[0][0])(wp.float64(1.0) - progress[PASSED])
    home[i] = end[i] + (start[i] - end[i]) * left


@kernel
def turn_patches(
    # model
    face_start: wp.array[wp.int32],
    face_vertex: wp.array[wp.int32],
    # state in
    vertices: wp.array[Vec3],
    # state out
    normal: wp.array[Vec3],
) -> None:
    """Unit normal of the stitch face at the centre of each patch; the last one where it has no area."""
    k = wp.tid()
    first, last = face_start[k], face_start[k + 1]
    total = type(vertices[0])()
    origin = vertices[face_vertex[first]]
    for c in range(first + 1, last - 1):
        total += wp.cross(vertices[face_vertex[c]] - origin, vertices[face_vertex[c + 1]] - origin)
    normal[k] = direction_of(total, normal[k])


@kernel
def move_rigidly(
    # model
    turn: wp.mat33d,
    shift: wp.vec3d,
    # state in
    points: wp.array[Vec3],
    # state out
    moved: wp.array[wp.vec3d],
) -> None:
    """Points after a rigid motion [cm], in double precision; ``turn`` holds the unit of the points too."""
    i = wp.tid()
    point = points[i]
    moved[i] = turn * wp.vec3d(wp.float64(point[0]), wp.float64(point[1]), wp.float64(point[2])) + shift


@kernel
def begin_figures(
    # state out
    progress: wp.array[wp.float64],
) -> None:
    """Set what the guard has noted about a frame to zero; one thread."""
    for k in range(3):
        progress[k] = wp.float64(0.0)


@kernel
def collect_figures(
    # state in
    progress: wp.array[wp.float64],
    least: wp.array2d[wp.float64],
    record: wp.array2d[wp.float64],
    extremes: wp.array2d[wp.float64],
    # state out
    figures: wp.array[wp.float64],
) -> None:
    """What the host reads, in one array: figures, and the extremes of the searches."""
    k = wp.tid()
    figures[FIGURES + k] = extremes[k // 4, k % 4]
    if k < 3:
        figures[k] = progress[k]
    if k == 3:
        nearest = wp.float64(2.0)
        for n in range(least.shape[0]):
            nearest = wp.min(nearest, least[n, 0])
        figures[NEAREST] = nearest
        figures[FORCE_BEFORE] = record[0, FIRST_GRADIENT]
        figures[FORCE_AFTER] = record[0, LAST_GRADIENT]


@dataclass(frozen=True, eq=False)
class AnimationInputs:
    """The inputs that decide an animation."""

    yarns: YarnSet
    """The relaxed yarns at the first frame of the cloth."""
    fabric: StitchMesh
    """The fabric from which they were generated."""
    cloth: MovingMesh
    """The moving surface of the fabric."""
    material: YarnMaterial
    quality: Quality
    iterations: int
    """Iterations of the solver in each frame."""
    device: wp.Device


@dataclass(frozen=True, eq=False)
class FrameFigures:
    """Figures of a frame."""

    passed: float
    """Part of the way from the frame before that the yarns have travelled; 1 if the frame is reached."""
    need: float
    """Largest approach of two arcs on a way, over the approach that the guard allows in one travel."""
    nearest: float
    """Smallest distance of two yarns over their radius, 2 if none touch."""
    travels: int
    """Number of travels."""
    attempts: int
    """Times that the iterations were done."""
    unrelaxed: bool
    """Whether the iterations made the forces grow, so that the yarns are where they had travelled to."""
    stopped_at: tuple[int, int] | None
    """Two control points of the arcs that stopped the last travel; None if the frame is reached."""


class Animator:
    """Yarns and a moving cloth on a device."""

    def __init__(self, inputs: AnimationInputs) -> None:
        """Bind the yarns to the cloth at its first frame.

        Raises:
            ParameterError: the yarns were not generated from the fabric.
            SolverError: yarns are too close to each other.
        """
        self.inputs, self.frame = inputs, 0
        choices = [KeepShape(inputs.fabric)], [KeepBorders(inputs.fabric)]
        self.simulation = simulation = YarnSimulation.start(
            inputs.yarns, inputs.material, inputs.quality, inputs.device, *choices
        )
        self.model, self.state = simulation.model, simulation.state
        self.place = RigidPlace(np.eye(3), np.zeros(3))
        """The rigid motion of the cloth since the first frame."""
        self._put_cloth()
        self._put_homes()
        self.guard = TravelGuard(self.model, self.state, simulation.candidates)
        self.nearest = self.model.empty(self.model.sample_count)
        self.least = parts_for(self.model.sample_count, inputs.device)
        count = int(FIGURES) + simulation.search.collected.size
        self.figures = wp.zeros(count, dtype=wp.float64, device=inputs.device)
        self._no_extremes = wp.array(simulation.search.no_extremes, dtype=wp.float64, device=inputs.device)
        self._before = wp.clone(self.state.points)
        self._captures = Captures(self, Animator._generations)
        self._hold()

    def come_to_rest(self, most: int) -> FrameFigures:
        """Relax the yarns on the cloth of the first frame, in at most a number of iterations, and hold them there.

        The tolerances are ``STRICTER`` times those of the quality: yarns that are not at rest go on settling in all
        frames, each of them by another amount.

        Raises:
            SolverError: the relaxation cannot continue.
        """
        quality, simulation = self.inputs.quality, self.simulation
        goal = STRICTER * quality.tolerance, STRICTER * quality.largest_change
        RelaxationLoop(simulation, *goal, by_newton=False).run(most)
        nearest = float(simulation.smallest_distances()[0])
        self._hold()
        return FrameFigures(1.0, 0.0, nearest, 0, 1, False, None)

    def advance(self) -> FrameFigures:
        """Carry the yarns to the next frame of the cloth, and relax them there.

        Raises:
            SolverError: the lists of near yarns do not fit the memory.
        """
        self.frame += 1
        self.place = self._place_cloth(self.frame)
        self._captured("begin", self._begin_launches).launch()
        travels, attempts, passed = 0, 0, 0.0
        while passed < 1.0 and attempts < ATTEMPTS:
            attempts += 1
            for _ in range(TRAVELS):
                passed, step = self._travel()
                travels += 1
                if passed == 1.0 or step == 0.0:
                    break
            read, unrelaxed = self._relax()
        stopped = None if passed == 1.0 else self.guard.stopping_points()
        need, nearest = float(read[LARGEST_NEED]), float(read[NEAREST])
        return FrameFigures(passed, need, nearest, travels, attempts, unrelaxed, stopped)

    def yarns(self) -> YarnSet:
        """The yarns at the present frame."""
        return self._yarns_at(self.state.points, self.place)

    def carried(self, frame: int) -> tuple[YarnSet, StitchMesh]:
        """The yarns of the first frame and the fabric where the cloth of a frame carries them, without relaxation."""
        model = self.model
        place = self._place_cloth(frame)
        self._corner_launch(model.launch)
        self.surface.launches(model.launch)
        points = model.empty(model.point_count, 3)
        self.bound.launch(points, model.empty(model.point_count, 3), model.empty(model.point_count, 3), model.launch)
        self.bound_fabric.launch(self.fabric_vertices, *self._spare, model.launch)
        vertices = self.fabric_vertices.numpy().astype(np.float64) * model.unit + model.cells[0].origin
        fabric = replace(self.inputs.fabric, vertices=place.moved(vertices))
        return self._yarns_at(points, place), fabric

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return everything that decides how the run continues after the present frame, by name."""
        return {name: array.numpy() for name, array in self._carried().items()}

    def resume(self, frame: int, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Continue after a frame of the same run.

        Raises:
            ParameterError: an array is missing or has another shape.
        """
        check_arrays({name: array.numpy().shape for name, array in self._carried().items()}, arrays)
        self.state.points.assign(arrays["rest"])
        self._hold()
        for name, array in self._carried().items():
            array.assign(arrays[name])
        self.frame = frame
        self.place = self._place_cloth(frame)
        self.simulation.search_contacts()

    def _yarns_at(self, points: wp.array[Any], place: RigidPlace) -> YarnSet:
        """The yarns with control points on the device [units], moved to a place."""
        model, origin = self.model, self.model.cells[0].origin
        turn, shift = wp.mat33d(*(place.rotation * model.unit).ravel()), wp.vec3d(*place.moved(origin))
        model.launch(move_rigidly, model.point_count, [turn, shift, points], [self.moved])
        return replace(self.inputs.yarns, points=self.moved.numpy())

    def _carried(self) -> dict[str, wp.array[Any]]:
        return {
            "rest": self.rest, "points": self.state.points, "home": self.home, "across": self.across,
            "normal": self.normal, "correction": self.correction, "patch_normal": self.shape.normal,
        }  # fmt: skip

    def _hold(self) -> None:
        """Bind the yarns to the cloth of the first frame where they are now, and hold the shape that they have."""
        for kept in (self.rest, self.home, self.borders.home):
            wp.copy(kept, self.state.points)
        self.bound = self.surface.bind(self.state.points)
        self.bound.launch(self.target, self.across, self.normal, self.model.launch)
        self.correction.zero_()
        self.simulation.search_contacts(WIDEST_MARGIN)  # the margin of all frames, whatever a relaxation has come to

    def _travel(self) -> tuple[float, float]:
        """Travel as far as the guard allows; return the part of the way that is passed, and the part of the step.

        The guard needs complete lists, so the host looks at them before the next travel.
        """
        self._captured("travel", self._travel_launches).launch()
        read = self.figures.numpy()
        if not self.simulation.search.extremes_hold(read[FIGURES:].reshape(-1, 4)):
            self.simulation.search.run()
        return float(read[PASSED]), float(read[STEP])

    def _relax(self) -> tuple[NDArray[np.float64], bool]:
        """Do the iterations; return the figures, and whether they were undone because they made the forces grow."""
        wp.copy(self._before, self.state.points)
        for scale in STEP_SCALES:
            read = self._iterate(scale)
            if np.isfinite(read[FORCE_AFTER]) and read[FORCE_AFTER] <= LARGEST_GROWTH * read[FORCE_BEFORE]:
                return read, False
            wp.copy(self.state.points, self._before)
            self.simulation.search.run()
        return read, True

    def _iterate(self, scale: float) -> NDArray[np.float64]:
        """Do the iterations with a scale of steps; do them again with longer lists if these were too short."""
        self._captured(("relax", scale, False), lambda: self._relax_launches(scale, broad=False)).launch()
        read: NDArray[np.float64] = self.figures.numpy()
        while not self.simulation.search.extremes_hold(read[FIGURES:].reshape(-1, 4)):
            wp.copy(self.state.points, self._before)
            self.simulation.search.run()
            self._captured(("relax", scale, True), lambda: self._relax_launches(scale, broad=True)).launch()
            read = self.figures.numpy()
        return read

    def _put_cloth(self) -> None:
        """Put the cloth of the first frame on the device, and bind the vertices of the fabric to it."""
        model, inputs = self.model, self.inputs
        topology = feature_topology(inputs.cloth.mesh)
        self.vertices = model.empty(len(inputs.cloth.mesh.vertices), 3)
        self.corner = model.integers(topology.corner.ravel())
        self.surface = CarryingSurface(model, topology, model.empty(len(self.corner), 3))
        self._place_cloth(0)
        self._corner_launch(model.launch)
        self.fabric_vertices = model.upload(model.to_device(inputs.fabric.vertices), 3)
        self.bound_fabric = self.surface.bind(self.fabric_vertices)

    def _put_homes(self) -> None:
        """Find the terms whose places move with the cloth, and allocate the arrays of the control points."""
        model, count = self.model, self.model.point_count
        shape, borders = self.simulation.terms[0], self.simulation.constraints[0]
        assert isinstance(shape, Shape)
        assert isinstance(borders, Borders)
        self.shape, self.borders = shape, borders
        self.home = shape.home
        """Where the cloth carries the control points [units], shape (N, 3)."""
        self.rest = model.empty(count, 3)
        """The control points at the first frame, where they are bound [units], shape (N, 3)."""
        self.moved = wp.empty(count, dtype=wp.vec3d, device=model.device)
        """The control points in space [cm], shape (N, 3)."""
        self.correction = model.empty(count, 3)
        """Correction of the last frame, in the frames of the points [units], shape (N, 3)."""
        self.start, self.end, self.target = (model.empty(count, 3) for _ in range(3))
        self.across, self.normal = model.empty(count, 3), model.empty(count, 3)
        fabric, centre = self.inputs.fabric, shape.centre
        sides = np.diff(fabric.face_start)[centre]
        first = np.cumsum(sides) - sides
        corners = np.repeat(fabric.face_start[centre] - first, sides) + np.arange(sides.sum())
        self.patch_start = model.integers(np.append(first, sides.sum()))
        self.patch_vertex = model.integers(fabric.face_vertex[corners])
        self._spare = model.empty(len(self.fabric_vertices), 3), model.empty(len(self.fabric_vertices), 3)

    def _place_cloth(self, frame: int) -> RigidPlace:
        """Send the vertices of a frame to the device, without the rigid motion since the first frame; return that."""
        places = self.inputs.cloth.motion.vertices
        place = best_rigid_place(places[0], places[frame])
        vertices = self.model.to_device(place.brought_back(places[frame]))
        self.vertices.assign(vertices.astype(wp.dtype_to_numpy(self.model.scalar)))
        return place

    def _corner_launch(self, launcher: Any) -> Any:
        return launcher(place_corners, len(self.corner), [self.corner, self.vertices], [self.surface.corners])

    def _begin_launches(self) -> list[Any]:
        """Return the launches that begin a frame: place the cloth, and find the ways."""
        prepare = self.model.prepare
        place, face, weight, local, *surface = self.bound.inputs
        numbers = [self.model.number(AHEAD), self.model.number(max(1.0 - self.inputs.iterations / EFFORT, 0.0))]
        inputs = [place, face, weight, local, *numbers, *surface, self.state.points, self.home]
        made = [self.across, self.normal, self.correction, self.start, self.end, self.target, self.guard.way]
        return [
            prepare(begin_figures, 1, [], [self.guard.progress]),
            self._corner_launch(prepare),
            *self.surface.launches(prepare),
            prepare(aim, self.model.point_count, inputs, made),
            self.bound_fabric.launch(self.fabric_vertices, *self._spare, prepare),
            prepare(turn_patches, len(self.shape.centre), [self.patch_start, self.patch_vertex, self.fabric_vertices],
                    [self.shape.normal]),
        ]  # fmt: skip

    def _travel_launches(self) -> list[Any]:
        """Return the launches of a travel, with new lists after it."""
        search = self.simulation.search
        return [
            CopyArray(self._no_extremes, search.extremes),
            *self.guard.launches(self.target),
            *search.unread_launches(broad=True),
            self._collect_launch(),
        ]

    def _relax_launches(self, scale: float, *, broad: bool) -> list[Any]:
        """Return the launches of all iterations of a frame; ``broad`` says whether each search makes new near lists."""
        simulation, search, iterations = self.simulation, self.simulation.search, self.inputs.iterations
        homes = [self.start, self.end, self.guard.progress]
        launches = [
            CopyArray(self._no_extremes, search.extremes),
            self.model.prepare(set_home, self.model.point_count, homes, [self.home]),
            CopyArray(self.home, self.borders.home),
        ]
        before = -iterations % int(ASSESSMENT_INTERVAL)  # the frame ends with the plain iterations of an interval
        launches.append(self._solver.anew_launch(before + iterations, before, scale, self.model.prepare))
        for done in range(iterations):
            if done and done % LISTS_LAST == 0:
                launches += search.unread_launches(broad=broad or done % NEAR_LISTS_LAST == 0)
            launches += simulation.iteration_launches()
        return [*launches, *search.unread_launches(broad=True), *self._distance_launches(), self._collect_launch()]

    def _distance_launches(self) -> list[Any]:
        """Return the launches that find the smallest distance of two yarns."""
        model, prepare, listed = self.model, self.model.prepare, self.simulation.candidates
        chunk = chunk_of(model.sample_count, model.device)
        arcs = [model.constants, self.state.samples, self.guard.half_tangent, listed.count, listed.lists]
        return [
            self.guard.arc_launch(),
            prepare(nearest_arcs, model.sample_count, arcs, [self.nearest]),
            prepare(least_parts, len(self.least), [chunk, self.nearest], [self.least]),
        ]

    def _collect_launch(self) -> Any:
        extremes = self.simulation.search.extremes
        inputs = [self.guard.progress, self.least, self._solver.memory.record, extremes]
        return self.model.prepare(collect_figures, extremes.size, inputs, [self.figures])

    @property
    def _solver(self) -> LBFGS:
        solver = self.simulation.solver
        assert isinstance(solver, LBFGS)
        return solver

    def _captured(self, name: Hashable, launches: Any) -> CapturedLaunches:
        return self._captures.get(name, lambda: CapturedLaunches(launches(), self.model.device), (self.bound,))

    def _generations(self) -> tuple[float, ...]:
        return self.simulation.search.generations()
