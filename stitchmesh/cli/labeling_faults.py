# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The picture that shows which faces of a mesh cannot be labeled."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from stitchmesh.errors import DisplayError, LabelError

REMEDY = "knit it with --auto"
"""What helps a mesh of any kind: rows are found on it without labels."""


@contextmanager
def faults_drawn(folder: Path, remedy: str = REMEDY) -> Iterator[None]:
    """Draw the faces at fault if a mesh cannot be labeled in this block, and name the picture in the error.

    Args:
        folder: folder of the picture.
        remedy: what to do instead of labeling the mesh, for the error.

    Raises:
        LabelError: the error of the block with the remedy, and with the name of the picture if this machine can draw
            pictures.
    """
    try:
        yield
    except LabelError as error:
        from stitchmesh.labeling import PartialLabeling

        if not isinstance(error.labeling, PartialLabeling):
            raise
        from stitchmesh.render.labeling_picture import render_labeling

        picture = folder / "labeling-faults.png"
        message = f"{remedy}, which finds rows where a mesh has none; or change the mesh: {error}"
        try:
            render_labeling(error.labeling, picture)
        except DisplayError:
            raise LabelError(message, labeling=error.labeling) from error
        raise LabelError(f"{message}; {picture} shows the faces", labeling=error.labeling) from error
