# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What a user may say about the mesh of a garment in a file that says little about it."""

from __future__ import annotations

from dataclasses import dataclass

from stitchmesh.io.units import CENTIMETRES, DEFAULT_UNIT
from stitchmesh.mesh.layers import Layer
from stitchmesh.mesh.upright import Direction
from stitchmesh.settings import setting


@dataclass(frozen=True, kw_only=True)
class MeshReading:
    """The part of a mesh file that is knitted, its unit and its upward direction."""

    unit: str = setting(
        DEFAULT_UNIT, f"unit of a file that states no unit: {', '.join(CENTIMETRES)}", form="UNIT"
    )
    up: Direction | None = setting(
        None, "direction in the file that points up, which becomes y: an axis such as z or -x, or three numbers",
        form="AXIS|X,Y,Z", unset="as the file states, or as its openings tell", example=(0, 0, 1),
    )  # fmt: skip
    objects: tuple[str, ...] = setting(
        (), "object or group of the file that is knitted, by its name; may be repeated", flag="object", form="NAME",
        unset="all that can be garments",
    )  # fmt: skip
    layer: Layer = setting(
        "outer", "layer of a garment with a thickness that is knitted: outer, inner or middle", form="LAYER"
    )
