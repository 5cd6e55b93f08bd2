# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""No file is read as a program: nothing of the package unpickles, evaluates or imports what a file holds.

Dask moves tasks between its own processes by pickle (docs/how-to/sweeps.md); no file is read that way.
"""

from __future__ import annotations

import ast
from pathlib import Path

from tests.gallery import ROOT

MODULES = {"pickle", "cPickle", "cloudpickle", "dill", "marshal", "shelve", "joblib"}
"""Modules that make objects, and so run code, from what they read."""
CALLS = {"eval", "exec", "compile", "__import__", "read_pickle", "to_pickle", "loads_pickle"}
"""Functions that do."""
WORDS = MODULES | CALLS | {"allow_pickle", "np.load", "numpy.load"}


def faults(path: Path) -> list[str]:
    """Return the places at which a file of Python can make objects from what it reads."""
    text = path.read_text(encoding="utf-8")
    if not any(word in text for word in WORDS):  # to parse all files takes seconds
        return []
    return [
        f"{path.name}:{node.lineno}"
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.Import | ast.ImportFrom | ast.Call) and unpickles(node)
    ]


def unpickles(node: ast.Import | ast.ImportFrom | ast.Call) -> bool:
    if isinstance(node, ast.Import):
        return any(name.name.split(".")[0] in MODULES for name in node.names)
    if isinstance(node, ast.ImportFrom):
        parts = (node.module or "").split(".")
        return not MODULES.isdisjoint(parts) or any(name.name in MODULES for name in node.names)
    name = node.func.id if isinstance(node.func, ast.Name) else getattr(node.func, "attr", "")
    of_numpy = isinstance(node.func, ast.Attribute) and ast.unparse(node.func) in ("np.load", "numpy.load")
    allows = any(word.arg == "allow_pickle" for word in node.keywords)
    return allows or of_numpy or (name in CALLS and ast.unparse(node.func) != "re.compile")


def test_no_reader_unpickles_or_evaluates():
    files = sorted((ROOT / "stitchmesh").rglob("*.py"))
    assert len(files) > 300
    assert [fault for path in files for fault in faults(path)] == []


def test_each_way_to_unpickle_is_found(tmp_path):
    lines = ["import pickle", "from pickle import loads", "from distributed.protocol import pickle", "np.load(path)",
             "h5py.File(path, allow_pickle=True)", "eval(text)", "pandas.read_pickle(path)"]  # fmt: skip
    (tmp_path / "reader.py").write_text("\n".join(["import re", "re.compile('x')", *lines]) + "\n")
    assert faults(tmp_path / "reader.py") == [f"reader.py:{number}" for number in range(3, 3 + len(lines))]
