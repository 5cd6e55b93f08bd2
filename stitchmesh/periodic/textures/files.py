# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Texture maps as PNG pictures in a folder, with a ``textures.json`` that says what they are."""

from __future__ import annotations

import io
from os import fspath
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stitchmesh.io.atomic import write_bytes, write_json
from stitchmesh.io.contents import FilePath
from stitchmesh.mesh import FloatArray
from stitchmesh.periodic.textures.textures import TextureMaps

DESCRIPTIONS = {
    "colour": "sRGB, no lamp in it, only hollows are darker",
    "height": "16 bits, linear from 0 at the lowest point of the yarns to 65535 at height_cm above it; 0 in holes",
    "normal": "OpenGL convention: red along u, green up at right angles to u, blue out; 128 is 0",
    "opacity": "255 where yarn covers the pixel, 0 where one sees through",
    "tangent": "along the yarn: red and green a unit vector in the plane, blue the sine of its climb; 128 is 0",
}
"""The pictures and how to read them."""


def write_textures(folder: FilePath, maps: TextureMaps) -> None:
    """Write ``colour.png``, ``height.png``, ``normal.png``, ``opacity.png``, ``tangent.png`` and ``textures.json``.

    Raises:
        FileError: the folder cannot be made or written.
    """
    for name, picture in pictures(maps).items():
        write_bytes(Path(folder) / f"{name}.png", _png(picture))
    u, v = maps.lattice.periods
    content: dict[str, Any] = {
        "maps": {name: {"file": f"{name}.png", "is": text} for name, text in DESCRIPTIONS.items()},
        "pixels": [maps.height.shape[1], maps.height.shape[0]],
        "size_cm": [float(np.linalg.norm(u)), float(np.linalg.norm(v))],
        "periods_cm": [u.tolist(), v.tolist()],
        "height_cm": maps.depth,
        "layout": "columns are shares of u from the left, rows shares of v from below",
    }
    write_json(fspath(Path(folder) / "textures.json"), content)


def pictures(maps: TextureMaps) -> dict[str, NDArray[np.uint8] | NDArray[np.uint16]]:
    """The maps as their files store them: 8 bits a channel, the height 16."""
    return {
        "colour": _bytes(maps.colour),
        "height": np.round(65535 * np.clip(maps.height / maps.depth, 0.0, 1.0)).astype(np.uint16),
        "normal": _signed(maps.normal),
        "opacity": _bytes(maps.opacity),
        "tangent": _signed(maps.tangent),
    }


def _bytes(values: FloatArray) -> NDArray[np.uint8]:
    return np.round(255 * np.clip(values, 0.0, 1.0)).astype(np.uint8)


def _signed(values: FloatArray) -> NDArray[np.uint8]:
    """From -1 ... 1 to 1 ... 255, so that 0 is a number too."""
    return np.round(128 + 127 * np.clip(values, -1.0, 1.0)).astype(np.uint8)


def _png(picture: NDArray[np.uint8] | NDArray[np.uint16]) -> bytes:
    from PIL import Image

    content = io.BytesIO()
    Image.fromarray(picture).save(content, format="PNG")
    return content.getvalue()
