# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Imports inside the mixed system run in one direction: from the driver down to what all terms have in common."""

from __future__ import annotations

import re
from pathlib import Path

from tests.gallery import ROOT

PACKAGE = ROOT / "stitchmesh" / "mixed"
LAYERS = [
    {"mixed_vector", "gather"},
    {"term"},
    {"cloth"},
    {"layout"},
    {"triangles", "crossings", "splines"},
    {"contact"},
    {"enrichment"},
    {"dynamics"},
    {"assembly", "memory"},
    {"output", "placement", "matching"},
    {"scene"},
    {"region_change"},
    {"simulation"},
    {"run_checkpoint", "automatic_region", "adaptive_region"},
    {"drape"},
    {"draped_folder"},
]
"""Folders and files from the bottom up; members of one layer do not import one another."""
LEVEL = {name: level for level, names in enumerate(LAYERS) for name in names}


def files() -> list[Path]:
    return [path for path in sorted(PACKAGE.rglob("*.py")) if path.parent != PACKAGE or path.stem != "__init__"]


def imported(path: Path) -> set[str]:
    """Members of the package that a file imports, including imports that only type annotations need."""
    found = re.findall(r"^ *(?:from|import) stitchmesh\.mixed(?:\.| import )(\w+)", path.read_text(), re.MULTILINE)
    return set(found)


def test_imports_run_down_only() -> None:
    upward = []
    for path in files():
        own = path.relative_to(PACKAGE).parts[0].removesuffix(".py")
        others = imported(path) - {own}
        upward += [f"{path} imports {other}" for other in others if LEVEL[other] >= LEVEL[own]]
    assert not upward
