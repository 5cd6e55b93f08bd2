# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Twist: the resistance of a yarn to rotation about its own centreline (Bergou 2008, Discrete Elastic Rods).

Twist spreads along a yarn faster than any other motion. In a state of rest it is therefore uniform along each yarn, and
one angle describes it (Bergou 2008, section 5.1, quasistatic material frames of an isotropic rod):

    E = k_twist theta^2 / L        [erg],    theta = imposed - (psi - psi_0)

with L the rest length. The torsional rigidity GJ is 2 k_twist, as the flexural rigidity EI is 2 k_bend. psi is the
rotation of a frame that is transported along the centreline without twist. psi_0 is the psi of the given yarns, whose
twist is the imposed one. The ends of a closed yarn stay joined, so its twist changes with its writhe,
d theta = -2 pi d writhe. The ends of an open yarn do not rotate about the given end tangents, which are clamped. The
force on a chord between knots,

    F = -dE / d chord = -(k_twist theta / L) (k_before + k_after) / |chord|

acts through the three legs of its segment with weights (1, 4, 1) / 6. The force on a straight yarn is zero.

A yarn with residual twist holds a torque M = GJ theta / L: if it hung free, it would untwist by ``residual`` turns for
each length. Right-handed twist is Z twist, and left-handed twist is S twist.

Yarn that runs through a periodic cell has as many turns in each repeat as in all others, so no turn passes from repeat
to repeat: the turns of a period are fixed. Where the yarn writhes, it loses as much twist. ``laid`` says from which
state these turns count. The yarn was laid straight, along its lattice step a, and then formed into loops, so psi is the
area that its tangent t encloses with a on the unit sphere (Fuller 1978, "Decomposition of the linking number of a
closed ribbon"): the sum over corners of the signed areas of the spherical triangles a, t, t'. This value does not
depend on the way on which the yarn came to its present shape, while t does not pass -a. For loops that are mirror
images of themselves it is zero.

The energy depends on the chords alone. In relaxing cells the twist therefore adds F chord^T to the virial
(``solvers.cell_strain``). A loop of stockinette that is sheared turns about itself, so that torque shears the cell: the
spirality of single jersey.

psi is the holonomy of the centreline. The yarn is represented by the polyline through its knots. The chord of this
polyline over a segment with legs d0, d1, d2 is (d0 + 4 d1 + d2) / 6. From chord to chord a frame turns by the smallest
rotation (Bergou 2008, section 4.2). For unit directions a, b this is the quaternion

    r = (1 + a . b, a x b) / |...|

Along a closed yarn, the frame returns to the first chord, rotated about this chord by psi. An open yarn has one more
chord at each end, in the direction of its clamp; a fixed rotation from the last clamp to the first closes the loop. In
both cases R = r_n ... r_2 r_1 is a rotation about the first chord, and psi = 2 atan2(R_vector . chord, R_scalar). The
formula gives psi up to multiples of 4 pi; the value nearest to the previous one is chosen.

When chords turn, psi changes by the curvature binormals k = 2 a x b / (1 + a . b) at the two corners of each chord
(Bergou 2008, eqs 9 and 10). This is exact also for large turns:

    d psi / d chord = -(k_before + k_after) / (2 |chord|)

The rotations of a long yarn are multiplied within strands of about the square root of their number, and then strand by
strand, always in the same order, in double precision.

The row sums of stiffness hold for yarns that bend to loops of two radii or larger. Take the moment M = 2 k_twist times
(|imposed| / L + 1 / (2 r)), chords of length l, and turns of l / (2 r) between them. A chord then gets the stiffness
2 M / l^2 from itself and its neighbours. From theta alone it gets 2 k_twist / L |d psi / d chord| times the sum of
|d psi / d chord| along the yarn.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.precision import Vec3, Vec9
from stitchmesh.errors import ParameterError, first_few
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.energies.cell_virial import add_leg_virial
from stitchmesh.yarnrelax.energies.term import YarnChoice, YarnTerm
from stitchmesh.yarnrelax.model.constants import CellConstants, Model, YarnConstants
from stitchmesh.yarnrelax.model.lattice_images import cell_of
from stitchmesh.yarnrelax.model.spline import segment_corners
from stitchmesh.yarnrelax.model.state import State, YarnForces

CHORD_SHARES = np.array([1.0, 3.0, 3.0, 1.0]) / 6.0
"""Largest part of each control point of a segment in the displacement of the segment's chord."""


@dataclass(frozen=True, eq=False)
class Path:
    """The chords of all yarns on the device: one for each segment, and after these two clamps for each yarn."""

    before: wp.array[Any]
    """Chord before the chord of each segment, shape (S,)."""
    after: wp.array[Any]
    """Chord after the chord of each segment, shape (S,)."""
    strand_start: wp.array[Any]
    """Where each strand's segments start, shape (K + 1,)."""
    yarn_strand: wp.array[Any]
    """Where each yarn's strands start, shape (Y + 1,)."""
    yarn_start: wp.array[Any]
    """Where each yarn's segments start, shape (Y + 1,)."""
    closing: wp.array[Any]
    """Rotation from the last clamp of each open yarn to the first, as quaternions, shape (Y, 4)."""
    chord: wp.array[Any]
    """The chords [units], and then the clamps as unit vectors, shape (S + 2 Y, 3)."""
    strand_turn: wp.array[Any]
    """Product of each strand's rotations, as quaternions, shape (K, 4)."""


def put_path(model: Model) -> Path:
    """Send the order of the chords and the clamps to the device.

    Raises:
        ParameterError: the end of an open yarn has no direction.
    """
    yarns = model.yarns
    clamp = end_tangents(yarns)
    segments, count = model.segment_count, yarns.yarn_count
    first, last = yarns.segment_start[:-1], yarns.segment_start[1:] - 1
    before, after = np.arange(segments) - 1, np.arange(segments) + 1
    before[first] = np.where(yarns.closed, last, segments + 2 * np.arange(count))
    after[last] = np.where(yarns.closed, first, segments + 2 * np.arange(count) + 1)
    strand_start, yarn_strand = _strands(yarns.segment_start)
    closing = np.where(yarns.closed[:, None], [0.0, 0.0, 0.0, 1.0], smallest_rotations(clamp[:, 1], clamp[:, 0]))
    return Path(
        before=model.integers(before),
        after=model.integers(after),
        strand_start=model.integers(strand_start),
        yarn_strand=model.integers(yarn_strand),
        yarn_start=model.integers(yarns.segment_start),
        closing=wp.array(closing, dtype=wp.quatd, device=model.device),
        chord=model.upload(np.concatenate([np.zeros((segments, 3)), clamp.reshape(-1, 3)]), 3),
        strand_turn=wp.zeros(len(strand_start) - 1, dtype=wp.quatd, device=model.device),
    )


def end_tangents(yarns: YarnSet) -> NDArray[np.float64]:
    """Unit tangents at the two ends of each yarn as it lies, shape (Y, 2, 3); for closed yarns they mean nothing.

    Raises:
        ParameterError: the end of an open yarn has no direction.
    """
    first, last = yarns.start[:-1], yarns.start[1:] - 1
    tangent = np.stack([yarns.points[first + 2] - yarns.points[first], yarns.points[last] - yarns.points[last - 2]], 1)
    length = np.linalg.norm(tangent, axis=2, keepdims=True)
    bad = np.flatnonzero((length == 0.0).any(axis=(1, 2)) & ~yarns.closed)
    if len(bad):
        raise ParameterError(f"twist: an end of yarn {first_few(bad)} has no direction; move its control points apart")
    return tangent / np.where(length > 0.0, length, 1.0)


def smallest_rotations(first: NDArray[np.float64], second: NDArray[np.float64]) -> NDArray[np.float64]:
    """Quaternions (x, y, z, w) that take unit vectors to others; half turns about some axis if they are opposite."""
    scalar = 1.0 + (first * second).sum(axis=1, keepdims=True)
    axis = np.cross(first, second)
    # at right angles to the first vector: its product with the coordinate axis from which it is farthest
    aside = np.cross(first, np.eye(3)[np.abs(first).argmin(axis=1)])
    opposite = scalar < 1e-9
    turn = np.concatenate([np.where(opposite, aside, axis), np.where(opposite, 0.0, scalar)], axis=1)
    return turn / np.linalg.norm(turn, axis=1, keepdims=True)


def turned_from_straight(
    yarns: YarnSet, chords: NDArray[np.float64]
) -> tuple[NDArray[np.bool_], NDArray[np.float64]]:  # fmt: skip
    """Return which yarns run through the lattice, and psi of each since it lay straight along its lattice step [rad].

    Args:
        yarns: the yarns.
        chords: the chord of each segment, shape (S, 3).

    Returns:
        Both of shape (Y,); psi is 0 for yarns that do not run through the lattice.
    """
    step = np.zeros((yarns.yarn_count, 3))
    if yarns.lattice is not None and yarns.lattice_step is not None:
        step = yarns.lattice.shift(yarns.lattice_step)
    length = np.linalg.norm(step, axis=1, keepdims=True)
    through = (length[:, 0] > 0.0) & yarns.closed
    axis = np.where(through[:, None], step / np.where(length > 0.0, length, 1.0), [1.0, 0.0, 0.0])[yarns.segment_yarn]
    here = chords / np.linalg.norm(chords, axis=1, keepdims=True)
    after = np.arange(1, len(here) + 1)
    after[yarns.segment_start[1:] - 1] = yarns.segment_start[:-1]
    following = here[after]
    # signed area of the spherical triangle of three unit vectors (Van Oosterom and Strackee 1983)
    volume = (axis * np.cross(here, following)).sum(axis=1)
    size = 1.0 + (axis * here).sum(axis=1) + (here * following).sum(axis=1) + (following * axis).sum(axis=1)
    area = 2.0 * np.arctan2(volume, size)
    return through, np.where(through, np.add.reduceat(area, yarns.segment_start[:-1]), 0.0)


def _strands(segment_start: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the first segment of each strand, and the first strand of each yarn."""
    counts = np.diff(segment_start)
    size = np.maximum(np.ceil(np.sqrt(counts)).astype(np.int64), 32)  # the shortest strand
    strands = -(-counts // size)
    yarn_strand = np.concatenate([[0], np.cumsum(strands)])
    place = np.arange(yarn_strand[-1]) - np.repeat(yarn_strand[:-1], strands)
    start = np.repeat(segment_start[:-1], strands) + place * np.repeat(size, strands)
    return np.concatenate([start, segment_start[-1:]]), yarn_strand


@wp.func
def direction_of(chord: Vec3) -> Any:
    """Direction of a chord in double precision."""
    return wp.normalize(wp.vec3d(wp.float64(chord[0]), wp.float64(chord[1]), wp.float64(chord[2])))


@wp.func
def turn_between(first: wp.vec3d, second: wp.vec3d) -> wp.quatd:
    """Smallest rotation that takes one unit vector to another; none where they are opposite."""
    axis = wp.cross(first, second)
    scalar = wp.max(wp.float64(1.0) + wp.dot(first, second), wp.float64(1.0e-12))
    return wp.normalize(wp.quatd(axis[0], axis[1], axis[2], scalar))


@wp.func
def binormal(first: Vec3, second: Vec3) -> Any:
    """Curvature binormal of the corner between two chords."""
    size = wp.length(first) * wp.length(second)
    bottom = wp.max(size + wp.dot(first, second), size * type(size)(1.0e-3))
    return wp.cross(first, second) * (type(size)(2.0) / bottom)


@kernel
def find_chords(
    # model
    model: YarnConstants,
    # state in
    points: wp.array[Vec3],
    # state out
    chord: wp.array[Vec3],
) -> None:
    """From knot to knot along each segment."""
    s = wp.tid()
    q0, q1, q2, q3 = segment_corners(model, points, s)
    third = type(q0[0])(3.0)
    chord[s] = (q3 - q0 + (q2 - q1) * third) / type(third)(6.0)


@kernel
def multiply_strands(
    # model
    strand_start: wp.array[wp.int32],
    before: wp.array[wp.int32],
    # state in
    chord: wp.array[Vec3],
    # state out
    strand_turn: wp.array[wp.quatd],
) -> None:
    """Product of the rotations at the beginnings of a strand's segments."""
    strand = wp.tid()
    first, last = strand_start[strand], strand_start[strand + 1]
    here = direction_of(chord[before[first]])
    product = wp.quatd(wp.float64(0.0), wp.float64(0.0), wp.float64(0.0), wp.float64(1.0))
    for s in range(first, last):
        following = direction_of(chord[s])
        product = turn_between(here, following) * product
        here = following
    strand_turn[strand] = wp.normalize(product)


@kernel
def total_holonomy(
    # model
    yarn_strand: wp.array[wp.int32],
    yarn_start: wp.array[wp.int32],
    before: wp.array[wp.int32],
    after: wp.array[wp.int32],
    closing: wp.array[wp.quatd],
    # state in
    chord: wp.array[Vec3],
    strand_turn: wp.array[wp.quatd],
    # state out
    holonomy: wp.array[wp.float64],
) -> None:
    """The angle psi of each yarn, next to the one that it had."""
    y = wp.tid()
    product = wp.quatd(wp.float64(0.0), wp.float64(0.0), wp.float64(0.0), wp.float64(1.0))
    for strand in range(yarn_strand[y], yarn_strand[y + 1]):
        product = strand_turn[strand] * product
    last = yarn_start[y + 1] - 1
    start = direction_of(chord[before[yarn_start[y]]])
    if before[yarn_start[y]] != last:  # an open yarn turns once more, into its clamp
        product = turn_between(direction_of(chord[last]), direction_of(chord[after[last]])) * product
    product = closing[y] * product
    along = product[0] * start[0] + product[1] * start[1] + product[2] * start[2]
    angle = wp.float64(2.0) * wp.atan2(along, product[3])
    period = wp.float64(4.0 * 3.141592653589793)
    holonomy[y] = angle + period * wp.round((holonomy[y] - angle) / period)


@wp.func
def chord_force(
    model: YarnConstants, before: wp.array[wp.int32], after: wp.array[wp.int32], untwisted: wp.array[wp.float64],
    softness: wp.array[wp.float64], holonomy: wp.array[wp.float64], chord: wp.array[Vec3], s: int
) -> Any:  # fmt: skip
    """A sixth of the force of twist on a chord [erg / unit]."""
    yarn = model.segment_yarn[s]
    here = chord[s]
    corners = binormal(chord[before[s]], here) + binormal(here, chord[after[s]])
    size = wp.length(here)
    return corners * (type(size)((holonomy[yarn] - untwisted[yarn]) / softness[yarn]) / (type(size)(6.0) * size))


@kernel
def add_twist_forces(
    # model
    model: YarnConstants,
    before: wp.array[wp.int32],
    after: wp.array[wp.int32],
    untwisted: wp.array[wp.float64],
    softness: wp.array[wp.float64],
    # state in
    holonomy: wp.array[wp.float64],
    chord: wp.array[Vec3],
    # state out
    leg_force: wp.array2d[Vec3],
) -> None:
    """Add the force of twist on the end of each leg [erg / unit]."""
    s = wp.tid()
    pull = chord_force(model, before, after, untwisted, softness, holonomy, chord, s)
    leg_force[0, s] += pull
    leg_force[1, s] += pull * type(pull[0])(4.0)
    leg_force[2, s] += pull


@kernel
def add_twist_virial(
    # model
    model: CellConstants,
    before: wp.array[wp.int32],
    after: wp.array[wp.int32],
    untwisted: wp.array[wp.float64],
    softness: wp.array[wp.float64],
    # state in
    holonomy: wp.array[wp.float64],
    chord: wp.array[Vec3],
    # state out
    segment_virial: wp.array[Vec9],
) -> None:
    """Add the virial of twist in relaxing cells; the moves of their strains do not count its stiffness."""
    s = wp.tid()
    pull = chord_force(model, before, after, untwisted, softness, holonomy, chord, s)
    cell = cell_of(model.images, s)
    e1, e2 = model.images.frame[2 * cell], model.images.frame[2 * cell + 1]
    none = pull[0] - pull[0]
    segment_virial[s] = add_leg_virial(segment_virial[s], e1, e2, chord[s], pull * type(none)(6.0), none)


@kernel
def twist_energies(
    # model
    untwisted: wp.array[wp.float64],
    softness: wp.array[wp.float64],
    # state in
    holonomy: wp.array[wp.float64],
    # state out
    yarn_energy: wp.array[wp.float64],
) -> None:
    """Energy [erg] of each yarn."""
    y = wp.tid()
    angle = untwisted[y] - holonomy[y]
    yarn_energy[y] = angle * angle / softness[y]


@dataclass(frozen=True, eq=False)
class Twist(YarnChoice):
    """The resistance of the yarns to twist, and the twist of the given yarns.

    Raises:
        ParameterError: k_twist is not a positive number, or an angle is not finite.
    """

    k_twist: float
    """Twist stiffness [erg cm]; the torsional rigidity GJ is twice as large."""
    imposed: float | Sequence[float] | NDArray[np.float64] = 0.0
    """Twist of the given yarns, right-handed, from end to end [rad]: one angle, or one for each yarn."""
    residual: float = 0.0
    """Twist in a length of yarn that would be lost if the yarn hung free, beside ``imposed`` [rad/cm]; right-handed, so
    positive for Z twist."""
    laid: bool = False
    """Whether yarns that run through the lattice have this twist when they are straight, instead of as they are
    given."""
    in_free_cells = True

    def __post_init__(self) -> None:
        if not (np.isfinite(self.k_twist) and self.k_twist > 0.0):
            raise ParameterError(f"twist: got k_twist {self.k_twist}; expected a positive number of erg cm")
        if not np.isfinite(self.imposed).all():
            raise ParameterError("twist: an imposed angle is not finite; expected radians from end to end")
        if not np.isfinite(self.residual):
            raise ParameterError(f"twist: got a residual twist of {self.residual}; expected radians in 1 cm of yarn")

    def on(self, model: Model) -> YarnTerm:
        """Return the twist of a model's yarns.

        Raises:
            ParameterError: the imposed angles are not one for each yarn, or the end of a yarn has no direction.
        """
        count = model.yarns.yarn_count
        angles = np.asarray(self.imposed, dtype=np.float64)
        if angles.shape not in ((), (count,)):
            raise ParameterError(f"twist: got imposed angles of shape {angles.shape}; expected one, or {count}")
        length = np.add.reduceat(model.yarns.rest_length, model.yarns.segment_start[:-1])
        return _Twist(model, self.k_twist / model.unit, angles + self.residual * length, laid=self.laid)


class _Twist(YarnTerm):
    """Twist on a device."""

    name = "twist"

    def __init__(self, model: Model, k_twist: float, imposed: NDArray[np.float64], *, laid: bool) -> None:
        self.model, self.k_twist, self.imposed = model, k_twist, imposed
        self.path = put_path(model)
        self.length = np.add.reduceat(model.rest_length, model.yarns.segment_start[:-1])
        self.softness = self._doubles(self.length / k_twist)
        self.holonomy = self._doubles(np.zeros(len(imposed)))
        self._energy = self._doubles(np.zeros(len(imposed)))
        points = model.upload(model.to_device(model.yarns.points), 3)
        self._follow(points, model.launch)
        given = self.holonomy.numpy()
        if laid:
            chords = self.path.chord.numpy()[: model.segment_count].astype(np.float64)
            through, turned = turned_from_straight(model.yarns, chords)
            given = given + 4.0 * np.pi * np.rint((turned - given) / (4.0 * np.pi))
            self.holonomy.assign(given)
            given = np.where(through, 0.0, given)
        self.untwisted = self._doubles(imposed + given)

    def forces(self, state: State, force: YarnForces, launcher: Launcher) -> list[Any]:
        """Add the force of twist to the legs."""
        path = self.path
        inputs = [self.model.constants, path.before, path.after, self.untwisted, self.softness, self.holonomy,
                  path.chord]  # fmt: skip
        launches = self._follow(state.points, launcher)
        launches.append(launcher(add_twist_forces, self.model.segment_count, inputs, [force.legs]))
        if len(force.leg_virial):
            launches.append(launcher(add_twist_virial, self.model.segment_count, inputs, [force.leg_virial]))
        return launches

    def element_energies(self, state: State, launcher: Launcher) -> tuple[list[Any], wp.array[Any]]:
        """Return the launches that find the energy of each yarn, and the array of the energies."""
        launches = self._follow(state.points, launcher)  # first, because a launcher may run each launch at once
        inputs = [self.untwisted, self.softness, self.holonomy]
        launches.append(launcher(twist_energies, len(self._energy), inputs, [self._energy]))
        return launches, self._energy

    def stiffness(self) -> NDArray[np.float64]:
        """Row sums for yarns that bend to loops of two radii or larger [erg / unit^2], shape (N,)."""
        model, yarn = self.model, self.model.yarns.segment_yarn
        length, loop = model.rest_length, 2.0 * model.radius
        moment = 2.0 * self.k_twist * (np.abs(self.imposed) / self.length + 1.0 / loop)
        by_chord = np.minimum(length / loop[yarn], 1.0) / length
        along = 2.0 * self.k_twist / self.length * np.add.reduceat(by_chord, model.yarns.segment_start[:-1])
        rows = (2.0 * moment[yarn] / length**2 + by_chord * along[yarn]) * CHORD_SHARES.sum()
        shares = rows[:, None] * CHORD_SHARES
        corners = model.yarns.segment_points.ravel()
        return np.bincount(corners, weights=shares.ravel(), minlength=model.point_count).astype(np.float64)

    def arrays(self) -> dict[str, wp.array[Any]]:
        """The holonomy; its previous value determines which multiple of 4 pi is added."""
        return {"holonomy": self.holonomy}

    def _follow(self, points: wp.array[Any], launcher: Launcher) -> list[Any]:
        """Update the holonomy for the current control points."""
        path, model = self.path, self.model
        strands = [path.strand_start, path.before, path.chord]
        yarns = [path.yarn_strand, path.yarn_start, path.before, path.after, path.closing, path.chord,
                 path.strand_turn]  # fmt: skip
        return [
            launcher(find_chords, model.segment_count, [model.constants, points], [path.chord]),
            launcher(multiply_strands, len(path.strand_turn), strands, [path.strand_turn]),
            launcher(total_holonomy, model.yarns.yarn_count, yarns, [self.holonomy]),
        ]

    def _doubles(self, values: NDArray[np.float64]) -> wp.array[Any]:
        return wp.array(values, dtype=wp.float64, device=self.model.device)
