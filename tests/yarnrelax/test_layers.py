# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Imports inside the relaxer run in one direction: from the order of operations down to the model of yarns."""

from __future__ import annotations

import ast
from pathlib import Path

from tests.gallery import ROOT

PACKAGE = ROOT / "stitchmesh" / "yarnrelax"
LAYERS = [
    "model", "collision", "energies", "friction", "hessian",
    "constraints", "motion", "solvers", "", "together",
]  # fmt: skip
"""Folders from the lowest to the highest, with the root of the package as ``""``; each imports only those before it."""


def layer_of(path: Path) -> int:
    """The place of a file in ``LAYERS``."""
    return LAYERS.index(path.relative_to(PACKAGE).parts[0] if path.parent != PACKAGE else "")


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
    paths = sorted(PACKAGE.rglob("*.py"))
    modules = {".".join(path.relative_to(ROOT).with_suffix("").parts): path for path in paths}
    upward = [f"{path} imports {name}" for path in paths for name in imported(path)
              if name in modules and layer_of(modules[name]) > layer_of(path)]  # fmt: skip
    assert not upward


def test_no_two_files_of_the_root_import_each_other() -> None:
    """The files of the root have an order of reading only if their imports have no cycle."""
    modules = {f"stitchmesh.yarnrelax.{path.stem}": path for path in PACKAGE.glob("*.py") if path.stem != "__init__"}
    graph = {name: {other for other in imported(path) if other in modules} - {name} for name, path in modules.items()}
    while graph:
        free = [name for name, needs in graph.items() if not needs & set(graph)]
        assert free, f"import cycle among {sorted(graph)}"
        for name in free:
            del graph[name]
