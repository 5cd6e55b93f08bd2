# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Columns of Parquet files, read in a process of their own (``stitchmesh.io.guarded_child``).

A file of a few hundred bytes can state a thousand million rows of one value, which would fill the memory.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from stitchmesh.errors import FileError
from stitchmesh.io.checkpoint_file import CheckpointFile
from stitchmesh.io.contents import FilePath
from stitchmesh.io.guarded_child import answer_of_child, answer_parent

COLUMNS = "columns"
"""Name of the bytes of the columns in JSON."""


def read_columns(path: FilePath) -> dict[str, list[Any]]:
    """Return the values of each column: numbers, texts, true, false or None.

    Raises:
        FileError: the file cannot be read, is malformed, or holds other values, or the process that reads it ends.
    """
    return columns_of(answer_of_child(__name__, path))


def columns_of(packed: CheckpointFile) -> dict[str, list[Any]]:
    """Return what ``read_columns`` returns, from what ``packed_columns`` returns."""
    found: dict[str, list[Any]] = json.loads(packed.arrays[COLUMNS].tobytes())
    return found


def packed_columns(name: str, file: Path) -> CheckpointFile:
    """Read the columns for the parent of this process.

    Args:
        name: the name of the file, for messages.
        file: where its content lies.

    Raises:
        FileError: as for ``read_columns``.
    """
    import pyarrow
    from pyarrow import parquet

    try:
        columns = json.dumps(parquet.read_table(file, use_threads=False).to_pydict())
    except (pyarrow.ArrowException, OSError, ValueError, TypeError, OverflowError) as error:
        raise FileError(f"{name}: is not the table of a sweep ({error}); run the sweep again") from error
    return CheckpointFile({}, {COLUMNS: np.frombuffer(columns.encode(), np.uint8)})


if __name__ == "__main__":
    answer_parent(packed_columns, "pyarrow.parquet")
