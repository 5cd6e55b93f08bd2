# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Tubes of yarns with levels of detail: near yarns are tubes, far yarns are lines, and the farthest have fewer points.

The server sends only packed control points, as properties of a mesh of one empty triangle, the carrier. The script
``yarn_tubes.js`` makes the triangles in the page. It chooses the level of each block by the radius of the yarn on the
screen of that page, and takes coarser levels while there are more triangles than the budget. A camera therefore moves
without a message, and two browsers may look at different places.
"""

from __future__ import annotations

from dataclasses import astuple, dataclass
from typing import Any

import numpy as np

from stitchmesh.app.scene.drawing import YarnTubes
from stitchmesh.render.yarn_blocks import pack_colours, pack_points


@dataclass(frozen=True)
class Level:
    """A level of detail of a block of yarns."""

    least_radius: float
    """Smallest radius of the yarn on the screen for which the level is used [pixels]."""
    sides: int
    """Sides of the tubes; 0 for lines."""
    samples: int
    """Number of rings for each segment; 0 if there are fewer rings than segments."""
    stride: int
    """Number of segments from one ring to the next, if there are fewer rings than segments."""


LEVELS = (
    Level(14.0, 10, 3, 1),
    Level(5.0, 8, 2, 1),
    Level(2.0, 6, 1, 1),
    Level(0.6, 4, 1, 1),
    Level(0.3, 3, 0, 2),
    Level(0.15, 0, 0, 2),
    Level(0.0, 0, 0, 4),
)
"""Levels from the finest to the coarsest; the coarsest is used at any larger distance."""


def add_tubes(scene: Any, name: str, tubes: YarnTubes) -> Any:
    """Draw yarns in a scene of viser, and return the carrier."""
    low, high = tubes.points.min(axis=0), tubes.points.max(axis=0)
    carrier = scene.add_mesh_simple(
        name, np.array([low, high, low], dtype=np.float32), np.array([[0, 1, 2]], dtype=np.uint32),
        color=(255, 255, 255), cast_shadow=False, receive_shadow=False,
    )  # fmt: skip
    _send(carrier, _structure(tubes) | _copies(tubes) | _colours(tubes) | _points(tubes))
    return carrier


def update_tubes(carrier: Any, before: YarnTubes, now: YarnTubes) -> bool:
    """Send the differences from the drawing before; return False if the blocks differ, so that all must be sent."""
    if before.blocks is not now.blocks:
        return False
    changes: dict[str, object] = {}
    if before.copies is not now.copies:
        changes |= _copies(now)
    if before.colours is not now.colours:
        changes |= _colours(now)
    if before.points is not now.points:
        changes |= _points(now)
    _send(carrier, changes)
    return True


def _send(carrier: Any, properties: dict[str, object]) -> None:
    """Set properties of a carrier that viser does not know; browsers that connect later get them too."""
    for name, value in properties.items():
        carrier._queue_update(name, value)


def _structure(tubes: YarnTubes) -> dict[str, object]:
    blocks = tubes.blocks
    return {
        "yarn_blocks": blocks.block_start.astype(np.uint32),
        "yarn_runs": blocks.run_start.astype(np.uint32),
        "yarn_radius": blocks.radius,
        "yarn_levels": np.array([astuple(level) for level in LEVELS], dtype=np.float32).ravel(),
        "yarn_budget": 2_000_000.0,  # Fewer while the camera of a page with slow graphics moves.
    }


def _copies(tubes: YarnTubes) -> dict[str, object]:
    return {"yarn_copies": np.asarray(tubes.copies, dtype=np.float32).ravel()}


def _colours(tubes: YarnTubes) -> dict[str, object]:
    index, palette = pack_colours(tubes.blocks, tubes.colours)
    return {"yarn_index": index, "yarn_palette": palette.ravel()}


def _points(tubes: YarnTubes) -> dict[str, object]:
    packed = pack_points(tubes.blocks, tubes.points)
    return {"yarn_low": packed.low.ravel(), "yarn_step": packed.step.ravel(), "yarn_points": packed.values.ravel()}
