# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Reads the output folder of a run as a result, also while the run goes on."""

from __future__ import annotations

from dataclasses import replace
from os import PathLike, fspath
from pathlib import Path
from typing import Any

from stitchmesh.errors import FileError, ParameterError
from stitchmesh.io.checked import check_value, read_json
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.drape import REPORT, SCENE_FILE, Draped
from stitchmesh.mixed.output.display import Displays
from stitchmesh.mixed.output.frames import DrapeFrame, Frames
from stitchmesh.mixed.scene.region_section import RegionSection
from stitchmesh.mixed.scene.scene import read_scene
from stitchmesh.mixed.scene.scene_fabric import prepare


def read_draped(folder: str | PathLike[str]) -> Draped:
    """Read a run from its output folder: the frames that are there, and the report if the run has ended.

    Raises:
        FileError: a file is missing or damaged, or there is no frame yet.
        ParameterError: the scene is not possible, for example because a file that it names has changed.
    """
    place = Path(folder)
    scene = read_scene(place / SCENE_FILE)
    frames = _frames(place)
    # The frames hold the positions: the cloth need not be put round its bodies, and the device of the run is not
    # needed.
    contact = replace(scene.contact, start_outside=False)
    laid = prepare(replace(scene, region=RegionSection(), contact=contact), folder=place)
    cloth, yarns = laid.fabric.cloth, laid.fabric.yarns
    _check_frame(frames[0], cloth, place)
    displays = Displays(cloth, yarns, laid.region, scene.output.subdivisions)
    return read_again(Draped(prepared=replace(laid, scene=scene), displays=displays, frames=frames, report={}), place)


def read_again(draped: Draped, folder: Path) -> Draped:
    """Return a run with the frames and the report that its folder holds now; the scene must be the same.

    Raises:
        FileError: there is no frame yet.
    """
    frames = _frames(folder)
    prepared = replace(draped.prepared, region=draped.displays.of(frames[-1]).region)
    return replace(draped, prepared=prepared, frames=frames, report=_report(folder))


def _frames(folder: Path) -> Frames:
    frames = Frames.of_folder(folder)
    if not len(frames):
        raise FileError(f"{fspath(folder)}: holds no frame of a run yet; wait until stitchmesh drape has written one")
    return frames


def _check_frame(frame: DrapeFrame, cloth: Cloth, folder: Path) -> None:
    """Check that the frames belong to the cloth."""
    found, expected = (len(frame.triangle_kind), len(frame.vertices)), (len(cloth.triangles), len(cloth.vertices))
    if found != expected:
        raise FileError(
            f"{fspath(folder)}: holds frames of {found[0]} triangles and {found[1]} vertices; expected "
            f"{expected[0]} and {expected[1]}, as in the scene beside them"
        )


def _report(folder: Path) -> dict[str, Any]:
    """The report of a run that has ended; empty while it goes on."""
    path, began = folder / REPORT, (folder / SCENE_FILE).stat().st_mtime_ns
    if not path.is_file() or path.stat().st_mtime_ns < began:
        return {}  # there is none yet, or an earlier run has left it
    try:
        return check_value(read_json(path), dict[str, Any])
    except ParameterError as error:
        raise FileError(f"{fspath(path)}: is no report ({error})") from error
