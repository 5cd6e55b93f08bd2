# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The table of images that a periodic set of yarns needs, on the device.

Image 0 is (0, 0). The corners of a segment need the images that its yarn reaches by going around; contacts need every
image whose yarns can come near those of the cell: an image (a, b) is far if it shifts the box around all yarns, grown
by the contact range and by what yarns may spread, clear of itself. Where yarns outgrow that box, or periods have
shrunk, so that an image is missing, the table is made anew.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.lattice import lattice_frame

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
    periods = np.stack([m.yarns.lattice.periods for m in model.members if m.yarns.lattice]) / model.units[:, None, None]
    images.periods = model.upload(periods.reshape(-1, 3), 3)
    cell = np.repeat(np.arange(model.cell_count), np.diff(model.segment_start))
    images.segment_cell = model.integers(cell)
    images.sample_cell = model.integers(np.repeat(cell, np.diff(model.sample_start)))
    images.box = model.empty(2 * model.cell_count, 3)
    images.frame = model.upload(lattice_frame(periods)[:, :2].reshape(-1, 3), 3)
    _put_table(model, images, model.to_device(model.yarns.points), periods)
    return images


def renew_images(model: Model, points: wp.array[Any], *, anyway: bool = False) -> bool:
    """Make the table anew if it lacks an image of the yarns as they lie now, or anyway; whether it was."""
    images = model.constants.images
    places, periods = points.numpy()[: model.point_count], images.periods.numpy().reshape(-1, 2, 3)
    needed = near_images(model, places, periods, CONTACT_RANGE)
    if not anyway and _numbers(needed, images.image.numpy())[1].all():
        return False
    _put_table(model, images, places, periods)
    return True


def _put_table(model: Model, images: Any, places: NDArray[Any], periods: NDArray[Any]) -> None:
    near = near_images(model, places, periods, CONTACT_RANGE + 2 * SPREAD, SHRINKAGE)
    corner = model.corner_images
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


def near_images(
    model: Model, places: NDArray[Any], periods: NDArray[Any], reach: float, shrinkage: float = 1.0
) -> NDArray[np.int64]:
    """Images in which yarns of some cell come within ``reach`` of its own, in its largest radii, shape (n, 2).

    The rule of ``Lattice.near_images``, for all cells at once; also where the periods alone become shorter by a factor.

    Args:
        model: the cells.
        places: their control points [units], shape (N, 3).
        periods: their periods [units], shape (C, 2, 3).
        reach: over the largest radius of a cell.
        shrinkage: that factor.
    """
    wrapped = np.argwhere(model.corner_images.any(axis=2))
    cell = np.searchsorted(model.segment_start, wrapped[:, 0], side="right") - 1
    image, point = model.corner_images[wrapped[:, 0], wrapped[:, 1]], model.yarns.segment_points[*wrapped.T]
    corners = _Corners(model, places, cell, places[point] + np.einsum("ea,ead->ed", image, periods[cell]))
    shrunk = periods * shrinkage
    dual = np.linalg.pinv(shrunk).transpose(0, 2, 1)
    within = reach * np.maximum.reduceat(model.radius, model.yarn_start[:-1])[:, None]
    most = np.ceil(corners.spans(dual) + within * np.linalg.norm(dual, axis=2)).astype(np.int64)
    a, b = (np.arange(-largest, largest + 1) for largest in most.max(axis=0))
    images = np.stack(np.meshgrid(a, b, indexing="ij"), axis=2).reshape(-1, 2)
    room = corners.spans(np.broadcast_to(np.eye(3), (model.cell_count, 3, 3))) + within
    clear = np.abs(np.einsum("ia,cad->cid", images, shrunk)) > room[:, None, :]
    near = ~clear.any(axis=2) & (np.abs(images)[None] <= most[:, None, :]).all(axis=2)
    return images[near.any(axis=0)]


@dataclass(frozen=True, eq=False)
class _Corners:
    """Where the corners of all segments lie: at control points, and at some of them in other images."""

    model: Model
    places: NDArray[Any]
    """Control points, shape (N, 3)."""
    cell: NDArray[np.int64]
    """Cell of each corner in another image, shape (E,)."""
    others: NDArray[Any]
    """Where those lie, shape (E, 3)."""

    def spans(self, along: NDArray[Any]) -> NDArray[Any]:
        """How far the corners of each cell reach along vectors of its own, shape (C, d, 3) to (C, d)."""
        first, counts = self.model.point_start[:-1], np.diff(self.model.point_start)
        own = np.einsum("nd,nkd->nk", self.places, np.repeat(along, counts, axis=0))
        other = np.einsum("ed,ekd->ek", self.others, along[self.cell])
        high, low = np.maximum.reduceat(own, first), np.minimum.reduceat(own, first)
        np.maximum.at(high, self.cell, other)
        np.minimum.at(low, self.cell, other)
        return high - low
