# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The picture that shows which faces of a mesh cannot be labeled."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from stitchmesh.errors import DisplayError, LabelError

FAULTS_PICTURE = "labeling-faults.png"
"""Name of the picture."""


@contextmanager
def faults_drawn(folder: Path) -> Iterator[None]:
    """Draw the faces at fault if a mesh cannot be labeled in this block, and name the picture in the error.

    Args:
        folder: folder of the picture.

    Raises:
        LabelError: the error of the block, with the name of the picture if this machine can draw pictures.
    """
    try:
        yield
    except LabelError as error:
        from stitchmesh.labeling import PartialLabeling

        if not isinstance(error.labeling, PartialLabeling):
            raise
        from stitchmesh.render.labeling_picture import render_labeling

        picture = folder / FAULTS_PICTURE
        try:
            render_labeling(error.labeling, picture)
        except DisplayError:
            raise error from None
        raise LabelError(f"{error}; {picture} shows the faces", labeling=error.labeling) from error
