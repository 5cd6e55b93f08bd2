# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The output folder of a run as a result, also while the run goes on."""

from __future__ import annotations

from dataclasses import replace
from os import PathLike, fspath
from pathlib import Path
from typing import Any

from stitchmesh.errors import FileError, ParameterError
from stitchmesh.io.checked import check_value, parse_json
from stitchmesh.io.contents import read_bytes
from stitchmesh.mixed.drape import REPORT, SCENE_FILE, Draped
from stitchmesh.mixed.output.displays import Displays
from stitchmesh.mixed.output.frames import Frames
from stitchmesh.mixed.output.region_file import NAME as REGION
from stitchmesh.mixed.output.region_file import read_region
from stitchmesh.mixed.scene.region_section import RegionSection
from stitchmesh.mixed.scene.scene_fabric import prepare
from stitchmesh.mixed.scene.scene_file import read_scene


def read_draped(folder: str | PathLike[str]) -> Draped:
    """Read a run from its output folder: the frames that are there, and the report if the run has ended.

    Raises:
        FileError: a file is missing or damaged, or there is no frame yet.
        ParameterError: the scene is not possible, for example because a file that it names has changed.
    """
    place = Path(folder)
    scene = read_scene(place / SCENE_FILE)
    laid = prepare(replace(scene, region=RegionSection()))
    fabric = laid.fabric
    region = read_region(place, fabric.cloth, fabric.yarns)
    prepared = replace(laid, scene=scene, region=region)
    displays = Displays(fabric.cloth, fabric.yarns, region, scene.output.subdivisions)
    return read_again(Draped(prepared=prepared, displays=displays, frames=Frames(), report={}), place)


def read_again(draped: Draped, folder: Path) -> Draped:
    """Return a run with the frames and the report that its folder holds now; the scene must be the same.

    Raises:
        FileError: there is no frame yet.
    """
    frames = Frames.of_folder(folder)
    if not len(frames):
        raise FileError(f"{fspath(folder)}: holds no frame of a run yet; wait until stitchmesh drape has written one")
    return replace(draped, frames=frames, report=_report(folder))


def _report(folder: Path) -> dict[str, Any]:
    """The report of a run that has ended, else an empty one."""
    path, began = folder / REPORT, (folder / REGION).stat().st_mtime_ns
    if not path.is_file() or path.stat().st_mtime_ns < began:
        return {}  # There is none yet, or an earlier run has left it.
    try:
        return check_value(parse_json(read_bytes(path).decode("utf-8")), dict[str, Any])
    except (ValueError, ParameterError) as error:
        raise FileError(f"{fspath(path)}: is no report ({error})") from error
