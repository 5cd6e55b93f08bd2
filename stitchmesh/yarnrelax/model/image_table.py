# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The table of images that a periodic set of yarns needs, on the device.

Image 0 is (0, 0). The corners of a segment need the images that its yarn reaches by going around the lattice. Contacts
need every image whose yarns can come near the yarns of the cell. An image (a, b) is left out if the box around all
yarns does not overlap its displaced copy, enlarged by the contact range and by a reserve for yarns that spread. If
yarns grow beyond this reserve, or periods have become too short, the table is made again.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.errors import SolverError
from stitchmesh.lattice import images_up_to, lattice_frame

if TYPE_CHECKING:
    from stitchmesh.yarnrelax.model.constants import Model

CONTACT_RANGE = 3.0
"""Distance over the largest radius within which pairs may be listed: the contact distance plus the widest margin."""
SHRINKAGE = 0.75
"""Periods may shrink by this factor before the table is made again."""
SPREAD = 10.0
"""Yarns may spread beyond their box on each side by this distance, over the largest radius."""


def put_images(model: Model, kind: Any) -> Any:
    """Return the struct of images of a model's yarns."""
    images = kind()
    images.sample_count = model.sample_count
    if not model.on_lattice:
        return images
    periods = np.stack([m.yarns.lattice.periods for m in model.cells if m.yarns.lattice]) / model.units[:, None, None]
    images.periods = model.upload(periods.reshape(-1, 3), 3)
    cell = np.repeat(np.arange(model.cell_count), np.diff(model.segment_start))
    images.segment_cell, images.resting = model.integers(cell), model.resting
    images.sample_cell = model.integers(np.repeat(cell, np.diff(model.sample_start)))
    images.box = model.empty(2 * model.cell_count, 3)
    images.frame = model.upload(lattice_frame(periods)[:, :2].reshape(-1, 3), 3)
    _put_table(model, images, corners_of(model, model.to_device(model.yarns.points), periods))
    return images


def renew_images(model: Model, points: wp.array[Any]) -> NDArray[np.int64]:
    """Make the table again for the yarns at ``points``, and return the new numbers of its former images.

    The table of several cells keeps its former images, because lists of cells that need no new lists name them. Images
    that are left out get the number -1.
    """
    images = model.constants.images
    former = images.image.numpy().astype(np.int64)
    _put_table(model, images, _corners_at(model, points), former if model.cell_count > 1 else former[:0])
    return _numbers(former, images.image.numpy())[0]


def has_images(model: Model, points: wp.array[Any]) -> bool:
    """Return whether the table has all images that the yarns at ``points`` need now."""
    needed = near_images(_corners_at(model, points), CONTACT_RANGE)
    return bool(_numbers(needed, model.constants.images.image.numpy())[1].all())


def _corners_at(model: Model, points: wp.array[Any]) -> Corners:
    """Measure the corners of all cells for control points and the present periods."""
    places, periods = points.numpy()[: model.point_count], model.constants.images.periods.numpy()
    return corners_of(model, places, periods.reshape(-1, 2, 3))


def has_room(model: Model, points: wp.array[Any], cells: NDArray[np.bool_]) -> bool:
    """Return whether the table has all images that a new table would have for some cells, shape (C,)."""
    images = model.constants.images
    places, periods = points.numpy()[: model.point_count], images.periods.numpy().reshape(-1, 2, 3)
    corners = corners_of(model, places, periods, np.flatnonzero(cells))
    needed = near_images(corners, CONTACT_RANGE + 2 * SPREAD, SHRINKAGE)
    return bool(_numbers(needed, images.image.numpy())[1].all())


def _put_table(model: Model, images: Any, corners: Corners, further: NDArray[np.int64] | None = None) -> None:
    """Make the table of the images that yarns with these corners may need, and of further ones, shape (I, 2)."""
    segment, slot, image = model.wrapped
    needed = near_images(corners, CONTACT_RANGE + 2 * SPREAD, SHRINKAGE)
    table = _distinct(np.concatenate([needed, image, *([] if further is None else [further])]))
    number = np.zeros((model.segment_count, 4), dtype=np.int32)
    number[segment, slot] = _numbers(image, table)[0]
    images.image = wp.array(table.astype(np.int32), dtype=wp.vec2i, device=model.device)
    images.corner_image = wp.array(number, dtype=wp.vec4i, device=model.device)


def joined_table(table: wp.array[Any], other: wp.array[Any]) -> tuple[wp.array[Any], NDArray[np.int64]]:
    """Return a table with the images of one and then those of another, and the places of the latter in it, shape (I,).

    If the other table begins with all images of the first, it is returned itself.
    """
    images, others = table.numpy(), other.numpy()
    if len(others) >= len(images) and np.array_equal(others[: len(images)], images):
        return other, np.arange(len(others))
    number, there = _numbers(others, images)
    number[~there] = len(images) + np.arange(np.count_nonzero(~there))
    return wp.array(np.concatenate([images, others[~there]]), dtype=wp.vec2i, device=table.device), number


def _distinct(images: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the images without repetition, (0, 0) first and the others in ascending order."""
    most = np.abs(images).max(axis=0)
    there = np.zeros(2 * most + 1, dtype=bool)
    there[tuple((images + most).T)] = True
    there[tuple(most)] = False
    return np.concatenate([[[0, 0]], np.argwhere(there) - most])


def _numbers(images: NDArray[Any], table: NDArray[Any]) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Return the place of each image in a table, and whether it is there."""
    most = np.abs(np.concatenate([images, table])).max(axis=0)
    place = np.full(2 * most + 1, -1)
    place[tuple((table + most).T)] = np.arange(len(table))
    number = place[tuple((images + most).T)]
    return number, number >= 0


@dataclass(frozen=True, eq=False)
class Corners:
    """Extents of the corners of each cell's segments, for given periods [units]."""

    periods: NDArray[Any]
    """The periods, shape (C, 2, 3)."""
    dual: NDArray[Any]
    """Dual basis of each cell: how many of each period a displacement spans, shape (C, 2, 3)."""
    box: NDArray[Any]
    """Size of the box around the corners of each cell, shape (C, 3)."""
    turns: NDArray[Any]
    """Number of each period that the corners span, shape (C, 2)."""
    radius: NDArray[np.float64]
    """Largest radius of each cell, shape (C,)."""


def corners_of(
    model: Model, places: NDArray[Any], periods: NDArray[Any], cells: NDArray[np.int64] | None = None
) -> Corners:  # fmt: skip
    """Measure the corners for control points [units] of shape (N, 3) and periods.

    Args:
        model: the cells.
        places: control points of all cells.
        periods: periods of all cells [units], shape (C, 2, 3).
        cells: numbers of the cells that are measured; all by default. A cell that has left the numbers is not measured,
            so that it ends alone and not with the whole batch (``too_close`` refuses it).

    Raises:
        SolverError: no cell has finite places and periods.
    """
    start, point, image = model.segment_corners
    chosen = np.arange(model.cell_count) if cells is None else cells
    lost = np.add.reduceat(~np.isfinite(places).all(axis=1), model.point_start[:-1]) > 0
    chosen = chosen[~lost[chosen] & np.isfinite(periods[chosen]).all(axis=(1, 2))]
    if not len(chosen):
        raise SolverError("images of the cell: a place of the yarns is not finite; take softer yarns or smaller loads")
    counts = np.diff(start)[chosen]
    first = np.concatenate([[0], np.cumsum(counts)[:-1]])
    corner = np.arange(counts.sum()) + np.repeat(start[chosen] - first, counts)
    periods, cell = periods[chosen], np.repeat(np.arange(len(chosen)), counts)
    dual = np.linalg.pinv(periods).transpose(0, 2, 1)
    place = places[point[corner]] + np.einsum("ea,ead->ed", image[corner], periods[cell])
    turns = np.einsum("ed,ekd->ek", place, dual[cell])
    box, turns = (np.maximum.reduceat(own, first) - np.minimum.reduceat(own, first) for own in (place, turns))
    radius = np.maximum.reduceat(model.radius, model.yarn_start[:-1])[chosen]
    return Corners(periods, dual, box, turns, radius)


def near_images(corners: Corners, reach: float, shrinkage: float = 1.0) -> NDArray[np.int64]:
    """Return the images in which yarns of some cell come within ``reach`` of the cell, in its largest radii, (n, 2).

    The rule is the same as in ``Lattice.near_images``, with the given periods times the factor ``shrinkage``.
    """
    within = reach * corners.radius[:, None]
    turns = corners.turns + within * np.linalg.norm(corners.dual, axis=2)
    most = np.ceil(turns / shrinkage)
    images = images_up_to(most.max(axis=0))
    shift = np.einsum("ia,cad->cid", images, corners.periods * shrinkage)
    clear = np.abs(shift) > (corners.box + within)[:, None, :]
    near = ~clear.any(axis=2) & (np.abs(images)[None] <= most[:, None, :]).all(axis=2)
    return images[near.any(axis=0)]
