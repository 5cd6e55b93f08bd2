# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Bodies of a scene, as a panel adds and changes them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np

from stitchmesh.app.pages.drape.entry_list import with_entry
from stitchmesh.app.pages.drape.held_parts import motion_words
from stitchmesh.app.pages.drape.opened_scene import OpenedScene
from stitchmesh.app.pages.drape.typed_numbers import as_text
from stitchmesh.mixed.scene.motion_section import BodySection
from stitchmesh.mixed.scene.scene import Scene

SHARE = 0.25
"""Radius of a new ball, and half of a side of a new box, over the smaller one of the width and height of the cloth."""
GAP = 1.2
"""Distance of the middle of a new shape from the cloth, over its radius."""
SIZE_WORDS = {"ball": "radius", "box": "sides", "arm": "radius, upper arm, forearm"}
"""What the numbers of the size of a shape are."""


def body_of_file(path: Path, unit: str) -> BodySection:
    """Return the body of a mesh file."""
    return BodySection(name=path.stem, file=str(path.absolute()), unit=unit)


def new_shape(opened: OpenedScene, shape: Literal["ball", "box"]) -> BodySection:
    """Return a ball or a box in front of the cloth, or below a cloth that lies."""
    low, high = opened.mesh.vertices.min(axis=0), opened.mesh.vertices.max(axis=0)
    radius = max(SHARE * float(np.sort(high - low)[1]), 0.1)
    middle, extent = (low + high) / 2.0, high - low
    if int(np.argmin(extent)) == 1:
        middle[1] = low[1] - GAP * radius
    else:
        middle[2] = high[2] + GAP * radius
    x, y, z = np.round(middle, 3).tolist()
    size = (radius,) if shape == "ball" else (2.0 * radius,) * 3
    name = f"{shape} {len(opened.scene.bodies) + 1}"
    return BodySection(name=name, shape=shape, centre=(x, y, z), size=tuple(round(side, 3) for side in size))


def with_body(scene: Scene, body: BodySection) -> Scene:
    """Return a scene with one more body."""
    return replace(scene, bodies=(*scene.bodies, body))


def with_changed_body(scene: Scene, number: int, body: BodySection | None) -> Scene:
    """Return a scene with another body in the place of one; None removes it."""
    return replace(scene, bodies=with_entry(scene.bodies, number, body))


def body_words(scene: Scene) -> list[str]:
    """Return what each body is, and how it moves."""
    return [f"{body.name}: {_shape_words(body)}, {motion_words(body.keyframes)}" for body in scene.bodies]


def _shape_words(body: BodySection) -> str:
    if body.shape is None:
        return f"mesh {Path(body.file or '').name} in {body.unit}"
    return f"{body.shape} of {as_text(body.size)} cm at {as_text(body.centre)}"
