# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Files for content that has no place of its own on disk, such as an upload: readers and writers need a path."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from stitchmesh.errors import FileError, StitchMeshError


@contextmanager
def temporary_file(name: str, content: bytes | None = None) -> Iterator[Path]:
    """Provide the path of a file in a temporary folder, which is removed after the block.

    An error that the block raises names the file without the folder, of which the user knows nothing.

    Args:
        name: name of the file; folders in it are left out, as those of Windows too.
        content: what the file holds; there is no file yet if it is None.

    Raises:
        FileError: no file can have the name.
    """
    with tempfile.TemporaryDirectory(prefix="stitchmesh-") as folder:
        path = Path(folder) / Path(name.replace("\\", "/")).name
        try:
            if content is not None:
                _write(path, name, content)
            yield path
        except StitchMeshError as error:
            error.args = (str(error).replace(f"{folder}{os.sep}", ""),)
            raise


def _write(path: Path, name: str, content: bytes) -> None:
    try:
        path.write_bytes(content)
    except (OSError, ValueError) as error:
        raise FileError(f"{name[:40]!r}: cannot be opened ({error.__class__.__name__}); rename it") from error
