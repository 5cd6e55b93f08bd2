# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The runner of all measures.

    python benchmarks/run.py --list
    python benchmarks/run.py NAME --help
    python benchmarks/run.py NAME [OPTION ...]

A measure is a file of ``benchmarks/measures`` or ``benchmarks/published``, and its name is that of the file. Its
function, which has the same name, yields the rows of a table; the parameters of the function are the options. A measure
with several actions lists their functions in ``ACTIONS``, and the first word after the name says which of them runs.
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator, Sequence
from importlib import import_module
from inspect import isgeneratorfunction
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
if str(ROOT) not in sys.path:
    sys.path.insert(0, str(ROOT))  # Measures import each other, and helpers of the tests.

from benchmarks.options import begun  # noqa: E402
from benchmarks.table import Rows, show  # noqa: E402

FOLDERS = (*sorted((ROOT / "benchmarks" / "measures").glob("*/")), ROOT / "benchmarks" / "published")
"""The folders of the measures, by topic."""


def main(words: Sequence[str]) -> int:
    """Run the measure that the words name, and return the exit status."""
    if not words or words[0] in ("--list", "--help", "-h"):
        for path in paths():
            print(f"{name_of(path):<22}{path.parent.name:<12}{summary(path)}")
        return 0
    return show(named(words))


def named(words: Sequence[str]) -> Rows:
    """Return the measure of a command line, which has not begun.

    Raises:
        SystemExit: there is no such measure, or the words after its name are not its options.
    """
    path = next((each for each in paths() if name_of(each) == words[0]), None)
    if path is None:
        raise SystemExit(f"got {words[0]!r}; expected a measure that `python benchmarks/run.py --list` names")
    module = import_module(".".join(path.relative_to(ROOT).with_suffix("").parts))
    actions = getattr(module, "ACTIONS", None) or (getattr(module, path.stem),)
    assert all(map(isgeneratorfunction, actions)), path  # another function would run while its options are read
    return begun(actions, f"benchmarks/run.py {words[0]}", words[1:], module.__doc__ or "")


def paths() -> Iterator[Path]:
    """Yield the files of all measures, topic by topic; a file without a measure has functions that measures share."""
    for path in (each for folder in FOLDERS for each in sorted(folder.glob("*.py"))):
        text = path.read_text(encoding="utf-8")
        if f"\ndef {path.stem}(" in text or "\nACTIONS = " in text:
            yield path


def name_of(path: Path) -> str:
    """Return the name of a measure on the command line."""
    return path.stem.replace("_", "-")


def summary(path: Path) -> str:
    """Return the first line of the docstring of a file."""
    return (ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or "").partition("\n")[0]


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
