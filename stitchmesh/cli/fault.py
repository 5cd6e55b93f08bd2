# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The last handler of exceptions: it reports an unexpected exception as a fault of the program, in one line."""

from __future__ import annotations

import os
import tempfile
import traceback

from stitchmesh import __version__
from stitchmesh.errors import StitchMeshError

FAULT = 70
"""Exit status after a fault of the program, ``EX_SOFTWARE`` of ``sysexits.h``."""


class ProgramFault(StitchMeshError):
    """The program itself is at fault, not its input."""


def fault_of(error: Exception) -> ProgramFault:
    """Return the line about an exception; its traceback is written to a new file, which only the user can read."""
    found = f"{type(error).__name__}: {error}"
    lines = [f"stitchmesh {__version__}\n", *traceback.format_exception(error)]
    try:
        number, path = tempfile.mkstemp(prefix="stitchmesh-fault-", suffix=".txt")
        with os.fdopen(number, "w", encoding="utf-8", errors="backslashreplace") as file:
            file.writelines(lines)
    except OSError as refused:
        told = f"its traceback cannot be written ({refused.strerror}); set TMPDIR to a folder that you may write"
    else:
        told = f"{path} holds the traceback; please report it, with the command"
    return ProgramFault(f"this is a fault of the program, not of its input ({found}); {told}")
