# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Writes the graphs of ``docs/architecture.md`` from the import statements of the package.

    python docs/site_build/architecture_graph.py

An arrow from A to B means that A imports B. An arrow is left out where a longer path leads from A to B too, because the
order of imports can be read without it (the transitive reduction of the graph). Imports for annotations alone, under
``if TYPE_CHECKING``, are not shown.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "architecture.md"
GRAPHS = ("stitchmesh", "stitchmesh.yarnrelax")
"""Packages with a graph of their direct members."""

Graph = dict[str, set[str]]


@cache
def import_graph(package: str) -> Graph:
    """For each file and folder directly in a package the other ones whose modules it imports.

    Raises:
        ValueError: the imports form a cycle.
    """
    folder = ROOT.joinpath(*package.split("."))
    sources = {name: _sources(folder, name) for name in _members(folder)}
    graph = {
        name: {other for path in paths for other in _imported_members(path, package) if other in sources} - {name}
        for name, paths in sources.items()
    }
    return reduced(graph)


def reduced(graph: Graph) -> Graph:
    """The transitive reduction of a graph without cycles: the fewest arrows with the same paths."""
    reach: Graph = {}

    def reachable(name: str, path: tuple[str, ...]) -> set[str]:
        if name in path:
            raise ValueError(f"imports form a cycle: {' -> '.join([*path[path.index(name) :], name])}")
        if name not in reach:
            reach[name] = set(graph[name]).union(*(reachable(other, (*path, name)) for other in graph[name]))
        return reach[name]

    for name in graph:
        reachable(name, ())
    return {name: {o for o in others if not any(o in reach[p] for p in others)} for name, others in graph.items()}


def mermaid(package: str) -> str:
    """A Mermaid flow chart of a package: folders end in a slash, files in ``.py``."""
    graph = import_graph(package)
    folder = ROOT.joinpath(*package.split("."))
    lines = ["flowchart TD"]
    lines += [
        f"    {name}[{name}/]" if (folder / name).is_dir() else f"    {name}[{name}.py]" for name in sorted(graph)
    ]
    lines += [f"    {name} --> {other}" for name in sorted(graph) for other in sorted(graph[name])]
    return "\n".join(lines)


def page_with_graphs(page: str) -> str:
    """The text of the page with every graph written anew between its two comments."""
    for package in GRAPHS:
        begin, end = f"<!-- graph of {package} -->\n", "<!-- end of graph -->"
        block = f"{begin}\n```mermaid\n{mermaid(package)}\n```\n\n{end}"
        page, count = re.subn(
            re.escape(begin) + ".*?" + re.escape(end), lambda _, text=block: text, page, flags=re.DOTALL
        )
        if count != 1:
            raise ValueError(f"{PAGE}: expected one comment 'graph of {package}' with its end, got {count}")
    return page


def _members(folder: Path) -> list[str]:
    files = [path.stem for path in folder.glob("*.py") if not path.stem.startswith("__")]
    return files + [path.name for path in folder.iterdir() if (path / "__init__.py").exists()]


def _sources(folder: Path, name: str) -> list[Path]:
    return [folder / f"{name}.py"] if (folder / f"{name}.py").exists() else sorted((folder / name).rglob("*.py"))


def _imported_members(path: Path, package: str) -> set[str]:
    """Direct members of a package that a file imports something from."""
    names = set()
    for node in _nodes_that_run(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            names |= {f"{node.module}.{alias.name}" for alias in node.names}
    prefix = f"{package}."
    return {name.removeprefix(prefix).split(".")[0] for name in names if name.startswith(prefix)}


def _nodes_that_run(node: ast.AST) -> Iterator[ast.AST]:
    for child in ast.iter_child_nodes(node):
        if not (isinstance(child, ast.If) and ast.unparse(child.test) == "TYPE_CHECKING"):
            yield child
            yield from _nodes_that_run(child)


if __name__ == "__main__":
    PAGE.write_text(page_with_graphs(PAGE.read_text()))
