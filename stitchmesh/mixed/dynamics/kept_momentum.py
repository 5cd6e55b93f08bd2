# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Momentum of a system, and velocities that keep it when the masses change places.

When a region grows or shrinks, mass moves between vertices and nodes. Their velocities are interpolated, so the
momentum changes a little. A rigid motion (a, w) is therefore added to the velocities of all free coordinates. It is
chosen so that both momenta, linear and angular about the centre c of the vertices, are the same as before the change:

    sum over all masses of  M (u + a + w x (x - c))  =  P,    of  (x - c) x M (u + a + w x (x - c))  =  L.

Fixed coordinates keep their velocity, and hybrid nodes move with their triangles.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mixed.dynamics.mixed_system import MixedSystem
from stitchmesh.mixed.dynamics.vector_sums import choose, set_sum
from stitchmesh.mixed.mixed_vector import MixedVector

Numbers = NDArray[np.float64]
Moving = tuple[MixedSystem, MixedVector, MixedVector]
"""A system, its positions [cm] and its velocities [cm/s]."""


def keep_momentum(before: Moving, after: Moving) -> None:
    """Change the velocities of a system so that it keeps the momentum that the cloth had before a change.

    Args:
        before: the system before the change.
        after: the system after it; its velocities are changed.
    """
    centre = before[1].numpy()[0].mean(axis=0)
    for system, positions, _velocities in (before, after):
        system.update_masses(positions)
    give_momentum(*after, centre, momentum_about(*before, centre))


def momentum_about(
    system: MixedSystem, positions: MixedVector, velocities: MixedVector, centre: NDArray[np.float64]
) -> Numbers:
    """Linear momentum [g cm/s] and angular momentum about a centre [g cm^2/s], shape (6,).

    Args:
        system: the system, with its masses at the positions of the last ``update_masses``.
        positions: positions [cm].
        velocities: velocities [cm/s].
        centre: the centre [cm], shape (3,).
    """
    product = system.zeros()
    system.set_mass_product(velocities, product)
    amount = np.concatenate(product.numpy()[:2])
    arm = np.concatenate(positions.numpy()[:2]) - centre
    return np.concatenate([amount.sum(axis=0), np.cross(arm, amount).sum(axis=0)])


def give_momentum(
    system: MixedSystem,
    positions: MixedVector,
    velocities: MixedVector,
    centre: NDArray[np.float64],
    expected: Numbers,
) -> None:
    """Add the rigid motion with which the velocities have the expected momentum.

    Args:
        system: the system.
        positions: positions [cm].
        velocities: velocities [cm/s]; changed.
        centre: centre of the angular momentum [cm], shape (3,).
        expected: linear and angular momentum, shape (6,), as ``momentum_about`` returns them.
    """
    rigid = [_rigid_motion(system, positions, centre, number) for number in range(6)]
    matrix = np.stack([momentum_about(system, positions, each, centre) for each in rigid], axis=1)
    missing = expected - momentum_about(system, positions, velocities, centre)
    amount = np.linalg.lstsq(matrix, missing, rcond=None)[0]
    for part, motion in zip(amount.tolist(), rigid, strict=True):
        set_sum(velocities, 1.0, velocities, part, motion)


def _rigid_motion(system: MixedSystem, positions: MixedVector, centre: Numbers, number: int) -> MixedVector:
    """Translation along an axis (0 to 2), or rotation about it (3 to 5), of the free coordinates."""
    axis = np.eye(3)[number % 3]
    places = positions.numpy()[:2]
    v, p = (np.tile(axis, (len(part), 1)) if number < 3 else np.cross(axis, part - centre) for part in places)
    motion = MixedVector.from_numpy(v, p, np.zeros((len(p), 2)), system.scalar, system.device)
    choose(motion, system.moves, motion, motion.like())
    system.make_motion(motion)
    return motion
