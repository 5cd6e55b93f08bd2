# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Imports run down only, stages never import one another, and heavy packages stay where they belong."""

from __future__ import annotations

import ast
import importlib
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

from tests.gallery import ROOT
from tests.nightly import at_night
from tests.source_files import statements_within, tree_of

PACKAGE = ROOT / "stitchmesh"
LAYERS = [
    {"errors"},
    {"child_interpreter", "compute", "lattice", "markup", "progress", "quality", "reporting", "run_control",
     "settings"},
    {"first_use", "memory_need", "time_limit"},
    {"mesh"},
    {"yarn"},
    {"faces", "hand_knitting", "linking"},
    {"machine_knitting"},
    {"io"},
    {"run", "selection", "simulation"},
    {"patterns"},
    {"labeling", "tessellate", "editing", "meshrelax", "yarngen", "yarnrelax"},
    {"budget", "edits", "shaping"},
    {"periodic"},
    {"mixed"},
    {"pipeline"},
    {"recipe", "after_edit"},
    {"measuring"},
    {"render"},
    {"jobs"},
    {"app"},
    {"cli"},
    {"__main__"},
]
"""Folders and files of the package from the bottom up; members of one layer do not import one another."""
LEVEL = {name: level for level, names in enumerate(LAYERS) for name in names}
HEAVY = {
    "warp": {"compute", "linking", "meshrelax", "mixed", "simulation", "yarngen", "yarnrelax"},
    "pyvista": {"render", "io"},
    "vtkmodules": {"render", "io"},
    "vtk": {"render"},
    "h5py": {"io"},
    "meshio": {"io"},
    "rich": {"cli"},
    "tyro": {"cli"},
    "msgspec": {"app", "io"},
    "alembic3d": {"io"},
    "imageio_ffmpeg": {"render"},
    "PIL": {"app", "mesh", "render", "patterns", "periodic"},
    "pxr": {"io"},
    "trimesh": {"io"},
    "matplotlib": {"render"},
    "viser": {"app"},
    "plotly": {"app", "jobs"},
    "websockets": {"app"},
    "distributed": {"jobs"},
    "pyarrow": {"jobs"},
}
"""Where each heavy package may be imported."""
VAGUE = {"utils", "util", "helpers", "common", "core", "misc", "tools", "types"}


def modules() -> list[Path]:
    return sorted(PACKAGE.rglob("*.py"))


def part_of(path: Path) -> str:
    first = path.relative_to(PACKAGE).parts[0]
    return first.removesuffix(".py")


def declares_by_warp(path: Path) -> bool:
    """Whether a file names ``wp.kernel`` outside comments and texts."""
    text = path.read_text()
    nodes = ast.walk(ast.parse(text)) if "wp.kernel" in text else []
    return any(isinstance(node, ast.Attribute) and ast.unparse(node) == "wp.kernel" for node in nodes)


@cache
def imported(path: Path) -> list[str]:
    names = []
    for node in statements_within(tree_of(path).body):
        if isinstance(node, ast.Import):
            names += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module:
            names += [node.module] if node.module != "stitchmesh" else [f"stitchmesh.{a.name}" for a in node.names]
    return names


def test_imports_run_down_only():
    upward = []
    for path in modules():
        own = part_of(path)
        names = {name.split(".")[1] for name in imported(path) if name.startswith("stitchmesh.")}
        others = names - {"__version__", own}
        if own != "__init__":  # the front door names everything
            upward += [f"{path} imports {other}" for other in others if LEVEL[other] >= LEVEL[own]]
    assert not upward


def test_heavy_packages_stay_in_their_place():
    misplaced = []
    for path in modules():
        heavy = {name.split(".")[0] for name in imported(path)} & set(HEAVY)
        misplaced += [f"{path} imports {root}" for root in heavy if part_of(path) not in HEAVY[root]]
    assert not misplaced


def test_kernels_are_declared_by_the_one_decorator():
    # a kernel that is declared otherwise compiles its derivative too, for far longer
    assert [path for path in modules() if declares_by_warp(path)] == [PACKAGE / "compute" / "kernel.py"]


def test_every_module_has_its_layer_and_a_telling_name():
    names = {part_of(path) for path in modules()} - {"__init__"}
    assert names == set(LEVEL)
    stems = {path.stem for path in modules()} | {path.name for path in PACKAGE.iterdir() if path.is_dir()}
    assert not stems & VAGUE


def modules_after(statement: str) -> set[str]:
    code = f"import sys\n{statement}\nprint()\nprint(' '.join(sorted(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT)
    return set(done.stdout.splitlines()[-1].split())


def loaded_after(statement: str) -> set[str]:
    return {name.split(".")[0] for name in modules_after(statement)}


def test_importing_the_package_loads_nothing_heavy():
    assert not loaded_after("import stitchmesh") & set(HEAVY)


@pytest.mark.parametrize(
    "words", [["swatch", "--help"], ["knit", "mesh.obj"], *at_night(["--help"])]
)
def test_help_and_refused_words_load_nothing_heavy(words):
    """The words are read by the options alone; a command that runs loads what it needs."""
    found = loaded_after(f"from stitchmesh.cli.main import main\ntry:\n  main({words!r})\nexcept SystemExit:\n  pass")
    assert not found & (set(HEAVY) - {"tyro"} | {"scipy"})


def test_the_application_starts_without_the_simulations(tmp_path):
    """A start takes a mesh, whose rows are labeled; each page imports what it simulates when it is opened."""
    statement = (
        "from stitchmesh.app.project.opening import project_for\nimport stitchmesh.app.run, tests.app.null_front\n"
        f"project = project_for('assets/meshes/sweater.obj', {str(tmp_path / 'garment')!r})\n"
        "app = stitchmesh.app.run.App(project, tests.app.null_front.NullFront())\n"
        "app.open_page(app.last_page())\napp.open_page('Label')\nassert app.page.unavailable() is None\napp.close()"
    )
    simulating = {f"stitchmesh.{name}" for name in ("mixed", "periodic", "yarnrelax")}
    assert not modules_after(statement) & (simulating | {"warp", "vtk", "pyvista"})


def test_all_public_names_exist():
    import stitchmesh

    for name in stitchmesh.__all__:
        assert getattr(stitchmesh, name) is not None
    with pytest.raises(AttributeError, match="attribute knitting"):
        stitchmesh.knitting  # noqa: B018


def test_tessellate_is_the_function_whatever_is_imported_first():
    """The function has the name of its package, and an import of a package binds its name in the parent package."""
    code = "import stitchmesh, stitchmesh.tessellate.panel; from stitchmesh import tessellate"
    checks = "assert stitchmesh.tessellate is tessellate and tessellate.__code__"
    subprocess.run([sys.executable, "-c", f"{code}; {checks}"], check=True, cwd=ROOT)


@pytest.mark.parametrize("package", [path.parent for path in modules() if "__getattr__" in path.read_text()])
def test_names_that_load_when_first_used_exist_and_share_no_name_with_a_module(package):
    """An import of a module would bind its name in the package, in the place of a function of the same name."""
    name = ".".join(package.relative_to(ROOT).parts)
    loaded = importlib.import_module(name)
    below = {path.stem for path in package.glob("*.py")} | {path.name for path in package.iterdir() if path.is_dir()}
    assert set(loaded.__all__) & below == ({"edits", "render", "tessellate"} if name == "stitchmesh" else set())
    for public in loaded.__all__:
        assert getattr(loaded, public) is not None
