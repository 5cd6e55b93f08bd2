# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Imports inside the relaxer run in one direction: from the order of operations down to the linking of yarns."""

from __future__ import annotations

import ast
from pathlib import Path

from tests.gallery import ROOT

PACKAGE = ROOT / "stitchmesh" / "yarnrelax"
FOLDERS = ["linking", "model", "collision", "energies", "friction", "hessian", "constraints", "motion", "solvers"]
"""Folders from the lowest layer to the highest. A folder imports only those before it; files at the root import all."""
ABOVE = "together"
"""The folder whose files import those at the root, which import nothing of it."""
MOST_FILES = 22
"""Largest number of files in a folder, without its ``__init__``."""


def files() -> list[Path]:
    return sorted(PACKAGE.rglob("*.py"))


def folder_of(module: str) -> str | None:
    """The folder of a module of the relaxer; None for a file at its root."""
    parts = module.split(".")
    return parts[2] if len(parts) > 2 and parts[2] in FOLDERS else None


def imported(path: Path) -> list[str]:
    """Modules of the relaxer that a file imports, including imports that only type annotations need."""
    names = []
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module:
            names += [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
    return [name for name in names if name.startswith("stitchmesh.yarnrelax.")]


def test_folders_import_only_those_below_them() -> None:
    upward = []
    for path in (path for folder in FOLDERS for path in sorted((PACKAGE / folder).rglob("*.py"))):
        own = path.relative_to(PACKAGE).parts[0]
        below = FOLDERS[: FOLDERS.index(own) + 1]
        upward += [f"{path} imports {name}" for name in imported(path) if folder_of(name) not in below]
    assert not upward


def test_every_folder_is_listed_and_small() -> None:
    folders = sorted(path for path in PACKAGE.iterdir() if path.is_dir() and list(path.glob("*.py")))
    assert [path.name for path in folders] == sorted([*FOLDERS, ABOVE])
    for folder in folders:
        assert len(list(folder.glob("*.py"))) - 1 <= MOST_FILES, folder.name


def test_the_root_imports_nothing_of_the_folder_above_it() -> None:
    found = [f"{path} imports {name}" for path in PACKAGE.glob("*.py") for name in imported(path)]
    assert not [text for text in found if f"stitchmesh.yarnrelax.{ABOVE}" in text]


def test_no_two_files_of_the_root_import_each_other() -> None:
    """The files of the root have an order of reading only if their imports have no cycle."""
    modules = {f"stitchmesh.yarnrelax.{path.stem}": path for path in PACKAGE.glob("*.py") if path.stem != "__init__"}
    graph = {name: {other for other in imported(path) if other in modules} - {name} for name, path in modules.items()}
    while graph:
        free = [name for name, needs in graph.items() if not needs & set(graph)]
        assert free, f"import cycle among {sorted(graph)}"
        for name in free:
            del graph[name]
