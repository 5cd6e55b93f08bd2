# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Twist: the resistance of a yarn to rotation about its own centreline (Bergou 2008, Discrete Elastic Rods).

Twist spreads along a yarn faster than any other motion. In a state of rest it is therefore uniform along each yarn, and
one angle describes it (Bergou 2008, section 5.1, quasistatic material frames of an isotropic rod):

    E = k_twist theta^2 / L        [erg],    theta = imposed - (psi - psi_0)

with L the rest length. The torsional rigidity GJ is 2 k_twist, as the flexural rigidity EI is 2 k_bend. psi is the
rotation of a frame that is transported along the centreline without twist (``twist_holonomy``). psi_0 is the psi of the
given yarns, whose twist is the imposed one. The ends of a closed yarn stay joined, so its twist changes with its
writhe, d theta = -2 pi d writhe. The ends of an open yarn do not rotate about the given end tangents, which are
clamped. The force on a chord between knots,

    F = -dE / d chord = -(k_twist theta / L) (k_before + k_after) / |chord|

acts through the three legs of its segment with weights (1, 4, 1) / 6. The force on a straight yarn is zero.

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
from stitchmesh.compute.reduction import ordered_sum
from stitchmesh.errors import ParameterError
from stitchmesh.yarnrelax.collision.narrow_phase import Candidates
from stitchmesh.yarnrelax.energies.term import Term, TermChoice
from stitchmesh.yarnrelax.energies.twist_holonomy import binormal, find_chords, multiply_strands, total_holonomy
from stitchmesh.yarnrelax.energies.twist_path import put_path
from stitchmesh.yarnrelax.model.constants import Model
from stitchmesh.yarnrelax.model.state import State

CHORD_SHARES = np.array([1.0, 3.0, 3.0, 1.0]) / 6.0
"""Largest part of each control point of a segment in the displacement of the segment's chord."""


@kernel
def add_twist_forces(
    # model
    model: Any,
    before: wp.array[wp.int32],
    after: wp.array[wp.int32],
    untwisted: wp.array[wp.float64],
    softness: wp.array[wp.float64],
    # state in
    holonomy: wp.array[wp.float64],
    chord: wp.array[Any],
    # state out
    leg_force: wp.array2d[Any],
) -> None:
    """Add the force of twist on the end of each leg [erg / unit]."""
    s = wp.tid()
    yarn = model.segment_yarn[s]
    here = chord[s]
    corners = binormal(chord[before[s]], here) + binormal(here, chord[after[s]])
    size = wp.length(here)
    pull = corners * (type(size)((holonomy[yarn] - untwisted[yarn]) / softness[yarn]) / (type(size)(6.0) * size))
    leg_force[0, s] += pull
    leg_force[1, s] += pull * type(size)(4.0)
    leg_force[2, s] += pull


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
class Twist(TermChoice):
    """The resistance of the yarns to twist, and the twist of the given yarns.

    Raises:
        ParameterError: k_twist is not a positive number, or an angle is not finite.
    """

    k_twist: float
    """Twist stiffness [erg cm]; the torsional rigidity GJ is twice as large."""
    imposed: float | Sequence[float] | NDArray[np.float64] = 0.0
    """Twist of the given yarns, right-handed, from end to end [rad]: one angle, or one for each yarn."""

    def __post_init__(self) -> None:
        if not (np.isfinite(self.k_twist) and self.k_twist > 0.0):
            raise ParameterError(f"twist: got k_twist {self.k_twist}; expected a positive number of erg cm")
        if not np.isfinite(self.imposed).all():
            raise ParameterError("twist: an imposed angle is not finite; expected radians from end to end")

    def on(self, model: Model) -> Term:
        """Return the twist of a model's yarns.

        Raises:
            ParameterError: the imposed angles are not one for each yarn, or the end of a yarn has no direction.
        """
        count = model.yarns.yarn_count
        angles = np.asarray(self.imposed, dtype=np.float64)
        if angles.shape not in ((), (count,)):
            raise ParameterError(f"twist: got imposed angles of shape {angles.shape}; expected one, or {count}")
        return _Twist(model, self.k_twist / model.unit, np.broadcast_to(angles, count))


class _Twist(Term):
    """Twist on a device."""

    name = "twist"

    def __init__(self, model: Model, k_twist: float, imposed: NDArray[np.float64]) -> None:
        self.model, self.k_twist, self.imposed = model, k_twist, imposed
        self.path = put_path(model)
        self.length = np.add.reduceat(model.rest_length, model.yarns.segment_start[:-1])
        self.softness = self._doubles(self.length / k_twist)
        self.holonomy = self._doubles(np.zeros(len(imposed)))
        points = model.upload(model.to_device(model.yarns.points), 3)
        self._follow(points, model.launch)
        self.untwisted = self._doubles(imposed + self.holonomy.numpy())

    def forces(self, state: State, candidates: Candidates, launcher: Launcher) -> list[Any]:
        """Add the force of twist to ``state.leg_force``."""
        path = self.path
        inputs = [self.model.constants, path.before, path.after, self.untwisted, self.softness, self.holonomy,
                  path.chord]  # fmt: skip
        launches = self._follow(state.points, launcher)
        return [*launches, launcher(add_twist_forces, self.model.segment_count, inputs, [state.leg_force])]

    def energy(self, state: State, candidates: Candidates) -> float:
        """Energy of all yarns [erg]."""
        self._follow(state.points, self.model.launch)
        energy = self._doubles(np.zeros(len(self.imposed)))
        self.model.launch(twist_energies, len(energy), [self.untwisted, self.softness, self.holonomy], [energy])
        return ordered_sum(energy)

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
