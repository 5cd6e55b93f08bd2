# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Parsing of the command line: the defaults are those of the library, and an error message is one line."""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import MISSING, fields, is_dataclass
from typing import Annotated, Any, get_args, get_origin, get_type_hints

import pytest

from stitchmesh.cli.arguments import one_line, parse
from stitchmesh.cli.main import COMMANDS, main
from stitchmesh.editing.edit import Edit
from stitchmesh.periodic.swatch_options import SwatchOptions
from stitchmesh.pipeline.options import KnitOptions, RelaxOptions
from stitchmesh.recipe.recipe import Recipe, RecipePattern, recipe_options
from stitchmesh.settings import declared_setting
from stitchmesh.yarn.rest_length import RestLengths
from stitchmesh.yarn.stitch_size import StitchMeasures, stitch_size
from stitchmesh.yarn.yarn_presets import Yarn
from stitchmesh.yarngen import YarnFinish
from tests.cli.calls import refused
from tests.gallery import ROOT

REQUIRED: dict[str, list[str]] = {
    "convert": ["a.h5", "b.h5"], "pattern": ["a.h5", "rib2x2", "-o", "b.h5"], "patterns": [], "edit": ["a.h5"],
    "instructions": ["a.h5"], "info": ["a.h5"], "select": ["a.h5"], "check": ["a.h5"],
    "app": [], "examples": [], "warm-up": [], "measure": ["plain"], "view": ["a.h5"], "yarn": ["list"],
    "swatch": ["plain"], "drape": ["a.toml"], "fit": ["--pattern", "rib1x1", "-o", "b.toml"],
    "follow": ["a.h5", "b.usdc", "-o", "c"], "animate": ["a.h5", "b.usdc", "-o", "c"],
    "run": ["a.toml"], "job": ["init", "a.obj"], "status": ["a"], "batch": ["a.toml"], "book": ["-o", "b"],
    "blender-addon": ["-o", "a.zip"],
    "grade": ["a.toml", "--sizes", "b.csv", "-o", "c"],
    "relax-mesh": ["a.h5", "--surface", "b.h5", "-o", "c.h5"],
    "relax-edited": ["a.h5", "--before", "b.h5", "--after", "c.h5", "-o", "d.h5"],
}  # fmt: skip
"""Required words of the commands that need other words than a file and an output file."""
POSITIONAL = (
    "mesh", "file", "pattern", "fabric", "yarns", "labeled", "output", "arguments", "selections", "scene", "job",
    "action", "source", "folder", "sweep", "body", "piece", "cloth", "name", "recipe", "curves",
    "patterns",
)  # fmt: skip
"""Fields of the commands that are words without a flag in one of them."""


def words_of(name: str) -> list[str]:
    return [name, *REQUIRED.get(name, ["a.h5", "-o", "b"])]


def parsed(words: list[str]) -> Any:
    return parse(COMMANDS, words, program="stitchmesh", description="")


@pytest.mark.parametrize(("name", "command"), COMMANDS.items())
def test_with_the_required_words_all_other_options_have_their_defaults(name, command):
    made = parsed(words_of(name))
    assert type(made) is command
    for field in fields(command):
        default = field.default_factory() if field.default_factory is not MISSING else field.default
        if default is not MISSING:
            assert getattr(made, field.name) == default, field.name


def test_defaults_are_those_of_the_library():
    knit, swatch = parsed(words_of("knit")), parsed(words_of("swatch"))
    library = KnitOptions()
    assert knit.recipe() == Recipe(mesh="a.h5") and recipe_options(Recipe(mesh="a.h5")) == library
    assert knit.garment.stitch_width is None and knit.garment.size == StitchMeasures()  # so the library decides
    assert knit.pattern_remainder == RecipePattern(pattern="rib2x2").remainder
    assert knit.garment.finish == library.finish == YarnFinish()
    assert knit.garment.material.name is RelaxOptions().material is None  # so the yarn, or the library, decides
    assert knit.garment.rest_lengths.rest_lengths() == RestLengths()
    assert SwatchOptions(**swatch.fabric.options(woven=False), period=swatch.period) == SwatchOptions()


def test_words_set_their_fields():
    made = parsed([
        "knit", "a.obj", "-o", "out", "--seed", "1,2", "--seed", "3,4", "--flip", "7", "--flip", "8", "--gravity", "0",
        "-981", "0", "--friction", "0.2,0.3", "--twist", "5", "--rest-length", "k=1.1", "--rest-length", "row:3=0.9",
        "--no-picture", "--spiral", "--no-area-force", "--yarn-radius", "0.1", "--longest-float=3", "--solver",
        "dynamics", "--pattern", "checks", "--pattern-ground", "1", "--stripes", "4 cream, 2 navy",
    ])  # fmt: skip
    assert made.recipe().patterns == (RecipePattern(pattern="checks", ground="1"),)
    assert made.recipe().edits == (Edit("stripes", {"bands": "4 cream, 2 navy"}),)
    garment = made.garment
    assert garment.label.start_edges == ((1, 2), (3, 4)) and garment.label.flip == (7, 8)
    assert garment.physics.gravity == (0.0, -981.0, 0.0)
    assert (garment.physics.friction, garment.physics.twist) == ((0.2, 0.3), 5.0)
    assert garment.rest_lengths.rest_lengths().stitches == {"k": 1.1}
    assert made.no_picture and garment.spiral and garment.yarn_radius == 0.1
    assert garment.finish.longest_float == 3 and garment.solver.method == "dynamics"
    assert not garment.mesh_relaxation.area_force


@pytest.mark.parametrize("command", ["knit", "tessellate", "swatch", "stretch"])
def test_a_yarn_and_a_gauge_set_the_sizes(command):
    made = parsed([*words_of(command), "--yarn", "aran", "--gauge", "20x28"])
    choice = {"knit": "garment", "tessellate": "yarn"}.get(command, "fabric")
    chosen = getattr(made, choice)
    assert (chosen.yarn if choice == "fabric" else chosen).measures() == stitch_size("aran", "20x28")


def test_a_swatch_takes_the_yarn_and_a_weave_only_its_radius():
    swatch, dk = parsed([*words_of("swatch"), "--yarn", "dk"]), Yarn.named("dk")
    knitted, woven = (SwatchOptions(**swatch.fabric.options(woven=woven)) for woven in (False, True))
    assert (knitted.yarn_radius, knitted.loop_length) == (dk.core_radius, dk.loop_length)
    assert (woven.yarn_radius, woven.loop_length) == (dk.core_radius, None)


@pytest.mark.parametrize(
    ("words", "period"), [(["free", "1.5"], (None, 1.5)), (["2", "free"], (2.0, None)), (["-1", "3"], (-1.0, 3.0))]
)
def test_a_period_is_two_sizes_or_free(words, period):
    assert parsed([*words_of("swatch"), "--period", *words]).period == period


@pytest.mark.parametrize(
    ("words", "up"), [(["--up", "z"], (0, 0, 1)), (["--up=-X"], (-1, 0, 0)), (["--up", "0,1,-0.5"], (0, 1, -0.5))]
)
def test_a_direction_is_an_axis_or_three_numbers(words, up):
    assert parsed([*words_of("knit"), *words]).garment.up == up


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["knit", "a.obj", "-o", "o", "--up", "w"], "--up: got 'w'; expected an axis such as y or -x, or three"),
        (["knit", "a.obj", "-o", "o", "--stitch-width", "wide"], "--stitch-width: got 'wide'; expected a number"),
        (["knit", "a.obj", "-o", "o", "--max-iterations", "1.5"], "--max-iterations: got '1.5'; expected a whole"),
        (["knit", "a.obj", "-o", "o", "--gravity", "0", "down", "0"], "--gravity: got '0 down 0'; expected numbers"),
        (["knit", "a.obj", "-o", "o", "--gravity", "0", "0"], "--gravity"),
        (["knit", "a.obj", "-o", "o", "--seed", "3"], "--start-edge: got '3'; expected two whole numbers with a comma"),
        (["knit", "a.obj", "-o", "o", "--friction", "a,b"], "--friction: got 'a,b'; expected one number, or two"),
        (["knit", "a.obj", "-o", "o", "--solver", "quick"], "got 'quick'; expected one of quasistatic, dynamics"),
        (["knit", "a.obj", "-o", "o", "--sew", "front"], "got 'front'; expected the number or the name of a panel"),
        (["knit", "a.obj", "-o", "o", "--panel-direction", "front"], "got 'front'; expected a panel and its direction"),
        (["knit", "a.obj", "-o", "o", "--stich-width", "2"], "Perhaps you meant: --stitch-width CM"),
        (["knit", "a.obj"], "Missing from stitchmesh knit: -o DIR, --output DIR"),
        (["knit", "a.obj", "b.obj", "-o", "o"], "Unrecognized options: b.obj"),
        (["knit", "a.obj", "-o"], "'-o/--output'"),
        (["label", "a.obj", "-o", "o", "--set-edge", "0,1=blue"], "--set-edge: got '0,1=blue'; expected V,W=course"),
        (["relax", "a", "-o", "b", "--fabric", "c", "--keep-shape", "d"], "--fabric and --keep-shape are not allowed"),
        (["relax", "a", "-o", "b", "--twist", "much"], "--twist: got 'much'; expected"),
        (["swatch", "plain", "-o", "o", "--period", "1", "wide"], "--period: got '1 wide'; expected two numbers of cm"),
        (["swatch", "plain", "-o", "o", "--spacing", "1", "2", "3"], "--spacing: got '1 2 3'; expected one number"),
        (["swatch", "plain", "-o", "o", "--tile", "1.5", "2"], "--tile: got '1.5 2'; expected whole numbers"),
        (["knot"], "Unrecognized options: knot; Available subcommands: knit, label"),
        ([], "Expected one of {knit, label"),
    ],
)  # fmt: skip
def test_words_that_are_not_a_command_give_a_message_of_one_line(capsys, words, message):
    said = refused(capsys, *words)
    assert message in said and not set(said) & set("│╭╰─")
    program = f"stitchmesh {words[0]}" if words and words[0] != "knot" else "stitchmesh"
    assert said.startswith(f"{program}: ") and said.endswith(f"; see {program} --help\n")


@pytest.mark.parametrize("width", ["40", "200"])
def test_an_error_message_does_not_depend_on_the_width_of_the_terminal(capsys, monkeypatch, width):
    monkeypatch.setenv("COLUMNS", width)
    said = refused(capsys, "knit", "a.obj", "-o", "o", "--friction", "slippery")
    assert "--friction: got 'slippery'; expected one number, or two with a comma between them; see" in said


@pytest.mark.parametrize("name", COMMANDS)
def test_help_fits_the_terminal_and_shows_every_option(capsys, monkeypatch, name):
    monkeypatch.setenv("COLUMNS", "80")
    with pytest.raises(SystemExit) as stop:
        main([name, "--help"])
    text = capsys.readouterr().out
    assert stop.value.code == 0
    assert max(len(line) for line in text.splitlines() if not line.startswith("usage")) <= 80
    for option in options_of(COMMANDS[name]):
        assert f"--{option}" in text or option in POSITIONAL
    assert "None" not in text and "False" not in text and "``" not in text


def options_of(group: Any) -> list[str]:
    """Return the flags of a dataclass and of the groups of options in it."""
    found = []
    for name, hint in get_type_hints(group, include_extras=True).items():
        inner = get_args(hint)[0] if get_origin(hint) is Annotated else hint
        declared = declared_setting(group.__dataclass_fields__[name])
        if is_dataclass(inner):
            found += options_of(inner)
        elif declared is None or declared.flag is not None:
            off = "no-" if declared and group.__dataclass_fields__[name].default is True else ""
            found.append(off + ((declared and declared.flag) or name.replace("_", "-")))
    return found


def test_commands_are_frozen():
    assert not [command for command in COMMANDS.values() if not command.__dataclass_params__.frozen]


BOX = """\
╭─ Value error ─────────╮
│ Error parsing -x: got │
│ 'a'                   │
│ ───────────────────── │
│ Argument helptext:    │
│     -x X              │
╰───────────────────────╯
"""
INDENTED = """\
 Required options
 ------------------
  Missing from it:
      MESH
          any mesh
      -o DIR
  ------------------
  For full helptext, run:
      it --help

"""


COLOURED = "\x1b[31m│\x1b[0m \x1b[91;1mError\x1b[0m parsing -x: no \x1b[31m│\x1b[0m"


@pytest.mark.parametrize(
    ("box", "line"),
    [(BOX, "-x: got 'a'"), (INDENTED, "Missing from it: MESH, -o DIR"), (COLOURED, "-x: no"), ("a\nb\n", "a b")],
)
def test_each_kind_of_message_becomes_one_line(box, line):
    """tyro draws a box if standard output is in UTF-8, and indents the text otherwise."""
    assert one_line(box) == line


def test_an_error_message_is_one_line_on_an_ascii_terminal():
    words = [sys.executable, "-m", "stitchmesh", "knit", "a.obj", "-o", "o", "--friction", "slippery"]
    environment = {**os.environ, "PYTHONIOENCODING": "ascii", "COLUMNS": "60"}
    done = subprocess.run(words, capture_output=True, text=True, cwd=ROOT, env=environment)
    assert done.returncode == 2 and done.stdout == ""
    expected = "--friction: got 'slippery'; expected one number, or two with a comma between them"
    assert done.stderr == f"stitchmesh knit: {expected}; see stitchmesh knit --help\n"
