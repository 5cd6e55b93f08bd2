# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The criterion for a state of rest.

The residual compares the remaining force with the forces that balance one another,

    residual = rms over control points of |F| / rms over control points of sum over terms of |F_term|

where F is the net force less the reactions of constraints, and the terms are stretch, length, bending, contact and the
requested terms. The residual is 0 at balance and at most 1; it has no unit and does not depend on the start. If a cell
relaxes, the residual is at least ``STRAINS_COUNT`` times the residual of its strains (``cell_strain``), which is the
magnitude of the sum of the forces on them over the sum of the magnitudes for the terms.

Yarns are at rest if the residual is below ``Quality.tolerance`` and a second condition holds. Fabrics are softer than
yarns, so that a small force can leave a large change of the spacing. The second condition depends on the relaxation:

- If Newton's method ends the relaxation, the yarns must be at a minimum of the energy, and the remaining change of the
  spacing, which a step of it finds (``newton``), must be below ``Quality.largest_change``.
- If Newton's method does not end the relaxation of a piece, or if a garment may stop before the method begins, the
  remaining change is estimated from the changes so far (``settling``).
- If yarns move by ``Dynamics``, or if friction moves the state of rest of a piece without a lattice, the remaining
  change is unknown. Between two assessments the energy must then fall by less than ``LARGEST_ENERGY_FALL`` times the
  tolerance, relative to itself.

Yarns with a residual of 0 are at rest in any case. So are yarns whose residual is noise below the tolerance, if no step
lowers their energy.

Coordinates are rounded, and a yarn is stiff. The forces of yarns at rest are therefore not zero, and no solver can make
them zero. To measure the effect of rounding, all coordinates are changed by their last digit, up or down at random, and

    noise = rms over control points of |F changed - F| / sqrt(12)

because a change by one digit is sqrt(12) times the rms of a rounding error. The noise is at least the noise of a
coordinate of one radius, because products are rounded too. If the noise alone exceeds the tolerance, only a higher
precision helps, and the relaxation ends once the residual is noise and the energy is level. The row sums of stiffness
times the size of the coordinates and the precision bound the noise; it is measured only if the bound cannot exclude it.

If the forces of the terms are at most a few times the noise, they cannot be distinguished from zero. Unloaded yarns,
straight and apart, are then at rest, and the residual is 0. Yarns are unloaded if their energies of bending and contact
are at most the energies of a sag and of an overlap of w = ``UNLOADED`` radii, or of the rounding of coordinates if that
is more,

    sum over segments of  k_bend l (8 w / L^2)^2,    1/2 sum over control points of  D_i w^2

with L the length of the longest yarn and D_i the row sums of contact. If there is more energy, the yarns are loaded,
and the noise hides their forces. Two examples: yarn with a ``k_length`` of 1e10 erg carries the forces of bending with
strains of 1e-9, which float32 does not represent; and an arc of 200 radii bends back with less force than the rounding
of its coordinates. Nothing can then tell whether the yarns are at rest, and they are not called so. The residual is at
least the residual of the noise, and the relaxation ends once the energy is level.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.captured import CapturedLaunches, CopyArray, Launcher, ZeroArray
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.precision import Scalar, Vec3
from stitchmesh.compute.reduction import Sums
from stitchmesh.yarnrelax.assessment import ABOVE_NOISE, Assessments
from stitchmesh.yarnrelax.collision.narrow_phase import Candidates
from stitchmesh.yarnrelax.energies import by_term, evaluation
from stitchmesh.yarnrelax.energies.term import Constraint, OnYarns
from stitchmesh.yarnrelax.model.cells import CONTACT
from stitchmesh.yarnrelax.model.constants import Model, YarnConstants
from stitchmesh.yarnrelax.model.lattice_images import cell_of
from stitchmesh.yarnrelax.model.spline import place_contact_samples
from stitchmesh.yarnrelax.model.state import State
from stitchmesh.yarnrelax.solvers.cell_strain import CellStrain
from stitchmesh.yarnrelax.solvers.preconditioner import bend_stiffness

UNLOADED = 0.05
"""Largest sag and overlap, in mean radii, of yarns that count as straight and apart if rounding hides their forces."""
STRAINS_COUNT = 5.0
"""Weight of the residual of a cell's strains."""


@kernel
def add_effort(
    # model
    point_stiffness: wp.array[Scalar],
    # state in
    points: wp.array[Vec3],
    force: wp.array[Vec3],
    stiffness: wp.array[Scalar],
    # state out
    net: wp.array[Vec3],
    effort: wp.array[Scalar],
    contact_noise: wp.array[Scalar],
) -> None:
    """Add one term's force to the net force and its magnitude to the effort; bound the rounding in contacts."""
    i = wp.tid()
    net[i] += force[i]
    effort[i] += wp.length(force[i])
    noise = (stiffness[i] - point_stiffness[i]) * wp.length(points[i])
    contact_noise[i] = wp.max(contact_noise[i], noise)


@kernel
def perturb_coordinates(
    # model
    model: YarnConstants,
    cell_points: wp.array[wp.int32],
    precision: Scalar,
    # state out
    points: wp.array[Vec3],
) -> None:
    """Change the last digit of each coordinate, up or down; equal cells change in the same way."""
    i = wp.tid()
    digits = wp.rand_init(0, i - cell_points[cell_of(model.images, wp.max(model.point_segments[i]))])
    place = points[i]
    for axis in range(3):
        size = wp.abs(place[axis]) * precision
        place[axis] = place[axis] + wp.where(wp.randf(digits) < 0.5, -size, size)
    points[i] = place


@kernel
def square_forces(
    # state in
    net: wp.array[Vec3],
    effort: wp.array[Scalar],
    contact_noise: wp.array[Scalar],
    # state out
    net2: wp.array[Scalar],
    effort2: wp.array[Scalar],
    contact_noise2: wp.array[Scalar],
) -> None:
    """Squares of the net force, of the effort and of the bound of the noise in contacts."""
    i = wp.tid()
    net2[i] = wp.dot(net[i], net[i])
    effort2[i] = effort[i] * effort[i]
    contact_noise2[i] = contact_noise[i] * contact_noise[i]


@kernel
def square_differences(
    # state in
    before: wp.array[Vec3],
    after: wp.array[Vec3],
    # state out
    change2: wp.array[Scalar],
) -> None:
    """Square of the difference of two forces."""
    i = wp.tid()
    change = after[i] - before[i]
    change2[i] = wp.dot(change, change)


LARGEST_ENERGY_FALL = 0.1
"""Largest relative decrease of the energy between two assessments of yarns at rest, over the tolerance."""


def is_level(energy_fall: NDArray[np.float64], tolerance: float) -> NDArray[np.bool_]:
    """Whether each energy hardly falls any more, shape (C,); the arguments are the same as in ``has_converged``."""
    return np.abs(energy_fall) < LARGEST_ENERGY_FALL * tolerance


def has_converged(
    residual: NDArray[np.float64], energy_fall: NDArray[np.float64], tolerance: float
) -> NDArray[np.bool_]:
    """Whether residual and energy say that yarns are at rest, shape (C,).

    Args:
        residual: relative force residuals, shape (C,).
        energy_fall: decrease of each energy since the last assessment, relative to the energy, shape (C,).
        tolerance: ``Quality.tolerance``.
    """
    return (residual == 0.0) | ((residual < tolerance) & is_level(energy_fall, tolerance))


def is_at_rest(
    residual: NDArray[np.float64], spacing: NDArray[np.float64], tolerance: float, largest_change: float
) -> NDArray[np.bool_]:
    """Whether yarns that Newton's method relaxes are at rest, shape (C,).

    Args:
        residual: relative force residuals, shape (C,).
        spacing: estimates of the remaining relative change of the spacing, infinite if unknown, shape (C,).
        tolerance: ``Quality.tolerance``.
        largest_change: ``Quality.largest_change``.
    """
    return (residual == 0.0) | ((residual < tolerance) & (spacing < largest_change))


def hidden_by_rounding(
    last: Assessments, at_rest: NDArray[np.bool_], stalled: NDArray[np.bool_], tolerance: float
) -> NDArray[np.bool_]:
    """Whether more digits are needed to say if each cell is at rest, or to lower its energy, shape (C,).

    Args:
        last: the assessments of the cells.
        at_rest: whether each cell is at rest, shape (C,).
        stalled: whether no step lowers the energy of each cell, shape (C,).
        tolerance: ``Quality.tolerance``.
    """
    return (last.hides_rest(tolerance) | stalled) & ~at_rest


def rounding_force(model: Model, stiffness: NDArray[np.float64]) -> NDArray[np.float64]:
    """Bound of the rms force from the rounding of coordinates, without contacts [erg / unit], shape (C,)."""
    counts = np.diff(model.point_start)
    mean = np.add.reduceat(stiffness**2, model.point_start[:-1]) / counts
    return np.sqrt(mean) * model.size * precision_of(model)


def unloaded_energies(model: Model, contact: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Largest energies of bending and of contact in unloaded yarns [erg], both of shape (C,).

    Args:
        model: the yarns.
        contact: row sums of the stiffness of contact at the control points [erg / unit^2], shape (N,).
    """
    yarns = model.yarns
    rounding = ABOVE_NOISE * np.maximum(model.size, 1.0) * precision_of(model)
    by_rounding = 0.5 * np.add.reduceat(bend_stiffness(model), model.point_start[:-1]) * rounding**2
    lengths = np.bincount(yarns.segment_yarn, weights=model.rest_length)
    longest = np.maximum.reduceat(lengths[yarns.segment_yarn], model.segment_start[:-1])
    rigidity = np.add.reduceat(model.segment_stiffness[:, 2] * model.rest_length, model.segment_start[:-1])
    bent = np.maximum(by_rounding, rigidity * (8.0 * UNLOADED / longest**2) ** 2)
    pressed = 0.5 * np.add.reduceat(contact, model.point_start[:-1]) * np.maximum(rounding, UNLOADED) ** 2
    return bent, pressed


class Assessor:
    """The captured launches of an assessment, about thirty; two transfers read their result."""

    def __init__(
        self,
        model: Model,
        state: State,
        candidates: Candidates,
        terms: Sequence[OnYarns],
        constraints: Sequence[Constraint],
        point_stiffness: wp.array[Any],
        *,
        rounding: NDArray[np.float64],
        strain: CellStrain | None = None,
    ) -> None:
        """Prepare the launches for the current arrays; ``rounding`` is the result of ``rounding_force``."""
        n = model.point_count
        self.model, self.state, self.candidates, self.terms = model, state, candidates, terms
        self.constraints, self.point_stiffness, self.strain = constraints, point_stiffness, strain
        self.rounding = rounding
        self.net, self.effort, self.contact_noise = model.empty(n, 3), model.empty(n), model.empty(n)
        self.sums = Sums(by_term.BASE_TERMS + 3, model.largest_cell, model.cell_count, model.device)
        self.noise = Sums(1, model.largest_cell, model.cell_count, model.device)
        self.launches = CapturedLaunches(self._launches(model.prepare), model.device)
        self.perturbing: CapturedLaunches | None = None

    def assess(self, cells: NDArray[np.bool_] | None = None) -> Assessments:
        """Return residual and energies of each cell in its current state; forces are overwritten.

        With ``cells``, only the assessments of these cells belong to the current state.
        """
        with self.model.only_in(cells):
            self.launches.launch()
        found = self.sums.totals()
        counts = np.diff(self.model.point_start)
        left, whole, in_contacts = (np.sqrt(found.pop(name) / counts) for name in ("net", "effort", "contact noise"))
        found |= {term.name: by_term.cell_energies(self.model, self.state, term) for term in self.terms}
        in_cell = np.zeros(self.model.cell_count)
        if self.strain is not None:
            in_cell = STRAINS_COUNT * self.strain.residuals()
            found |= {"tension": self.strain.tension_energies()}
        noise = np.zeros(self.model.cell_count)
        doubtful = left <= self.rounding + precision_of(self.model) * in_contacts
        if cells is not None:
            doubtful &= cells
        if doubtful.any():
            noise = np.where(doubtful, np.maximum(self._noise(), self.rounding / self.model.size), 0.0)
        # On a CPU, sums are the memory of the device, which the next assessment overwrites.
        energies = {name: np.array(parts, dtype=np.float64) for name, parts in found.items()}
        still = doubtful & (whole <= ABOVE_NOISE * noise)
        hidden = still & self._is_loaded(energies) if still.any() else still
        still = still & ~hidden
        with np.errstate(divide="ignore", invalid="ignore"):
            share = np.where(still, 0.0, noise / whole)
            residual = np.where(still, 0.0, np.maximum(left / whole, np.where(hidden, share, 0.0)))
        return Assessments(np.maximum(residual, in_cell), energies, share, hidden)

    def _is_loaded(self, energies: Mapping[str, NDArray[np.float64]]) -> NDArray[np.bool_]:
        """Whether each cell has more energy in bending or in contact than unloaded yarns, shape (C,)."""
        model, state = self.model, self.state
        rows = np.zeros(model.point_count)
        if model.stiffness[:, CONTACT].any():
            place_contact_samples(model, state, model.launch)
            nothing = model.empty(model.point_count)
            for launch in by_term.term_launches(model, state, self.candidates, (), nothing)["contact"]:
                launch.launch()
            rows = state.stiffness.numpy()[: model.point_count].astype(np.float64)
        bent, pressed = unloaded_energies(model, rows)
        straight = np.array([not cell.yarns.natural_curvature.any() for cell in model.cells])
        return np.asarray((straight & (energies["bend"] > bent)) | (energies["contact"] > pressed))

    def _launches(self, launcher: Launcher) -> list[Any]:
        """Return the launches for forces term by term, their sums and magnitudes, and energies."""
        model, state = self.model, self.state
        sums = [self.net, self.effort, self.contact_noise]
        launches: list[Any] = [ZeroArray(array) for array in sums]
        if self.strain is not None:
            launches += self.strain.clear_launches()
        launches.append(place_contact_samples(model, state, launcher))
        arguments = (model, state, self.candidates, self.terms, self.point_stiffness)
        for own in by_term.term_launches(*arguments).values():
            launches += own
            inputs = [self.point_stiffness, state.points, state.force, state.stiffness]
            launches.append(launcher(add_effort, model.point_count, inputs, sums))
            if self.strain is not None:
                launches += self.strain.add_launches(state, launcher)
        for constraint in self.constraints:
            launches += constraint.filter_forces(self.net, launcher)
        squares = [model.empty(model.point_count) for _ in sums]
        launches.append(launcher(square_forces, model.point_count, list(sums), squares))
        launches += by_term.energy_launches(model, state, self.candidates, self.sums, launcher)
        for name, square in zip(("net", "effort", "contact noise"), squares, strict=True):
            launches.append(self.sums.add(name, square, model.cell_points, launcher))
        return [*launches, self.sums.total_launch(launcher)]

    def _noise(self) -> NDArray[np.float64]:
        """Return the rms force that the rounding of coordinates causes [erg / unit], shape (C,)."""
        if self.perturbing is None:
            self.perturbing = CapturedLaunches(self._noise_launches(self.model.prepare), self.model.device)
        self.perturbing.launch()
        return np.sqrt(self.noise.totals()["noise"] / (12.0 * np.diff(self.model.point_start)))

    def _noise_launches(self, launcher: Launcher) -> list[Any]:
        """Return the launches for the change of forces by the last digit of coordinates, which are then restored."""
        model, state = self.model, self.state
        n = model.point_count
        kept, change2, cells = wp.clone(state.points), model.empty(n), [model.constants, model.cell_points]
        arguments = (model, state, self.candidates, self.terms, self.point_stiffness)
        launches = [
            CopyArray(state.points, kept),
            launcher(perturb_coordinates, n, [*cells, model.number(precision_of(model))], [state.points]),
        ]
        launches += evaluation.force_launches(*arguments, launcher)
        launches.append(CopyArray(kept, state.points))
        for constraint in self.constraints:
            launches += constraint.filter_forces(state.force, launcher)
        launches.append(launcher(square_differences, n, [self.net, state.force], [change2]))
        launches.append(self.noise.add("noise", change2, model.cell_points, launcher))
        return [*launches, self.noise.total_launch(launcher)]


def precision_of(model: Model) -> float:
    """Size of the last digit of 1."""
    return float(np.finfo(np.float32 if model.scalar is wp.float32 else np.float64).eps)


def rest_text(report: Mapping[str, Any]) -> str:
    """Return whether yarns are at rest, with the iterations and the residual of a report, as text."""
    state = "at rest" if report["converged"] else "not at rest"
    return f"{state} after {report['iterations']} iterations, residual {report['residual']:.2g}"
