# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Imports run down only, stages never import one another, and heavy packages stay where they belong."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

from tests.gallery import ROOT

PACKAGE = ROOT / "stitchmesh"
LAYERS = [
    {"errors"},
    {"lattice", "stitch", "connectivity", "numbering"},
    {"mesh"},
    {"courses"},
    {"mean_value", "standing_rows", "cables", "patch", "yarn", "quality", "compute", "tube", "dyes"},
    {"curves", "draft", "rest_length", "yarn_radius", "tiling", "instructions", "description"},
    {"knitting_machine"},
    {"io"},
    {"patterns"},
    {"labeling", "tessellate", "editing", "meshrelax", "yarngen", "yarnrelax"},
    {"periodic"},
    {"pipeline"},
    {"viewer", "progress"},
    {"output_folder"},
    {"stretch_command", "swatch_command"},
    {"commands"},
    {"cli"},
    {"__main__"},
]
"""From the bottom up; members of one layer do not import one another."""
LEVEL = {name: level for level, names in enumerate(LAYERS) for name in names}
HEAVY = {
    "warp": {"meshrelax", "yarnrelax", "compute"},
    "pyvista": {"viewer", "io"},
    "vtkmodules": {"viewer", "io"},
    "vtk": {"viewer"},
    "h5py": {"io"},
    "meshio": {"io"},
    "rich": {"progress"},
    "PIL": {"viewer", "patterns", "periodic"},
    "pxr": {"io"},
    "trimesh": {"io"},
    "matplotlib": {"viewer"},
}
"""Where each heavy package may be imported."""
VAGUE = {"utils", "util", "helpers", "common", "core", "misc", "tools", "types"}


def modules() -> list[Path]:
    return sorted(PACKAGE.rglob("*.py"))


def part_of(path: Path) -> str:
    first = path.relative_to(PACKAGE).parts[0]
    return first.removesuffix(".py")


def imported(path: Path) -> list[str]:
    names = []
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module:
            names += [node.module] if node.module != "stitchmesh" else [f"stitchmesh.{a.name}" for a in node.names]
    return names


@pytest.mark.parametrize("path", modules(), ids=lambda path: str(path.relative_to(PACKAGE)))
def test_imports_run_down_only(path):
    own = part_of(path)
    if own == "__init__":
        return  # the front door names everything
    for name in imported(path):
        if not name.startswith("stitchmesh."):
            continue
        other = name.split(".")[1]
        if other == "__version__" or other == own:
            continue
        assert LEVEL[other] < LEVEL[own], f"{own} imports {other}"


@pytest.mark.parametrize("path", modules(), ids=lambda path: str(path.relative_to(PACKAGE)))
def test_heavy_packages_stay_in_their_place(path):
    for name in imported(path):
        root = name.split(".")[0]
        assert root not in HEAVY or part_of(path) in HEAVY[root], f"{part_of(path)} imports {root}"


@pytest.mark.parametrize("path", modules(), ids=lambda path: str(path.relative_to(PACKAGE)))
def test_kernels_are_declared_by_the_one_decorator(path):
    # a kernel that is declared otherwise compiles its derivative too, for far longer
    names = {ast.unparse(node) for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.Attribute)}
    assert path.stem == "kernel" or "wp.kernel" not in names


def test_every_module_has_its_layer_and_a_telling_name():
    names = {part_of(path) for path in modules()} - {"__init__"}
    assert names == set(LEVEL)
    stems = {path.stem for path in modules()} | {path.name for path in PACKAGE.iterdir() if path.is_dir()}
    assert not stems & VAGUE


def loaded_after(statement: str) -> set[str]:
    code = f"import sys; {statement}; print(' '.join(sorted(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT)
    return {name.split(".")[0] for name in done.stdout.split()}


def test_importing_the_package_loads_nothing_heavy():
    assert not loaded_after("import stitchmesh") & set(HEAVY)


def test_the_parser_loads_nothing_heavy():
    found = loaded_after("import stitchmesh.cli; stitchmesh.cli.parser()")
    assert not found & set(HEAVY)


def test_all_public_names_exist():
    import stitchmesh

    for name in stitchmesh.__all__:
        assert getattr(stitchmesh, name) is not None
    assert callable(stitchmesh.tessellate)
    with pytest.raises(AttributeError, match="no attribute 'knitting'"):
        stitchmesh.knitting  # noqa: B018
