# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Starts another interpreter of Python, which finds the same packages and runs no code of the present folder.

Users run the program in folders with other people's data. Python would look for modules there first: ``python -m`` and
``python -c`` put the present folder in front of the path, and so does an empty entry of ``PYTHONPATH``.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

PACKAGES = str(Path(__file__).resolve().parents[1])
"""The folder in which this package lies."""
SAFE_PATH = "PYTHONSAFEPATH"
"""The variable that does the same as the option ``-P``; interpreters that a library starts obey it too."""
SEARCH_PATH = "PYTHONPATH"


def python_command(*words: str) -> list[str]:
    """Return the command of a child interpreter, for words such as ``"-m", "package.module"`` or ``"-c", code``.

    The process also needs the environment ``clean_environment``.
    """
    return [sys.executable, "-P", *words]


def clean_environment() -> dict[str, str]:
    """Return the environment of this process, with the search path of modules of a child interpreter.

    The child searches where this process does, in the same order, except in the present folder.
    """
    return {**os.environ, SAFE_PATH: "1", SEARCH_PATH: os.pathsep.join(search_path())}


@contextmanager
def clean_children() -> Iterator[None]:
    """Give ``clean_environment`` to interpreters that libraries, such as ``multiprocessing``, start in the block."""
    before = os.environ.copy()
    os.environ.update(clean_environment())
    try:
        yield
    finally:
        for name in (SAFE_PATH, SEARCH_PATH):
            if name in before:
                os.environ[name] = before[name]
            else:
                del os.environ[name]


def search_path() -> list[str]:
    """Return the folders and archives in which this process looks for modules, without the present folder.

    The folder of this package stays at its place, even if it is the present one, because its code runs already.
    """
    present = os.path.realpath(os.curdir)
    places = [PACKAGES if os.path.realpath(entry) == PACKAGES else entry for entry in sys.path]
    kept = [place for place in places if place == PACKAGES or os.path.realpath(place) != present]
    # A relative entry names another place in another folder, and `PYTHONPATH` would cut an entry at a separator.
    return [place for place in dict.fromkeys([*kept, PACKAGES]) if os.path.isabs(place) and os.pathsep not in place]
