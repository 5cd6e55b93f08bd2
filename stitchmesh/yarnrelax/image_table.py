# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The table of images that a periodic set of yarns needs, on the device.

Image 0 is (0, 0). The corners of a segment need the images that its yarn reaches by going around; contacts need every
image whose yarns can come near those of the cell: an image (a, b) is far if it shifts the box around all yarns, grown
by the contact range and by what yarns may spread, clear of itself. Yarns that outgrow that box are an error.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.errors import SolverError
from stitchmesh.yarn import YarnSet

if TYPE_CHECKING:
    from stitchmesh.yarnrelax.model import Model

CONTACT_RANGE = 3.0
"""Distance over the largest radius within which pairs may be listed: contact and the widest margin."""
SPREAD = 10.0
"""How far yarns may spread beyond the box that they start in, on each side, over the largest radius."""


def put_images(model: Model, kind: Any) -> Any:
    """The struct of images of a model's yarns."""
    images = kind()
    images.sample_count = model.sample_count
    if model.yarns.lattice is None:
        return images
    corner = corner_images(model.yarns)
    table = np.unique(np.concatenate([near_images(model.yarns), corner.reshape(-1, 2)]), axis=0)
    table = np.concatenate([[[0, 0]], table[table.any(axis=1)]])
    number = (corner[:, :, None, :] == table).all(axis=3).argmax(axis=2)
    images.periods = model.upload(model.yarns.lattice.periods / model.unit, 3)
    images.image = wp.array(table.astype(np.int32), dtype=wp.vec2i, device=model.device)
    images.corner_image = wp.array(number.astype(np.int32), dtype=wp.vec4i, device=model.device)
    return images


def corner_images(yarns: YarnSet) -> NDArray[np.int64]:
    """Image of each segment's four control points, shape (S, 4, 2)."""
    assert yarns.lattice_step is not None
    wrapped = np.diff(yarns.segment_points, axis=1) < 0
    wraps = np.concatenate([np.zeros((len(wrapped), 1), dtype=np.int64), np.cumsum(wrapped, axis=1)], axis=1)
    return wraps[:, :, None] * yarns.lattice_step[yarns.segment_yarn][:, None, :]


def near_images(yarns: YarnSet) -> NDArray[np.int64]:
    """Images whose yarns may touch those of the cell, shape (n, 2)."""
    assert yarns.lattice is not None and yarns.point_shift is not None
    corners = (yarns.points[yarns.segment_points] + yarns.point_shift).reshape(-1, 3)
    reach = (CONTACT_RANGE + 2 * SPREAD) * float(yarns.radius.max())
    # rows of the dual basis tell how many periods a displacement spans
    dual = np.linalg.pinv(yarns.lattice.periods).T
    place = corners @ dual.T
    span = place.max(axis=0) - place.min(axis=0) + reach * np.linalg.norm(dual, axis=1)
    most = np.ceil(span).astype(np.int64)
    a, b = np.meshgrid(np.arange(-most[0], most[0] + 1), np.arange(-most[1], most[1] + 1), indexing="ij")
    images = np.stack([a.ravel(), b.ravel()], axis=1)
    size = corners.max(axis=0) - corners.min(axis=0) + reach
    return images[(np.abs(yarns.lattice.shift(images)) <= size).all(axis=1)]


def refuse_spread(model: Model, points: NDArray[np.float64]) -> None:
    """Check that the table still holds all images that can touch.

    Args:
        model: of yarns on a lattice.
        points: its control points now [cm], shape (N, 3).

    Raises:
        SolverError: the yarns have spread too far; it names one that did.
    """
    start, allowed = model.yarns.points, 2 * SPREAD * float(model.yarns.radius.max())
    grown = np.ptp(points, axis=0) - np.ptp(start, axis=0)
    along = np.abs(model.yarns.lattice.periods).max(axis=0) > 0.0 if model.yarns.lattice is not None else grown > 0.0
    if (grown[along] <= allowed).all():
        return
    axis = int(np.argmax(np.where(along, grown, -np.inf)))
    yarn = int(model.yarns.point_yarn[points[:, axis].argmax()])
    raise SolverError(
        f"yarn {yarn}: spreads {grown[axis]:.3g} cm beyond its cell; expected at most {allowed:.3g} cm; "
        "start from a larger cell, or from yarns nearer to rest"
    )
