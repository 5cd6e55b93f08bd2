# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Every error that StitchMesh raises on purpose.

A message says what is wrong, where (an index), what was found, what was expected and how to mend it, on one
line: the command line prints it as it stands and exits with status 2.
"""

from __future__ import annotations

from collections.abc import Sequence

from numpy.typing import NDArray


class StitchMeshError(Exception):
    """Base of all errors below; catch this one to catch them all."""


class FileError(StitchMeshError):
    """A file cannot be read or written, or does not hold what its format promises."""


class ParameterError(StitchMeshError):
    """A number or a name given by the user is outside what the operation accepts."""


class MeshError(StitchMeshError):
    """A polygon mesh is not an oriented manifold surface with valid coordinates."""


class LabelError(StitchMeshError):
    """A mesh cannot be separated into knitting rows."""


class TessellationError(StitchMeshError):
    """A labeled mesh cannot be divided into legal stitch faces with the counts asked for."""


class PatternError(StitchMeshError):
    """A knitting pattern cannot be read, or its stitches do not fit together."""


class YarnError(StitchMeshError):
    """A set of yarns is malformed, or a stitch mesh cannot be turned into yarns."""


class SolverError(StitchMeshError):
    """A relaxation cannot go on; the last good state was kept."""


class DisplayError(StitchMeshError):
    """Pictures cannot be drawn on this machine."""


def first_few(items: Sequence[object] | NDArray, limit: int = 3) -> str:
    """Name the first offenders and count the rest: ``4, 7, 9 (+12 more)``."""
    shown = ", ".join(str(item) for item in items[:limit])
    rest = len(items) - limit
    return f"{shown} (+{rest} more)" if rest > 0 else shown
