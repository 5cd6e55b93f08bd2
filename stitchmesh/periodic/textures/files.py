# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Texture maps as PNG images in a folder, with a ``textures.json`` that describes them."""

from __future__ import annotations

import io
import json
import zipfile
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
    "colour": "sRGB without lamps; hollows are darker",
    "height": "16 bits, linear from 0 at the lowest point of the yarns to 65535 at height_cm above it; 0 in holes",
    "normal": "OpenGL convention: red along u, green upwards at right angles to u, blue out of the fabric; 128 is 0",
    "opacity": "255 where yarn covers the pixel, 0 in holes",
    "tangent": "along the yarn: red and green a unit vector in the plane, blue the sine of the slope; 128 is 0",
}
"""The images and the meaning of their values."""


def write_textures(folder: FilePath, maps: TextureMaps) -> None:
    """Write ``colour.png``, ``height.png``, ``normal.png``, ``opacity.png``, ``tangent.png`` and ``textures.json``.

    Raises:
        FileError: the folder cannot be made or written.
    """
    for name, image in images(maps).items():
        write_bytes(Path(folder) / f"{name}.png", _png(image))
    write_json(fspath(Path(folder) / "textures.json"), _description(maps))


def texture_archive(maps: TextureMaps) -> bytes:
    """Return a ZIP archive of the files that ``write_textures`` writes."""
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, image in images(maps).items():
            archive.writestr(f"{name}.png", _png(image), zipfile.ZIP_STORED)
        archive.writestr("textures.json", json.dumps(_description(maps), indent=2) + "\n")
    return content.getvalue()


def _description(maps: TextureMaps) -> dict[str, Any]:
    """Return the content of ``textures.json``."""
    u, v = maps.lattice.periods
    return {
        "maps": {name: {"file": f"{name}.png", "is": text} for name, text in DESCRIPTIONS.items()},
        "pixels": [maps.height.shape[1], maps.height.shape[0]],
        "size_cm": [float(np.linalg.norm(u)), float(np.linalg.norm(v))],
        "periods_cm": [u.tolist(), v.tolist()],
        "height_cm": maps.depth,
        "layout": "columns are fractions of u from the left, rows are fractions of v from the bottom",
    }


def images(maps: TextureMaps) -> dict[str, NDArray[np.uint8] | NDArray[np.uint16]]:
    """Return the maps as the files store them: 16 bits for the height, 8 bits for each channel of the other maps."""
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
    """Map -1 ... 1 to 1 ... 255, so that 0 is stored exactly as 128."""
    return np.round(128 + 127 * np.clip(values, -1.0, 1.0)).astype(np.uint8)


def _png(image: NDArray[np.uint8] | NDArray[np.uint16]) -> bytes:
    from PIL import Image

    content = io.BytesIO()
    Image.fromarray(image).save(content, format="PNG")
    return content.getvalue()
