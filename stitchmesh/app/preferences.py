# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What a user prefers in all projects: dark or light colours."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path

from stitchmesh.errors import StitchMeshError
from stitchmesh.io.atomic import write_json
from stitchmesh.io.checked import check_value, read_json


def state_folder() -> Path:
    """Return the folder in which the program remembers something between its starts."""
    state = os.environ.get("XDG_STATE_HOME") or Path.home() / ".local" / "state"
    return Path(state) / "stitchmesh"


def prefers_dark() -> bool:
    """Return whether the user has chosen dark colours; a damaged file counts as light ones."""
    try:
        return check_value(read_json(_path()), dict[str, bool]).get("dark", False)
    except StitchMeshError:
        return False


def keep_dark(dark: bool) -> None:
    """Remember the choice; a folder that cannot be written keeps the one before."""
    with contextlib.suppress(StitchMeshError):
        write_json(_path(), {"dark": dark})


def _path() -> Path:
    return state_folder() / "preferences.json"
