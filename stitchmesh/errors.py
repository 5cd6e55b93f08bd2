# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The errors that StitchMesh raises on purpose.

A message is one line. It says what is wrong, where (an index), what was found, what was expected and how to correct
it. The command line prints the message unchanged and exits with status 2.
"""

from __future__ import annotations

from collections.abc import Sequence

from numpy.typing import NDArray


class StitchMeshError(Exception):
    """Base class of all errors below; a handler of this class catches all of them."""


class FileError(StitchMeshError):
    """A file cannot be read or written, or its content does not match its format."""


class ParameterError(StitchMeshError):
    """The user gave a number or a name that the operation does not accept."""


class MeshError(StitchMeshError):
    """A polygon mesh is not an oriented manifold surface with valid coordinates."""


class LabelError(StitchMeshError):
    """A mesh cannot be separated into knitting rows."""

    def __init__(self, message: str, *, labeling: object | None = None) -> None:
        """Make an error; ``labeling`` is the ``PartialLabeling`` that shows the faces at fault, if there is one."""
        super().__init__(message)
        self.labeling = labeling


class TessellationError(StitchMeshError):
    """A labeled mesh cannot be divided into legal stitch faces with the requested counts."""


class PatternError(StitchMeshError):
    """A knitting pattern cannot be read, or its stitches do not fit together."""


class YarnError(StitchMeshError):
    """A set of yarns is malformed, or yarns cannot be generated from a stitch mesh."""


class SolverError(StitchMeshError):
    """A relaxation cannot continue; the last good state was kept."""


class DisplayError(StitchMeshError):
    """Pictures cannot be drawn on this machine."""


def first_few(items: Sequence[object] | NDArray, limit: int = 3) -> str:
    """List the first items and count the others: ``4, 7, 9 (+12 more)``.

    Args:
        items: what to list, for example the indices of all faces that failed a check.
        limit: number of items to list.
    """
    shown = ", ".join(str(item) for item in items[:limit])
    rest = len(items) - limit
    return f"{shown} (+{rest} more)" if rest > 0 else shown
