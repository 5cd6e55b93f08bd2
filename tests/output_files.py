# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What a command has written for its user."""

from __future__ import annotations

from pathlib import Path


def visible(folder: Path) -> set[str]:
    """Return the names in a folder, without hidden ones such as the record of what the program wrote."""
    return {path.name for path in folder.iterdir() if not path.name.startswith(".")}
