# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The readers of files, each with small undamaged files, the changes that suit its format, and the errors it raises."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import stitchmesh as sm
from stitchmesh.budget.budget import parse_error, parse_time
from stitchmesh.errors import FileError, ParameterError
from stitchmesh.mesh.palette import parse_colour, parse_yarn_colours
from stitchmesh.render.close_up import place_of
from stitchmesh.selection.parse import parse_selection
from stitchmesh.tessellate.edge_file import parse_edge, parse_edge_counts
from stitchmesh.yarn.rest_length import parse_rest_lengths
from stitchmesh.yarn.yarn_presets import parse_gauge
from stitchmesh.yarnrelax.model.material import parse_stiffnesses
from tests.fuzz.geometry_readers import GEOMETRY_READERS
from tests.fuzz.kept_readers import KEPT_READERS
from tests.fuzz.pattern_readers import PATTERN_READERS
from tests.fuzz.reader import Reader, files, later
from tests.fuzz.structures import JSON, TOML


def _parse_selection(path: Path) -> object:
    return parse_selection(path.read_text(encoding="utf-8", errors="replace"))


def _parse_short_texts(path: Path) -> object:
    """Read each line as each short text that files hold; a line that is none of them is an error."""
    for line in path.read_text(encoding="utf-8", errors="replace").splitlines():
        errors = [error for parse in SHORT_TEXTS if (error := _error_of(parse, line)) is not None]
        if len(errors) == len(SHORT_TEXTS):
            raise max(errors, key=lambda error: len(str(error)))
    return None


def _error_of(parse: Callable[[str], object], text: str) -> ParameterError | None:
    try:
        parse(text)
    except ParameterError as error:
        return error
    return None


def _edits(folder: Path) -> list[bytes]:
    return [
        b'{"edit": "change_stitch", "arguments": {"faces": [1, 2], "stitch": "P"}}\n'
        b'{"edit": "split_course_edge", "arguments": {"side": 9}}\n{"edit": "insert_row", "arguments": {"face": 3}}\n'
    ]


def _steps(folder: Path) -> list[bytes]:
    first = b'{"step": "start_at_edge", "arguments": {"edge": [3, 2]}}\n'
    return [first + b'{"step": "flip_row", "arguments": {"face": 1}}\n']


SHORT_TEXTS: Sequence[Callable[[str], object]] = (
    parse_gauge, parse_time, parse_error, parse_colour, parse_edge, place_of, lambda text: parse_yarn_colours([text]),
    lambda text: parse_stiffnesses([text]), lambda text: parse_rest_lengths([text]),
    lambda text: parse_edge_counts([text]),
)  # fmt: skip
"""Readers of texts of a few words."""
RECIPES = ["examples/hat.toml", "examples/sock.toml", "examples/sweater.toml"]
SCENES = [f"examples/mixed/{name}.toml" for name in ("swinging", "sleeve", "loops", "pulled")]
CLOTH_MATERIALS = ["examples/mixed/jersey/cloth.toml", "examples/mixed/materials/jersey.toml"]
YARN_MATERIALS = ["examples/mixed/materials/garment-yarns.toml"]

READERS: dict[str, Reader] = {
    "recipe": Reader(".toml", later("stitchmesh.read_recipe"), files(*RECIPES), TOML),
    "scene": Reader(".toml", later("stitchmesh.read_scene"), files(*SCENES), TOML),
    "panels": Reader(".toml", later("stitchmesh.mixed.cloth.panel_file.read_panels"),
                     files("examples/mixed/panels/sleeve.toml"), TOML),
    "cloth material": Reader(".toml", later("stitchmesh.mixed.triangles.material_file.read_material"),
                             files(*CLOTH_MATERIALS), TOML),
    "yarn materials": Reader(".toml", lambda path: sm.CrossingMaterial.read(path, "jersey"),
                             files(*YARN_MATERIALS), TOML, (FileError, ParameterError)),
    "yarn": Reader(".toml", later("stitchmesh.io.yarn_files.read_yarn"), lambda folder: [
        b'linear_density = "2/28 Nm"\ndiameter = "0.3 mm"\naxial_stiffness = "15 N"\nbending_rigidity = 4.5\n'],
                   TOML, (FileError, ParameterError)),
    "curve of a yarn": Reader(".csv", later("stitchmesh.io.yarn_files.read_curve"), lambda folder: [
        b"strain %,tension cN\n0,0\n1,15\n2,30\n"]),
    "sizes": Reader(".csv", later("stitchmesh.read_sizes"), lambda folder: [
        b"size,chest [cm],length [in]\nS,92,24\n2-4 y,100,24.5\n"]),
    "measured curves": Reader(".csv", later("stitchmesh.io.measured_curves.read_measured_curves"), lambda folder: [
        b"# width: 50 mm\n# length: 10 cm\ndirection,other,extension [mm],load [N]\nwale,free,5,0.1\ncourse,held,9,1\n",
        b"# direction: wale\nstrain [%],load [N/m]\n0,0\n10,2\n20,5\n"]),
    "edits": Reader(".jsonl", later("stitchmesh.editing.history.read_log"), _edits, JSON),
    "labeling steps": Reader(".jsonl", later("stitchmesh.read_label_steps"), _steps, JSON),
    "history": Reader(".csv", later("stitchmesh.io.history.read_history"), lambda folder: [
        b"iteration,seconds,residual,bend_erg\n1,0.5,0.1,2.5\n"]),
    "faces": Reader(".txt", later("stitchmesh.selection.selected_faces.read_faces"), lambda folder: [
        b"1, 2, 3 # faces\n7 8\n"]),
    "edges": Reader(".txt", later("stitchmesh.tessellate.edge_file.read_edge_settings"), lambda folder: [
        b"4,7=12\n3, 8\n# marked\n5,6 = 3\n"],
                    errors=(FileError, ParameterError)),
    "selection": Reader(".txt", _parse_selection, lambda folder: [
        b"hem 6", b"front and rows 20-40", b"(not left tip 3 or stitch K) and wale 3 to 9", b'file "faces.txt"'],
        errors=(ParameterError,)),
    "short texts": Reader(".txt", _parse_short_texts, lambda folder: [
        b"22x30", b"0.5h", b"1%", b"#aa2233", b"1=cream", b"k_bend=2.5", b"row:3=0.9", b"k=1.1", b"4,7=12", b"4,7",
        b"share 0.2 0.5", b"face 120"],
        errors=(ParameterError,)),
    **GEOMETRY_READERS,
    **PATTERN_READERS,
    **KEPT_READERS,
}  # fmt: skip
"""Readers by name."""
