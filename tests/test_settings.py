# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A setting is declared once: its option, its key of a recipe, its key of a job and its axis of a sweep follow."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

import pytest

from stitchmesh.cli.arguments import parse
from stitchmesh.cli.main import COMMANDS
from stitchmesh.errors import ParameterError
from stitchmesh.io.checked import check_table
from stitchmesh.jobs.job_file import job_of_table
from stitchmesh.jobs.sections import SwatchTable
from stitchmesh.jobs.sweep.axis import grid_axes, with_option
from stitchmesh.jobs.sweep.sweep import Sweep
from stitchmesh.recipe.recipe import Recipe
from stitchmesh.recipe.sections import GarmentSettings
from stitchmesh.settings import check_settings, declared_setting, setting, settings_of

VALUES: dict[str, tuple[list[str], Any]] = {
    "up": (["z"], [0.0, 0.0, 1.0]),
    "objects": (["shirt"], ["shirt"]),
    "layer": (["inner"], "inner"),
    "yarn": (["dk"], "dk"),
    "gauge": (["22x30"], "22x30"),
    "unit": (["mm"], "mm"),
    "edge_forms": (["hem=fold:5"], ["hem=fold:5"]),
    "palette": ([], ["navy"]),
    "rows.up": ([], [1.0, 0.0, 0.0]),
    "rows.marks": (["MARKS"], [{"kind": "border", "points": [[0.0, 1.0, 0.0]], "role": "begin"}]),
    "rows.most_shaping": (["0.25"], 0.25),
    "rows.shaping": (["seams"], "seams"),
    "panels.directions": (["back=1,0"], [{"panel": "back", "direction": [1.0, 0.0]}]),
    "panels.sewn": (["back,2"], [["back", 2]]),
    "panels.shaping": ([], "seams"),
    "label.start_borders": (["1,2"], [[1, 2]]),
    "label.start_edges": (["3,4"], [[3, 4]]),
    "label.flip": (["7"], [7]),
    "stitches.increase": (["kfb"], "kfb"),
    "stitches.counts": (["0,1=5"], ["0,1=5"]),
    "stitches.marked": (["5,9"], [[5, 9]]),
    "stitches.edges": (["edges.txt"], "edges.txt"),
    "finish.bind_off": (["drawn"], "drawn"),
    "finish.cast_on": (["open"], "open"),
    "material.name": (["leaf"], "leaf"),
    "material.stiffness": (["k_bend=1"], ["k_bend=1"]),
    "rest_lengths.factors": (["k=1.1"], ["k=1.1"]),
    "physics.gravity": (["0", "-981", "0"], [0.0, -981.0, 0.0]),
    "physics.friction": (["0.2,0.3"], [0.2, 0.3]),
    "physics.twist": (["5"], 5.0),
    "physics.body": (["/body.obj"], "/body.obj"),
    "physics.body_unit": (["mm"], "mm"),
    "physics.body_up": (["z"], [0.0, 0.0, 1.0]),
    "solver.method": (["dynamics"], "dynamics"),
    "solver.max_iterations": (["3"], 3),
}
"""Words of an option and the value of its key, for settings that are neither numbers nor switches."""
NEEDS = {"rows": ("rows.auto", True), "panels": ("panels.knit", True)}
"""Sections that another setting switches on."""
GARMENT = {path: part for path, part, _found in settings_of(GarmentSettings())}


def example(path: str) -> tuple[list[str], Any]:
    """The words of an option and the value of its key, other than the default."""
    default = GARMENT[path].default
    if isinstance(default, bool):
        return [], not default
    return VALUES[path] if path in VALUES else numbers(default)


def numbers(default: Any) -> tuple[list[str], Any]:
    return (["3"], 3) if isinstance(default, int) else (["0.5"], 0.5)


def table_with(path: str, value: Any) -> dict[str, Any]:
    table = with_option({"mesh": "/a.obj"}, tuple(path.split(".")), value)
    switch, on = NEEDS.get(path.partition(".")[0], (path, value))
    return with_option(table, tuple(switch.split(".")), on)


def value_at(found: Any, path: str) -> Any:
    for key in path.split("."):
        found = getattr(found, key)
    return found


@pytest.mark.parametrize("path", GARMENT)
def test_each_setting_of_a_garment_is_a_key_an_axis_and_an_option(path, tmp_path):
    part = GARMENT[path]
    words, value = example(path)
    if path == "rows.marks":
        (tmp_path / "marks.json").write_text(json.dumps(value))
        words = [str(tmp_path / "marks.json")]
    table = table_with(path, value)
    recipe = check_table(table, Recipe)
    assert value_at(recipe, path) != part.default
    job = job_of_table(table, "job.toml")
    assert job.garment == recipe
    nested: dict[str, Any] = with_option({}, tuple(path.split(".")), [value])
    swept = Sweep(job=table_with(*NEEDS.get(path.partition(".")[0], ("spiral", False))), grid=grid_axes(nested))
    assert value_at(job_of_table(swept.table(0), "job.toml").garment, path) == value_at(recipe, path)
    declared = declared_setting(part)
    if declared.flag is None:
        return
    sign = "no-" if part.default is True else ""
    flag = f"--{sign}{declared.flag or part.name.replace('_', '-')}"
    switch = {"rows": ["--auto"], "panels": ["--panels"]}.get(path.partition(".")[0], [])
    line = ["knit", "/a.obj", "-o", "out", *[word for word in switch if word != flag], flag, *words]
    assert parse(COMMANDS, line, program="stitchmesh", description="").recipe() == recipe


def test_each_number_of_a_swatch_is_a_key_and_an_axis():
    for path, part, _found in settings_of(SwatchTable(pattern="rib2x2")):
        if isinstance(part.default, int | float) and not isinstance(part.default, bool):
            value = numbers(part.default)[1]
            swept = Sweep(job={"swatch": {"pattern": "rib2x2"}}, grid=grid_axes({"swatch": {path: [value]}}))
            assert value_at(job_of_table(swept.table(0), "job.toml").swatch, path) == value


@dataclass(frozen=True)
class Bounded:
    """Settings with each kind of bound."""

    size: float | None = setting(None, "size", unit="cm", positive=True)
    part: float = setting(0.5, "part", least=0.0, most=1.0)
    turns_made: int = setting(1, "turns", least=1, expected="1 or more turns")
    form: str = setting("flat", "form", choices=("flat", "tube"))

    def __post_init__(self) -> None:
        check_settings(self)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"size": 0.0}, "size: got 0.0 cm; expected a positive number"),
        ({"part": 1.5}, "part: got 1.5; expected 0 to 1"),
        ({"part": float("nan")}, "part: got nan; expected 0 to 1"),
        ({"turns_made": 0}, "turns made: got 0; expected 1 or more turns"),
        ({"form": "ball"}, "form: got 'ball'; expected one of flat, tube"),
    ],
)
def test_a_value_out_of_bounds_is_refused_in_one_line(given, message):
    with pytest.raises(ParameterError) as refused:
        Bounded(**given)
    assert str(refused.value) == message
