# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The contacts of a load step with friction: which samples press each other, their normal forces and their anchors.

A renewal lists the pairs that press each other now. A pair that pressed before keeps its slip, projected into the plane
across the new normal and limited to the slip at which friction is full, the slip length e in the measure s of the law:

    u' = u_t min(1, e / s),    anchor <- (y_p - y_q) - u'

The anchor therefore follows a pair that slides, and does not move under a pair that sticks (Cundall and Strack 1979). A
constant load thus does not creep through renewals. The slip of a new pair is the relative displacement of its samples
since the last renewal, because sliding yarns touch with new samples all the time. In a batch, some cells may be renewed
while others keep their contacts.

Both samples of a pair store it. The lists belong to friction, so the energy does not change when candidate lists are
made again. On a lattice they also keep the periods of the renewal, and the table of images that their entries refer to,
because the table may be made again too. A pair is therefore found again by its sample and the displacement of its
image, and the displacement of a new pair contains the change of the periods.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.precision import Vec3, Vec4
from stitchmesh.compute.reduction import maximum
from stitchmesh.simulation.friction_law import within
from stitchmesh.yarnrelax.collision.narrow_phase import Candidates
from stitchmesh.yarnrelax.friction.friction_law import press_of_pair, resisted_slip, slip_measure, vector_from
from stitchmesh.yarnrelax.model.constants import CellConstants, Model, YarnConstants
from stitchmesh.yarnrelax.model.image_table import joined_table
from stitchmesh.yarnrelax.model.lattice_images import (
    LatticeImages,
    entry_shift,
    images_struct,
    images_with,
    sample_number,
)
from stitchmesh.yarnrelax.model.spline import place_samples, segment_corners, weight_row
from stitchmesh.yarnrelax.model.state import State

ROOM = 2
"""New lists have room for this many more pairs than they need, so that the lists of the next load steps fit in."""


@kernel
def find_tangents(
    # model
    model: YarnConstants,
    # state in
    points: wp.array[Vec3],
    # state out
    tangent: wp.array[Vec3],
) -> None:
    """Unit tangent of the yarn at each sample."""
    s = wp.tid()
    q0, q1, q2, q3 = segment_corners(model, points, s)
    leg0, leg1, leg2 = q1 - q0, q2 - q1, q3 - q2
    first = model.sample_start[s]
    count = model.sample_start[s + 1] - first
    row = weight_row(model, count, 0)
    for k in range(count):
        weight = model.sample_legs[row + k]
        tangent[first + k] = wp.normalize(leg0 * weight[0] + leg1 * weight[1] + leg2 * weight[2])


@kernel
def count_contacts(
    # model
    model: YarnConstants,
    # state in
    samples: wp.array[Vec4],
    tangent: wp.array[Vec3],
    candidate_count: wp.array[wp.int32],
    candidates: wp.array2d[wp.int32],
    # state out
    count: wp.array[wp.int32],
) -> None:
    """Number of samples that press each sample."""
    p = wp.tid()
    found = int(0)
    for c in range(candidate_count[p]):
        press = press_of_pair(model, samples, tangent, p, candidates[p, c])
        if wp.dot(press, press) > type(press[0])(0.0):
            found += 1
    count[p] = found


@wp.func
def is_same_pair(
    images: LatticeImages, entry: int, old_images: LatticeImages, old_entry: int, p: int, here: Vec4
) -> bool:
    """Whether two entries of ``p`` are one sample in one image; the tables may differ, the periods are the same.

    Displacements of one image differ by rounding at most, those of two images by a period, which is longer than a yarn
    is thick.
    """
    same = sample_number(images, entry) == sample_number(old_images, old_entry)
    if same:
        apart = entry_shift(images, here - here, p, entry) - entry_shift(old_images, here - here, p, old_entry)
        same = wp.dot(apart, apart) < here[3] * here[3]
    return same


@kernel
def list_contacts(
    # model
    model: YarnConstants,
    law: Vec4,
    old_table: LatticeImages,
    old_periods: LatticeImages,
    # state in
    samples: wp.array[Vec4],
    tangent: wp.array[Vec3],
    candidate_count: wp.array[wp.int32],
    candidates: wp.array2d[wp.int32],
    old_place: wp.array[Vec4],
    old_count: wp.array[wp.int32],
    old_entry: wp.array2d[wp.int32],
    old_anchor: wp.array2d[Vec3],
    # state out
    entry: wp.array2d[wp.int32],
    anchor: wp.array2d[Vec3],
    press: wp.array2d[Vec3],
) -> None:
    """The pairs that press each other now, with the part of their slip that they keep."""
    p = wp.tid()
    here = samples[p]
    found = int(0)
    for c in range(candidate_count[p]):
        listed = candidates[p, c]
        force = press_of_pair(model, samples, tangent, p, listed)
        if wp.dot(force, force) > type(force[0])(0.0):
            q = sample_number(model.images, listed)
            apart = vector_from(model.images, samples, p, here, listed, force)
            slip = apart - vector_from(old_periods, old_place, p, old_place[p], listed, force)
            for old in range(old_count[p]):
                if is_same_pair(model.images, listed, old_table, old_entry[p, old], p, here):
                    slip = apart - old_anchor[p, old]
            normal = wp.normalize(force)
            measure = slip_measure(slip, resisted_slip(slip, normal, tangent[p], tangent[q], law))
            kept = within(slip, normal) * (law[3] / wp.max(measure, law[3]))
            entry[p, found] = listed
            anchor[p, found] = apart - kept
            press[p, found] = force
            found += 1


@kernel
def keep_contacts(
    # model
    model: CellConstants,
    keeps: wp.array[wp.int32],
    number: wp.array[wp.int32],
    # state in
    old_place: wp.array[Vec4],
    old_tangent: wp.array[Vec3],
    old_count: wp.array[wp.int32],
    old_entry: wp.array2d[wp.int32],
    old_anchor: wp.array2d[Vec3],
    old_press: wp.array2d[Vec3],
    # state out
    place: wp.array[Vec4],
    tangent: wp.array[Vec3],
    count: wp.array[wp.int32],
    entry: wp.array2d[wp.int32],
    anchor: wp.array2d[Vec3],
    press: wp.array2d[Vec3],
) -> None:
    """The contacts that cells keep, whose images have new numbers."""
    p = wp.tid()
    if keeps[model.images.sample_cell[p]] != 0:
        place[p] = old_place[p]
        tangent[p] = old_tangent[p]
        count[p] = old_count[p]
        for k in range(old_count[p]):
            old = old_entry[p, k]
            image = number[old // model.images.sample_count]
            entry[p, k] = image * model.images.sample_count + old % model.images.sample_count
            anchor[p, k] = old_anchor[p, k]
            press[p, k] = old_press[p, k]


@dataclass(frozen=True, eq=False)
class Contacts:
    """The pairs that press each other in a load step; they are constant until the next load step."""

    place: wp.array[Any]
    """The samples when the load step began, shape (P, 4)."""
    periods: wp.array[Any]
    """The periods when the load step began, shape (2 C, 3), or (0, 3) without a lattice."""
    tangent: wp.array[Any]
    """Unit tangent of the yarn at each sample, shape (P, 3)."""
    count: wp.array[Any]
    """Number of samples that press each sample, shape (P,)."""
    entry: wp.array[Any]
    """The samples that press each sample, as entries of candidate lists, shape (P, capacity)."""
    table: wp.array[Any]
    """The images that the entries refer to, shape (I, 2), or (0, 2) without a lattice."""
    anchor: wp.array[Any]
    """Vector from each of these samples at which the pair has not slipped, shape (P, capacity, 3)."""
    press: wp.array[Any]
    """N n, the force with which each of these samples presses [erg / unit], shape (P, capacity, 3)."""

    def put_into(self, other: Contacts) -> bool:
        """Copy these contacts into the arrays of others if they fit; return whether they do."""
        if self.table is not other.table or self.entry.shape != other.entry.shape:
            return False
        for part in fields(self):
            if part.name != "table":
                wp.copy(getattr(other, part.name), getattr(self, part.name))
        return True


def first_contacts(model: Model) -> Contacts:
    """Return empty lists of contacts, for the samples of the given yarns."""
    points, place = model.upload(model.to_device(model.yarns.points), 3), model.empty(model.sample_count, 4)
    model.launch(place_samples, model.segment_count, [model.constants, points], [place])
    return _no_contacts(model, place, 1)


def renewed_contacts(
    model: Model, law: Any, state: State, candidates: Candidates, old: Contacts, cells: NDArray[np.bool_] | None
) -> Contacts:  # fmt: skip
    """Return the contacts for the current state in new arrays; only ``cells``, shape (C,), are renewed, or all cells.

    Samples and candidate lists must be up to date.
    """
    tangent, count = model.empty(model.sample_count, 3), _integers(model, model.sample_count)
    model.launch(find_tangents, model.segment_count, [model.constants, state.points], [tangent])
    touching = [state.samples, tangent, candidates.count, candidates.lists]
    model.launch(count_contacts, model.sample_count, [model.constants, *touching], [count])
    most, capacity = int(maximum(count)), old.entry.shape[1]
    new = _no_contacts(model, wp.clone(state.samples), capacity if most <= capacity else most + ROOM)
    inputs = [model.constants, law, own_images(model, old), _images(model, periods=old.periods), *touching, old.place,
              old.count, old.entry, old.anchor]  # fmt: skip
    model.launch(list_contacts, model.sample_count, inputs, [new.entry, new.anchor, new.press])
    new = replace(new, tangent=tangent, count=count)
    return new if cells is None or cells.all() else _kept_in(model, new, old, ~cells)


def _kept_in(model: Model, new: Contacts, old: Contacts, keeps: NDArray[np.bool_]) -> Contacts:
    """Return the new contacts with the old ones in the cells that keep them."""
    table, number = joined_table(new.table, old.table)
    kept = [old.place, old.tangent, old.count, old.entry, old.anchor, old.press]
    outputs = [new.place, new.tangent, new.count, new.entry, new.anchor, new.press]
    inputs = [model.constants, model.integers(keeps), model.integers(number), *kept]
    model.launch(keep_contacts, model.sample_count, inputs, outputs)
    periods = np.where(np.repeat(keeps, 2)[:, None], old.periods.numpy(), new.periods.numpy())
    return replace(new, table=table, periods=model.upload(periods, 3))


def has_moved(model: Model, state: State, contacts: Contacts) -> NDArray[np.bool_]:
    """Whether any sample of a cell has moved since its contacts were found, shape (C,); samples must be up to date."""
    moved = (state.samples.numpy() != contacts.place.numpy()).any(axis=1)
    return np.logical_or.reduceat(moved, model.sample_start[model.segment_start[:-1]])


def empty_lists(model: Model, contacts: Contacts, size: int) -> wp.array[Any]:
    """Return a vector of ``size`` zeros for each pair, in the order of the lists."""
    return _rows(model, contacts.entry.shape[1], lambda shape: model.empty(shape, size))


def own_images(model: Model, contacts: Contacts) -> Any:
    """Return the images that the entries of contacts refer to, with the current periods."""
    return _images(model, table=contacts.table)


def _images(model: Model, *, table: wp.array[Any] | None = None, periods: wp.array[Any] | None = None) -> Any:
    """Return the current images, with another table or with other periods."""
    images = model.constants.images
    if not model.on_lattice:
        return images
    struct = images_struct(model.scalar, on_lattice=True)
    table, periods = images.image if table is None else table, images.periods if periods is None else periods
    return images_with(images, struct, table=table, periods=periods)


def _no_contacts(model: Model, place: wp.array[Any], capacity: int) -> Contacts:
    """Return empty lists with a capacity, for the current periods and the current table of images."""
    samples, images = model.sample_count, model.constants.images
    none = wp.zeros(0, dtype=wp.vec2i, device=model.device)
    return Contacts(
        place=place,
        periods=wp.clone(images.periods) if model.on_lattice else model.empty(0, 3),
        table=images.image if model.on_lattice else none,
        tangent=model.empty(samples, 3),
        count=_integers(model, samples),
        entry=_rows(model, capacity, lambda shape: _integers(model, shape)),
        anchor=_rows(model, capacity, lambda shape: model.empty(shape, 3)),
        press=_rows(model, capacity, lambda shape: model.empty(shape, 3)),
    )


def _rows(model: Model, capacity: int, empty: Callable[[tuple[int, int]], wp.array[Any]]) -> wp.array[Any]:
    """Return a list for each sample; on a GPU the lists of neighbouring samples are interleaved."""
    if model.device.is_cuda:
        return empty((capacity, model.sample_count)).transpose()
    return empty((model.sample_count, capacity))


def _integers(model: Model, shape: int | tuple[int, int]) -> wp.array[Any]:
    return wp.zeros(shape, dtype=wp.int32, device=model.device)
