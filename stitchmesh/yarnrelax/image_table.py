# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The table of images that a periodic set of yarns needs, on the device.

Image 0 is (0, 0). The corners of a segment need the images that its yarn reaches by going around; contacts need every
image whose yarns can come near those of the cell: an image (a, b) is far if it shifts the box around all yarns, grown
by the contact range and by what yarns may spread, clear of itself. Where yarns outgrow that box, or periods have
shrunk, so that an image is missing, the table is made anew.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.lattice import Lattice, lattice_frame
from stitchmesh.yarn import YarnSet

if TYPE_CHECKING:
    from stitchmesh.yarnrelax.model import Model

CONTACT_RANGE = 3.0
"""Distance over the largest radius within which pairs may be listed: contact and the widest margin."""
SHRINKAGE = 0.75
"""Factor by which periods may shrink before the table is made anew."""
SPREAD = 10.0
"""How far yarns may spread beyond the box that they lie in, on each side, over the largest radius."""


def put_images(model: Model, kind: Any) -> Any:
    """The struct of images of a model's yarns."""
    images = kind()
    images.sample_count = model.sample_count
    if not model.on_lattice:
        return images
    periods = [member.yarns.lattice.periods / member.unit for member in model.members if member.yarns.lattice]
    images.periods = model.upload(np.concatenate(periods), 3)
    cell = np.repeat(np.arange(model.cell_count), np.diff(model.segment_start))
    images.segment_cell = model.integers(cell)
    images.sample_cell = model.integers(np.repeat(cell, np.diff(model.sample_start)))
    images.box = model.empty(2 * model.cell_count, 3)
    frames = [lattice_frame(member.yarns.lattice)[:2] for member in model.members if member.yarns.lattice]
    images.frame = model.upload(np.concatenate(frames), 3)
    _put_table(model, images, [member.yarns for member in model.members])
    return images


def renew_images(model: Model, cells: Sequence[YarnSet], *, anyway: bool = False) -> bool:
    """Make the table anew if it lacks an image of the members' yarns as they lie now, or anyway; whether it was."""
    table = model.constants.images.image.numpy()
    needed = np.concatenate([near_images(yarns, CONTACT_RANGE) for yarns in cells])
    if not anyway and _numbers(needed, table)[1].all():
        return False
    _put_table(model, model.constants.images, cells)
    return True


def _put_table(model: Model, images: Any, cells: Sequence[YarnSet]) -> None:
    near = np.concatenate([near_images(yarns, CONTACT_RANGE + 2 * SPREAD, SHRINKAGE) for yarns in cells])
    corner = np.concatenate([corner_images(member.yarns) for member in model.members])
    table = _distinct(np.concatenate([near, corner.reshape(-1, 2)]))
    number = _numbers(corner.reshape(-1, 2), table)[0].reshape(corner.shape[:2])
    images.image = wp.array(table.astype(np.int32), dtype=wp.vec2i, device=model.device)
    images.corner_image = wp.array(number.astype(np.int32), dtype=wp.vec4i, device=model.device)


def _distinct(images: NDArray[np.int64]) -> NDArray[np.int64]:
    """Images without repetition in ascending order, but (0, 0) first."""
    most = int(np.abs(images).max())
    there = np.zeros((2 * most + 1, 2 * most + 1), dtype=bool)
    there[images[:, 0] + most, images[:, 1] + most] = True
    there[most, most] = False
    return np.concatenate([[[0, 0]], np.argwhere(there) - most])


def _numbers(images: NDArray[Any], table: NDArray[Any]) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Place of each image in a table, and whether it is there."""
    most = int(max(np.abs(images).max(), np.abs(table).max()))
    place = np.full((2 * most + 1, 2 * most + 1), -1)
    place[table[:, 0] + most, table[:, 1] + most] = np.arange(len(table))
    number = place[images[:, 0] + most, images[:, 1] + most]
    return number, number >= 0


def corner_images(yarns: YarnSet) -> NDArray[np.int64]:
    """Image of each segment's four control points, shape (S, 4, 2)."""
    assert yarns.lattice_step is not None
    wrapped = np.diff(yarns.segment_points, axis=1) < 0
    wraps = np.concatenate([np.zeros((len(wrapped), 1), dtype=np.int64), np.cumsum(wrapped, axis=1)], axis=1)
    return wraps[:, :, None] * yarns.lattice_step[yarns.segment_yarn][:, None, :]


def near_images(yarns: YarnSet, reach: float, shrinkage: float = 1.0) -> NDArray[np.int64]:
    """Images whose yarns come within ``reach`` of those of the cell, in largest radii, shape (n, 2).

    Also where the periods alone become shorter by a factor.
    """
    assert yarns.lattice is not None and yarns.point_shift is not None
    corners = (yarns.points[yarns.segment_points] + yarns.point_shift).reshape(-1, 3)
    shrunk = Lattice(yarns.lattice.periods * shrinkage)
    return shrunk.near_images(corners, reach * float(yarns.radius.max()))
