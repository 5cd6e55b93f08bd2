# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Files that describe a yarn: ``yarn.toml`` with the keys of ``YarnDescription``, and a CSV file with its curve."""

from __future__ import annotations

import csv
from dataclasses import replace
from io import StringIO
from os import fspath
from pathlib import Path

from stitchmesh.errors import FileError
from stitchmesh.io.atomic import write_text
from stitchmesh.io.contents import FilePath, read_bytes
from stitchmesh.io.toml_file import SUFFIX, changed_fields, read_dataclass, table_lines
from stitchmesh.yarn.yarn_description import YarnDescription
from stitchmesh.yarn.yarn_presets import Yarn


def yarn_of(name: str) -> Yarn:
    """Return a yarn by its name, or by the path of its description.

    Raises:
        ParameterError: there is no yarn of that name, or a value of the description is wrong.
        FileError: the file cannot be read.
    """
    return read_yarn(name) if name.lower().endswith(SUFFIX) else Yarn.named(name)


def read_yarn(path: FilePath) -> Yarn:
    """Read the description of a yarn; the name of the yarn is that of the file if it states none.

    Raises:
        FileError: a file cannot be read, or has an unknown key or a value of another kind.
        ParameterError: a value is malformed, is missing, or is given twice.
    """
    place, found = Path(path), read_dataclass(path, YarnDescription)
    if isinstance(found.load_extension, str):
        found = replace(found, load_extension=read_curve(place.parent / found.load_extension))
    return replace(found, name=found.name or place.stem).yarn()


def write_yarn(path: FilePath, yarn: YarnDescription) -> None:
    """Write the description of a yarn, for ``--yarn`` and ``read_yarn``.

    Args:
        path: a ``.toml`` file; missing folders are made.
        yarn: the description.

    Raises:
        FileError: the file cannot be written.
    """
    write_text(path, "".join(f"{line}\n" for line in table_lines(changed_fields(yarn))))


def read_curve(path: FilePath) -> tuple[tuple[float, float], ...]:
    """Read a curve of a laboratory: a CSV file with a head and two columns of numbers.

    Raises:
        FileError: the file cannot be read, or a line has no two numbers.
    """
    try:
        lines = list(csv.reader(StringIO(read_bytes(path).decode("utf-8", errors="replace"))))
    except csv.Error as error:
        raise FileError(f"{fspath(path)}: {error}; expected a head and two columns of numbers") from error
    pairs = []
    for number, line in enumerate(lines, start=1):
        if number == 1 or not line:
            continue
        try:
            pairs.append((float(line[0]), float(line[1])))
        except (ValueError, IndexError) as error:
            found = f"line {number}: got {','.join(line)[:40]!r}"
            raise FileError(f"{fspath(path)}: {found}; expected two numbers") from error
    return tuple(pairs)
