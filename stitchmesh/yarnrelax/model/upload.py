# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Sends yarns to the device: everything that stays constant during a relaxation.

Segments of one yarn that are neighbours do not collide. Kaldor 2008 excludes only the next segment from collision. This
is correct if a segment is as long as the yarn is thick: two segments collide if the rest length between them is at
least a diameter. If segments are shorter, all segments up to that rest length are excluded, because a straight yarn
would otherwise repel itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.precision import ScalarType
from stitchmesh.compute.threads import each_block
from stitchmesh.errors import ParameterError
from stitchmesh.yarn import YarnSet, basis
from stitchmesh.yarnrelax.model.cells import CONTACT, PeriodicCell, starts_of
from stitchmesh.yarnrelax.model.constants import Model, SoftContact, StiffContact, constants_struct
from stitchmesh.yarnrelax.model.image_table import put_images
from stitchmesh.yarnrelax.model.lattice_images import images_struct
from stitchmesh.yarnrelax.model.material import YarnMaterial
from stitchmesh.yarnrelax.model.spline import LARGEST_REACH

ROOM = 1e-4
"""Largest stiffness over the root of the largest number; the room is for sums of forces and for strains."""
MOST_SAMPLES = 10_000
"""Largest number of contact samples of a segment; the table of their places grows with its square."""
UNENDING = 1 << 30
"""Cycle of the segments of a yarn that does not return to its first segment, because it is open or leaves the cell."""


def put_model(
    yarns: YarnSet,
    material: YarnMaterial,
    *,
    quadrature_points: int,
    contact_samples: int,
    scalar: ScalarType,
    device: wp.Device,
) -> Model:
    """Send everything that stays constant to the device.

    Args:
        yarns: the yarns, on a lattice or not.
        material: stiffnesses in CGS units.
        quadrature_points: number of Gauss points in a segment.
        contact_samples: contact samples in a segment; a long segment gets enough samples to leave no gap (``spline``).
        scalar: Warp's floating-point type.
        device: where the kernels run.

    Raises:
        ParameterError: there is less than one quadrature point or contact sample, a stiffness exceeds the precision, or
            segments are too long for their radius.
    """
    counts = {"quadrature_points": quadrature_points, "contact_samples": contact_samples}
    return put_cells([(yarns, material)], **counts, scalar=scalar, device=device)


def put_cells(
    given: Sequence[tuple[YarnSet, YarnMaterial]],
    *,
    quadrature_points: int,
    contact_samples: int | Sequence[int],
    scalar: ScalarType,
    device: wp.Device,
) -> Model:
    """Send the yarns of several independent cells to the device, with the arguments and errors of ``put_model``.

    Each cell may have its own number of contact samples.
    """
    samples = np.broadcast_to(contact_samples, len(given)).tolist()
    for name, count in (("quadrature_points", quadrature_points), ("contact_samples", min(samples))):
        if count < 1:
            raise ParameterError(f"{name}: got {count}; expected at least 1")
    cells = tuple(PeriodicCell(yarns, material.scaled(1.0 / float(yarns.radius.mean()))) for yarns, material in given)
    _refuse_stiffness([cell.material for cell in cells], scalar)
    counts = np.concatenate([sample_counts(cell.yarns, own) for cell, own in zip(cells, samples, strict=True)])
    _refuse_slender(counts)
    kind = images_struct(scalar, on_lattice=cells[0].yarns.lattice is not None)
    is_soft = any(cell.material.compression == "van-wyk" for cell in cells)
    model = Model(
        cells[0].yarns if len(cells) == 1 else join_yarns([cell.yarns for cell in cells]),
        cells,
        device,
        scalar,
        np.concatenate([[0], np.cumsum(counts)]),
        quadrature_points,
        constants_struct(scalar, kind, SoftContact if is_soft else StiffContact)(),
    )
    model.constants.images = put_images(model, kind)
    _put_segments(model)
    _put_samples(model, counts)
    if is_soft:
        soft = [cell.material.compression == "van-wyk" for cell in cells]
        model.constants.contact.soft = model.integers(np.repeat(np.repeat(soft, np.diff(model.segment_start)), counts))
    _put_points(model)
    model.constants.rule = model.upload(gauss_rule(quadrature_points), 6)
    model.constants.quadrature_points = quadrature_points
    return model


def _refuse_stiffness(materials: Sequence[YarnMaterial], scalar: ScalarType) -> None:
    """Refuse stiffnesses, scaled to yarn of unit radius, whose squared forces exceed the precision."""
    largest = float(np.sqrt(np.finfo(np.float32 if scalar is wp.float32 else np.float64).max)) * ROOM
    for material in materials:
        for name in ("k_len", "k_length", "k_bend", "k_contact"):
            value = getattr(material, name)
            if value > largest:
                found = f"material: {name} is {value:.3g} for yarn of unit radius"
                raise ParameterError(f"{found}; expected at most {largest:.1g}, which the precision can square")


def _refuse_slender(counts: NDArray[np.int64]) -> None:
    """Refuse segments that are too long for their radius."""
    if counts.max() > MOST_SAMPLES:
        found = f"segment {int(counts.argmax())}: is so long that it needs more than {MOST_SAMPLES} contact samples"
        raise ParameterError(f"{found}; take thicker or shorter yarn, or more control points")


def join_yarns(sets: Sequence[YarnSet]) -> YarnSet:
    """Return the yarns of several sets in one set, without lattices."""
    names = ("points", "closed", "radius", "rest_length", "row", "face", "part", "colour", "natural_curvature",
             "drawn_radius", "mass_per_length")  # fmt: skip
    joined: dict[str, Any] = {name: np.concatenate([getattr(yarns, name) for yarns in sets]) for name in names}
    return YarnSet(**joined, start=starts_of(np.concatenate([np.diff(yarns.start) for yarns in sets]).tolist()))


def _put_segments(model: Model) -> None:
    yarns, constants = model.yarns, model.constants
    counts = np.diff(yarns.segment_start)
    returns = yarns.closed & ~model.lattice_step.any(axis=1)
    constants.yarn_step = wp.array(model.lattice_step.astype(np.int32), dtype=wp.vec2i, device=model.device)
    constants.yarn_segments = model.integers(counts)
    constants.segment_points = wp.array(yarns.segment_points.astype(np.int32), dtype=wp.vec4i, device=model.device)
    constants.segment_rest_length = model.upload(model.rest_length)
    constants.segment_stiffness = model.upload(model.segment_stiffness, 3)
    constants.segment_natural = model.upload(model.natural_ends, 2)
    constants.segment_yarn = model.integers(yarns.segment_yarn)
    constants.segment_skip = model.integers(neighbour_reach(yarns))
    constants.segment_cycle = model.integers(np.where(returns, counts, UNENDING)[yarns.segment_yarn])


def _put_samples(model: Model, counts: NDArray[np.int64]) -> None:
    constants = model.constants
    place = sample_places(int(counts.max()))
    constants.sample_start = model.integers(model.sample_start)
    constants.sample_segment = model.integers(np.repeat(np.arange(model.segment_count), counts))
    weight = np.repeat(model.rest_length / counts, counts)
    k_contact = np.repeat(np.repeat(model.stiffness[:, CONTACT], np.diff(model.segment_start)), counts)
    constants.sample_weight, constants.sample_stiffness = model.upload(weight), model.upload(k_contact * weight)
    constants.sample_basis = model.upload(basis(place), 4)
    constants.sample_legs = model.upload(leg_weights(place), 3)
    constants.yarn_radius = model.upload(model.radius)


def _put_points(model: Model) -> None:
    yarns = model.yarns
    slots = np.full((len(yarns.points), 4), -1, dtype=np.int32)

    points = yarns.segment_points

    def place(some: slice) -> None:
        for slot in range(4):
            slots[points[some, slot], slot] = np.arange(some.start, some.stop)

    each_block(place, model.segment_count)  # a control point is in a slot of one segment only
    model.constants.point_segments = wp.array(slots, dtype=wp.vec4i, device=model.device)


def leg_weights(parameter: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the weights of the three legs in y' at each parameter, shape (n, 3)."""
    first, last = (1 - parameter) ** 2 / 2, parameter**2 / 2
    return np.stack([first, 1 - first - last, last], axis=1)


def gauss_rule(count: int) -> NDArray[np.float64]:
    """Return the rows of a Gauss rule on [0, 1], shape (count, 6)."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    s = (nodes + 1) / 2
    return np.column_stack([leg_weights(s), 1 - s, s, weights / 2])


def sample_places(most: int) -> NDArray[np.float64]:
    """Return the parameters of 1, 2, ... ``most`` equidistant samples of a segment, one after another."""
    return np.concatenate([(np.arange(count) + 0.5) / count for count in range(1, most + 1)])


def sample_counts(yarns: YarnSet, contact_samples: int) -> NDArray[np.int64]:
    """Return the number of contact samples of each segment, from ``contact_samples`` to one too many, shape (S,)."""
    yarn, counts = yarns.segment_yarn, np.empty(len(yarns.segment_points), dtype=np.int64)

    def measure(some: slice) -> None:
        leg = np.linalg.norm(np.diff(yarns.corners_of(some), axis=1), axis=2).max(axis=1)
        reach = np.maximum(leg, yarns.rest_length[some]) / (2 * yarns.radius[yarn[some]])
        wanted = np.maximum(contact_samples, np.ceil(reach / LARGEST_REACH))
        counts[some] = np.minimum(wanted, MOST_SAMPLES + 1)  # More may not fit into an integer.

    each_block(measure, len(counts))
    return counts


def neighbour_reach(yarns: YarnSet) -> NDArray[np.int64]:
    """Return the number of following segments that do not collide with each segment, shape (S,).

    Raises:
        ParameterError: a closed yarn is more than a thousand times thicker than it is long.
    """
    reach = np.ones(len(yarns.rest_length), dtype=np.int64)
    diameter = 2.0 * yarns.radius
    shortest = np.minimum.reduceat(yarns.rest_length, yarns.segment_start[:-1])
    for yarn in np.flatnonzero(shortest < diameter):
        first, last = yarns.segment_start[yarn], yarns.segment_start[yarn + 1]
        length = float(yarns.rest_length[first:last].sum())
        if yarns.closed[yarn] and diameter[yarn] > 1_000 * length:
            found = f"yarn {yarn}: has a rest length of {length:.3g} cm and is {diameter[yarn]:.3g} cm thick"
            raise ParameterError(f"{found}; take thinner yarn or larger rest lengths")
        reach[first:last] = _reach(yarns.rest_length[first:last], diameter[yarn], closed=bool(yarns.closed[yarn]))
    return np.minimum(reach, UNENDING)


def _reach(lengths: NDArray[np.float64], diameter: float, *, closed: bool) -> NDArray[np.int64]:
    count = len(lengths)
    turns = int(np.ceil(diameter / lengths.sum())) + 1 if closed else 0
    ends = np.cumsum(np.tile(lengths, turns + 1))
    # the rest length between segments i and i + m + 1 is ends[i + m] - ends[i]; the factor allows for rounding
    wanted = ends[:count] + diameter * (1 - 1e-9)
    return np.maximum(np.searchsorted(ends, wanted) - np.arange(count), 1)
