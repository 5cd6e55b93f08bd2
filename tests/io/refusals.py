# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Files that a reader must refuse."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from stitchmesh.errors import FileError, MeshError


@contextmanager
def refused(path: Path, words: str = "") -> Iterator[None]:
    """Check that a file is refused in one line, which begins with its path and holds some words."""
    with pytest.raises((FileError, MeshError)) as caught:
        yield
    said = str(caught.value)
    assert said.startswith(f"{path}: ")
    assert words in said
    assert "\n" not in said
