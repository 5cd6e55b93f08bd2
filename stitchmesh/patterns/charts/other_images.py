# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Charts as GIF, BMP and TIFF images; the library of images decodes them in a process of its own.

Programs choose the palettes of these formats, so only the colours of the pixels count.
"""

from __future__ import annotations

from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from stitchmesh.errors import FileError
from stitchmesh.io.checkpoint_file import CheckpointFile
from stitchmesh.io.contents import FilePath, read_bytes
from stitchmesh.io.guarded_child import answer_of_child, answer_parent

FORMATS = {".gif": "GIF", ".bmp": "BMP", ".tif": "TIFF", ".tiff": "TIFF"}
"""Name of the format behind each suffix."""


def read_other_image(path: FilePath) -> np.ndarray[Any, np.dtype[np.uint8]]:
    """Return the colours of the pixels, shape (rows, columns, 3), the top row first.

    Raises:
        FileError: the file cannot be read, is no image of the suffix, is too large, has several pictures or transparent
            pixels, or the process that decodes it ends.
    """
    return answer_of_child(__name__, path).arrays["pixels"]


def packed_image(name: str, file: Path) -> CheckpointFile:
    """Decode an image in a child process, for its parent.

    Args:
        name: the name of the file, for messages; its suffix decides the format.
        file: where its content lies.

    Raises:
        FileError: the file cannot be read, is no image of its suffix, is too large, or has several pictures or
            transparent pixels.
    """
    from PIL import Image

    from stitchmesh.patterns.charts.chart_image import image_damages, loaded_chart

    kind = FORMATS[Path(name).suffix.lower()]
    try:
        with image_damages(name, kind):
            image = Image.open(BytesIO(read_bytes(file)), formats=[kind])
            pictures = getattr(image, "n_frames", 1)
        if pictures != 1:
            raise FileError(f"{name}: holds {pictures} pictures; expected one, save the chart alone")
        return CheckpointFile({}, {"pixels": np.asarray(loaded_chart(name, image, kind).convert("RGB"))})
    except (IndexError, KeyError, TypeError, AttributeError) as error:  # Decoders raise them for damaged files.
        raise FileError(f"{name}: is not a whole {kind} ({type(error).__name__}); write it again as PNG") from error


if __name__ == "__main__":
    answer_parent(packed_image, "PIL.Image")
