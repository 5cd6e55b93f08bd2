# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Values of stages as files in the folder of a stage, with all their bits."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Generic, TypeVar

from stitchmesh.errors import FileError
from stitchmesh.io.atomic import write_bytes, write_json
from stitchmesh.io.checked import check_table, read_json
from stitchmesh.io.contents import read_bytes
from stitchmesh.io.hdf5 import read_dataclass, write_dataclass
from stitchmesh.io.history import read_history, write_history
from stitchmesh.io.stitches import read_stitches, write_stitches
from stitchmesh.io.yarns import read_yarns, write_yarns
from stitchmesh.mesh import StitchMesh
from stitchmesh.periodic.swatch import Swatch
from stitchmesh.quality import Quality
from stitchmesh.shaping.found_stitches import FoundStitches
from stitchmesh.shaping.triangle_surface import TriangleSurface
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.relaxation_result import Relaxation

STITCHES, YARNS, HISTORY = "stitches.h5", "yarns.h5", "convergence.csv"
GIVEN, SURFACE, SURFACE_FORMAT = "given.h5", "surface.h5", "stitchmesh surface"
"""Files of the given surface and of the surface without fine features, on which stitches were found, and their
format."""
PLAN = "plan.json"
"""File of the quality that a budget has chosen."""
PICTURE = "picture.png"
"""File of a picture."""
T = TypeVar("T")


def write_value(folder: Path, kind: type[T], value: T) -> None:
    """Write a value of a kind into the folder of its stage.

    Raises:
        FileError: a file cannot be written.
    """
    FILES[kind].write(folder, value)


def read_value(folder: Path, kind: type[T], report: dict[str, Any]) -> T:
    """Read a value of a kind from the folder of its stage, given the report of the stage.

    Raises:
        FileError: a file is missing or damaged, or the report belongs to another stage.
    """
    value: T = FILES[kind].read(folder, report)
    return value


@dataclass(frozen=True)
class _Files(Generic[T]):
    """How the values of a kind are written and read."""

    write: Callable[[Path, T], None]
    read: Callable[[Path, dict[str, Any]], T]


def _write_found(folder: Path, found: FoundStitches) -> None:
    write_stitches(folder / STITCHES, found.fabric)
    write_dataclass(folder / GIVEN, found.given, SURFACE_FORMAT)
    if found.surface is not None:
        write_dataclass(folder / SURFACE, found.surface, SURFACE_FORMAT)


def _read_found(folder: Path, report: dict[str, Any]) -> FoundStitches:
    _entry(report, "shape")
    given = read_dataclass(folder / GIVEN, TriangleSurface, SURFACE_FORMAT)
    own = "panels" in report["shape"]
    surface = None if own else read_dataclass(folder / SURFACE, TriangleSurface, SURFACE_FORMAT)
    return FoundStitches(read_stitches(folder / STITCHES), given, surface)


def _write_relaxation(folder: Path, relaxed: Relaxation | Swatch) -> None:
    write_yarns(folder / YARNS, relaxed.yarns)
    write_history(folder / HISTORY, relaxed.history)


def _read_relaxation(folder: Path, report: dict[str, Any]) -> Relaxation:
    return Relaxation(read_yarns(folder / YARNS), _entry(report, "yarnrelax"), read_history(folder / HISTORY))


def _write_swatch(folder: Path, swatch: Swatch) -> None:
    _write_relaxation(folder, swatch)
    if swatch.fabric is not None:
        write_stitches(folder / STITCHES, swatch.fabric)


def _read_swatch(folder: Path, report: dict[str, Any]) -> Swatch:
    fabric = read_stitches(folder / STITCHES) if (folder / STITCHES).is_file() else None
    return Swatch(read_yarns(folder / YARNS), _entry(report, "swatch"), fabric, read_history(folder / HISTORY))


def _entry(report: dict[str, Any], name: str) -> dict[str, Any]:
    """Return an entry of the report of a stage.

    Raises:
        FileError: the report has no such entry, because it belongs to another stage.
    """
    if not isinstance(report.get(name), dict):
        raise FileError(f"report of a stage: has no entry {name!r}; the stage is computed again")
    return dict(report[name])


FILES: dict[type, _Files[Any]] = {
    FoundStitches: _Files(_write_found, _read_found),
    StitchMesh: _Files(
        lambda folder, fabric: write_stitches(folder / STITCHES, fabric),
        lambda folder, report: read_stitches(folder / STITCHES),
    ),
    Quality: _Files(
        lambda folder, quality: write_json(folder / PLAN, asdict(quality)),
        lambda folder, report: check_table(read_json(folder / PLAN), Quality),
    ),
    YarnSet: _Files(
        lambda folder, yarns: write_yarns(folder / YARNS, yarns),
        lambda folder, report: read_yarns(folder / YARNS),
    ),
    Relaxation: _Files(_write_relaxation, _read_relaxation),
    Swatch: _Files(_write_swatch, _read_swatch),
    bytes: _Files(
        lambda folder, picture: write_bytes(folder / PICTURE, picture),
        lambda folder, report: read_bytes(folder / PICTURE),
    ),
}
"""The files of each kind of value; the report of a stage holds the reports of relaxations and swatches."""
