# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The user's preference for all projects: dark or light colours."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path

from stitchmesh.errors import StitchMeshError
from stitchmesh.io.atomic import write_json
from stitchmesh.io.checked import check_value, read_json


def state_folder() -> Path:
    """Return the folder that keeps data between the starts of the program."""
    state = os.environ.get("XDG_STATE_HOME") or Path.home() / ".local" / "state"
    return Path(state) / "stitchmesh"


def prefers_dark() -> bool:
    """Return whether the user has chosen dark colours; a damaged file means light ones."""
    try:
        return check_value(read_json(_path()), dict[str, bool]).get("dark", False)
    except StitchMeshError:
        return False


def keep_dark(dark: bool) -> None:
    """Keep the choice; if the folder cannot be written, the earlier choice stays."""
    with contextlib.suppress(StitchMeshError):
        write_json(_path(), {"dark": dark})


def _path() -> Path:
    return state_folder() / "preferences.json"
