# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What nothing uses is not kept, and no two public classes have one name.

A definition at the level of a module is used if the command line, a public name, code that runs at import or the
promise of a page leads to it through names of production code. Tests and benchmarks use nothing.

A method is used if production code outside of it names it after a dot or as a text, whatever the class. The public
classes of the package are exempt, because the reference documents all of their methods.
"""

from __future__ import annotations

import ast
import re
from collections import Counter, defaultdict
from collections.abc import Iterator, Sequence
from functools import cache
from pathlib import Path

from tests.gallery import ROOT
from tests.source_files import statements_within, tree_of

PACKAGE = ROOT / "stitchmesh"
Definition = tuple[str, str]
"""A module and a name in it."""
ENTRY: Definition = ("stitchmesh.cli.main", "main")
NAMED_BY_TEXT = "stitchmesh.app.pages.all_pages"
"""The module that names the classes of pages by texts."""
PROMISED = {
    ("stitchmesh.app.front", "NullFront"): "CONTRIBUTING.md",
    ("stitchmesh.mixed.output.files", "read_maps"): "docs/robustness.md",
    ("stitchmesh.patterns.charts.colour_chart", "chart_palette"): "docs/patterns.md",
    ("stitchmesh.patterns.charts.colour_chart", "write_colour_chart"): "docs/patterns.md",
    ("stitchmesh.patterns.charts.leaf_chart", "write_leaf_chart"): "docs/patterns.md",
}
"""Definitions that no production code uses, each with the page that tells readers to use it."""
OBSERVED = {
    ("BodyContact", "distances"): "how far a cloth is from a body, which the solver keeps on the device",
    ("ClothMaterial", "isotropic"): "a cloth whose bending and stretch are known in closed form",
    ("EventQueue", "settle"): "waits until what the application was asked to do is done",
    ("NullControls", "send"): "a file that a user chooses, without a browser",
    ("NullControls", "text_shown"): "what a page shows, without a browser",
}
"""Methods that no production code uses, each with what tests and scripts observe by it."""
FOREIGN_CALLERS = {"ABC", "Enum", "Exception", "Generic", "IntEnum", "NamedTuple", "Protocol", "StrEnum", "TypedDict"}
"""Base classes from elsewhere that call no method which a class adds."""
SHARED_NAMES = {"Scene", "SolverSection", "Task"}
"""Names that two public classes still have; a name leaves this set when one of its classes gets a better one."""


def name_of(path: Path) -> str:
    return ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")


@cache
def sources() -> dict[str, list[Path]]:
    """The files of each module: its code, and the stub of a package whose names load when they are first used."""
    found: dict[str, list[Path]] = defaultdict(list)
    for path in sorted([*PACKAGE.rglob("*.py"), *PACKAGE.rglob("*.pyi")]):
        found[name_of(path)].append(path)
    return dict(found)


def statements(body: Sequence[ast.stmt]) -> Iterator[ast.stmt]:
    """Statements at the level of a module, also those under a condition."""
    for statement in body:
        if isinstance(statement, ast.If | ast.Try | ast.With):
            yield from statements(statement.body)
            yield from statements(getattr(statement, "orelse", []))
        else:
            yield statement


def names_defined_by(statement: ast.stmt) -> list[str]:
    if isinstance(statement, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
        return [statement.name]
    if isinstance(statement, ast.Assign):
        targets = statement.targets
    elif isinstance(statement, ast.AnnAssign):
        targets = [statement.target]
    else:
        return []
    if not all(isinstance(target, ast.Name | ast.Tuple) for target in targets):
        return []
    return [node.id for target in targets for node in ast.walk(target) if isinstance(node, ast.Name)]


class Module:
    """The definitions, the imports and the other statements of a module."""

    def __init__(self, name: str, paths: Sequence[Path]) -> None:
        self.name = name
        self.definitions: dict[str, list[ast.stmt]] = defaultdict(list)
        self.imports: dict[str, tuple[str, str | None]] = {}
        self.others: list[ast.stmt] = []
        for path in paths:
            tree = tree_of(path)
            package = name if path.stem == "__init__" else name.rpartition(".")[0]
            for statement in statements_within(tree.body):
                self._note_import(statement, package)
            for statement in statements(tree.body):
                self._note_definition(statement)

    def _note_import(self, node: ast.AST, package: str) -> None:
        if isinstance(node, ast.Import):
            for alias in node.names:
                whole = alias.name if alias.asname else alias.name.partition(".")[0]
                self.imports[alias.asname or whole] = (whole, None)
        elif isinstance(node, ast.ImportFrom):
            above = package.split(".")[: len(package.split(".")) + 1 - node.level] if node.level else []
            origin = ".".join([*above, *([node.module] if node.module else [])])
            for alias in node.names:
                self.imports[alias.asname or alias.name] = (origin, alias.name)

    def _note_definition(self, statement: ast.stmt) -> None:
        names = names_defined_by(statement)
        for name in names:
            self.definitions[name].append(statement)
        if not names and not isinstance(statement, ast.Import | ast.ImportFrom):
            self.others.append(statement)


@cache
def modules() -> dict[str, Module]:
    return {name: Module(name, paths) for name, paths in sources().items()}


@cache
def definition_of(module: str, name: str) -> Definition | None:
    """Where a name of a module is defined; None if it is a module, or comes from another package."""
    while module in modules():
        known = modules()[module]
        if name in known.definitions:
            return module, name
        origin, original = known.imports.get(name, ("", None))
        if original is None or (origin, original) == (module, name):
            return None
        module, name = origin, original
    return None


def module_of(module: str, node: ast.expr) -> str | None:
    """The module for which an expression stands, such as ``quality`` after ``from stitchmesh import quality``."""
    if isinstance(node, ast.Name):
        origin, original = modules()[module].imports.get(node.id, ("", None))
        found = origin if original is None else f"{origin}.{original}"
    elif isinstance(node, ast.Attribute):
        found = f"{module_of(module, node.value)}.{node.attr}"
    else:
        return None
    return found if found in modules() else None


def words_of(text: str) -> list[str]:
    """The names in a text that may be a type, such as ``Sequence[Mesh]``."""
    return re.findall(r"\w+", text) if re.fullmatch(r"[\w.\[\], |]{1,200}", text) else []


def used_by(module: str, node: ast.AST) -> Iterator[Definition | None]:
    """The definitions that a piece of code of a module names."""
    for part in ast.walk(node):
        if isinstance(part, ast.Name):
            yield definition_of(module, part.id)
        elif isinstance(part, ast.Attribute):
            yield definition_of(module_of(module, part.value) or "", part.attr)
        elif isinstance(part, ast.Constant) and isinstance(part.value, str):
            for word in words_of(part.value):
                yield definition_of(module, word)
                if module == NAMED_BY_TEXT:
                    yield from ((name, word) for name, other in modules().items() if word in other.definitions)


@cache
def uses_of(module: str, name: str) -> frozenset[Definition]:
    """The definitions that one definition names."""
    found = (one for statement in modules()[module].definitions[name] for one in used_by(module, statement))
    return frozenset(one for one in found if one)


@cache
def reached(further: frozenset[Definition]) -> frozenset[Definition]:
    """All definitions to which the entry, the public names, what runs at import and further definitions lead."""
    seen = {ENTRY, *further}
    for name in modules()["stitchmesh"].imports:
        public = modules().get(f"stitchmesh.{name}")
        seen |= {found for found in [definition_of("stitchmesh", name)] if found}
        seen |= {(public.name, own) for own in public.definitions} if public else set()
    for name, module in modules().items():
        for statement in module.others:
            seen |= {found for found in used_by(name, statement) if found}
    waiting = list(seen)
    while waiting:
        new = uses_of(*waiting.pop()) - seen
        seen |= new
        waiting += new
    return frozenset(seen)


@cache
def unused() -> frozenset[Definition]:
    defined = {(module.name, name) for module in modules().values() for name in module.definitions}
    return frozenset(one for one in defined - reached(frozenset(PROMISED)) if not one[1].startswith("__"))


def test_production_code_leads_to_every_definition():
    assert sorted(unused()) == []


def test_a_page_names_what_no_production_code_uses_and_only_that():
    for (module, name), page in PROMISED.items():
        assert name in modules()[module].definitions
        assert re.search(rf"\b{name}\b", (ROOT / page).read_text())
    assert reached(frozenset()).isdisjoint(PROMISED)


@cache
def trees() -> list[tuple[str, ast.Module]]:
    """The name and the code of each module."""
    return [(name_of(path), tree_of(path)) for path in sorted(PACKAGE.rglob("*.py"))]


@cache
def classes() -> list[tuple[str, ast.ClassDef]]:
    """All classes, each with the name of its module."""
    return [
        (name, node)
        for name, tree in trees()
        for node in statements_within(tree.body)
        if isinstance(node, ast.ClassDef)
    ]


def names_after_dots(node: ast.AST) -> Counter[str]:
    """How often code names something after a dot, or in a text that is no more than a name."""
    found: Counter[str] = Counter()
    for part in ast.walk(node):
        if isinstance(part, ast.Attribute):
            found[part.attr] += 1
        elif isinstance(part, ast.Constant) and isinstance(part.value, str) and part.value.isidentifier():
            found[part.value] += 1
    return found


def called_from_elsewhere(module: str, one: ast.ClassDef) -> bool:
    """Whether a base class of another package may call the methods of a class of a module."""
    bases = [ast.unparse(base).partition("[")[0] for base in one.bases]
    foreign = {base.rpartition(".")[2] for base in bases if definition_of(module, base.partition(".")[0]) is None}
    return bool(foreign - FOREIGN_CALLERS)


def unused_methods() -> set[tuple[str, str]]:
    everywhere: Counter[str] = Counter()
    for _name, tree in trees():
        everywhere.update(names_after_dots(tree))
    documented = set(modules()["stitchmesh"].imports)
    found = set()
    for module, one in classes():
        if one.name.startswith("_") or one.name in documented or called_from_elsewhere(module, one):
            continue
        for method in one.body:
            if isinstance(method, ast.FunctionDef) and not method.name.startswith("_"):
                if everywhere[method.name] == names_after_dots(method)[method.name]:
                    found.add((one.name, method.name))
    return found


def test_production_code_names_every_method():
    assert unused_methods() == set(OBSERVED)


def public_classes(path: Path) -> list[str]:
    classes = [node.name for node in tree_of(path).body if isinstance(node, ast.ClassDef)]
    return [name for name in classes if not name.startswith("_")]


def test_each_public_class_has_a_name_of_its_own():
    count = Counter(name for path in PACKAGE.rglob("*.py") for name in public_classes(path))
    assert {name for name, classes in count.items() if classes > 1} == SHARED_NAMES
