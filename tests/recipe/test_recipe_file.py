# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Recipes as files: round trips, paths, and what is refused."""

from __future__ import annotations

import tomllib
from dataclasses import fields, is_dataclass
from pathlib import Path

import pytest

from stitchmesh.editing.edit import Edit
from stitchmesh.errors import FileError, ParameterError, StitchMeshError
from stitchmesh.meshrelax.options import MeshRelaxOptions
from stitchmesh.recipe.recipe import Recipe, RecipeColour, RecipePattern, recipe_options
from stitchmesh.recipe.recipe_file import read_recipe, write_recipe
from stitchmesh.recipe.sections import (
    LabelSection,
    MaterialSection,
    PanelsSection,
    PhysicsSection,
    RestLengthsSection,
    RowsSection,
    SolverSection,
    StitchesSection,
)
from stitchmesh.shaping.marks import TimeMark
from stitchmesh.shaping.panels.options import PanelDirection, PanelOptions
from stitchmesh.yarngen import YarnFinish
from tests.gallery import ROOT

FULL = Recipe(
    mesh="meshes/hat.obj", unit="mm", up=(0.0, 0.0, 1.0), objects=("shirt",), layer="inner", yarn="dk", gauge="22x30",
    stitch_width=0.8, yarn_radius=0.1, drawn_radius=0.2, mass_per_length=0.002, quality="draft", device="cpu",
    edge_forms=("hem=fold:5", "left cuff=roll:4"), spiral=True, palette=("#a03030", "navy"),
    patterns=(
        RecipePattern(pattern="rib2x2", on="hem 6"),
        RecipePattern(pattern="charts/band.png", on='not file "faces.txt"', remainder="stretch", ground="navy",
                      shift=(3, -1), mirror=True),
    ),
    edits=(
        Edit("stripe", {"on": "rows 10-20 step 4", "yarn": 1}),
        Edit("twist_loop", {"side": 40, "twist": -1}),
        Edit("paste_pattern", {"pattern": "row 1 RS: k2\nrow 2 WS: p2", "faces": [3, 4]}),
        Edit("paste_pattern", {"pattern": "charts/one.knit", "on": "front"}),
    ),
    colours=(RecipeColour(on="neck 4", colour="teal"), RecipeColour(on="cuffs", yarn=1)),
    rows=RowsSection(
        auto=True, up=(0.0, 0.0, 1.0), multiple=4, short_rows=False, most_shaping=0.25, shaping="seams",
        marks=(
            TimeMark(kind="border", points=((0.0, 1.5, 2.0),), role="begin", time=0.0),
            TimeMark(kind="stroke", points=((0.0, 4.0, 2.0), (0.1, 4.0, 2.0))),
            TimeMark(kind="point", points=((0.0, 3.0, 2.0),), role="plain", radius=1.5),
        ),
    ),
    panels=PanelsSection(
        knit=True, directions=(PanelDirection(panel="back", direction=(1.0, 0.0)),), sewn=(("back", 2), (0, 1)),
        shaping="seams",
    ),
    label=LabelSection(start_borders=((1, 2),), start_edges=((3, 4), (5, 6)), flip=(7,), turn_inside_out=True),
    stitches=StitchesSection(
        course_height=0.5, increase="lifted", counts=("4,7=12",), marked=((5, 9),), edges="edges.txt"
    ),
    mesh_relaxation=MeshRelaxOptions(aspect=0.8, alpha=0.7, area_force=False),
    finish=YarnFinish(bind_off="drawn", cast_on="open", longest_float=3),
    material=MaterialSection(name="leaf", stiffness=("k_bend=0.1",)),
    rest_lengths=RestLengthsSection(factor=1.1, loop_length=3.0, factors=("k=1.1", "row:3=0.9")),
    physics=PhysicsSection(
        gravity=(0.0, -981.0, 0.0), friction=(0.2, 0.3), twist=5.0, body="body.obj", body_unit="dm",
        body_up=(1.0, 0.0, 0.0),
    ),
    solver=SolverSection(method="dynamics", max_iterations=50),
)  # fmt: skip
"""A recipe in which no value is the default."""


def defaults(value: object) -> list[str]:
    """Return the names of the fields whose value is the default, with those of nested dataclasses."""
    found = []
    for part in fields(value):  # type: ignore[arg-type]
        one = getattr(value, part.name)
        if one == part.default:
            found.append(part.name)
        elif is_dataclass(one):
            found += defaults(one)
    return found


def test_no_value_of_the_full_recipe_is_the_default():
    assert defaults(FULL) == []


@pytest.mark.parametrize("recipe", [FULL, Recipe(mesh="hat.obj")], ids=["full", "shortest"])
def test_a_recipe_is_read_as_it_was_written(tmp_path, monkeypatch, recipe):
    monkeypatch.chdir(tmp_path)
    write_recipe("garment.toml", recipe)
    assert read_recipe("garment.toml") == recipe
    text = Path("garment.toml").read_text()
    write_recipe("garment.toml", read_recipe("garment.toml"))
    assert Path("garment.toml").read_text() == text


def test_values_that_are_the_default_are_not_written(tmp_path):
    write_recipe(tmp_path / "garment.toml", Recipe(mesh=str(tmp_path / "hat.obj")))
    assert tomllib.loads((tmp_path / "garment.toml").read_text()) == {"mesh": "hat.obj"}


def test_paths_are_relative_to_the_recipe(tmp_path, monkeypatch):
    """A recipe in another folder names the same files."""
    monkeypatch.chdir(tmp_path)
    write_recipe(tmp_path / "out" / "garment.toml", FULL)
    table = tomllib.loads((tmp_path / "out" / "garment.toml").read_text())
    assert table["mesh"] == "../meshes/hat.obj" and table["stitches"]["edges"] == "../edges.txt"
    assert table["physics"]["body"] == "../body.obj"
    assert [part["pattern"] for part in table["patterns"]] == ["rib2x2", "../charts/band.png"]
    assert table["patterns"][1]["on"] == 'not file "../faces.txt"'
    assert table["edits"][3]["pattern"] == "../charts/one.knit"
    monkeypatch.chdir(tmp_path / "out")
    assert read_recipe("garment.toml").mesh == "../meshes/hat.obj"
    monkeypatch.chdir(tmp_path)
    assert Path(read_recipe("out/garment.toml").mesh).resolve() == tmp_path / "meshes" / "hat.obj"


def test_texts_with_quotes_and_other_letters_are_written_whole(tmp_path):
    recipe = Recipe(mesh=str(tmp_path / 'a "hat" \\ ä é 毛 \x7f.obj'))
    write_recipe(tmp_path / "garment.toml", recipe)
    assert Path(read_recipe(tmp_path / "garment.toml").mesh) == Path(recipe.mesh)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("mesh = 'h.obj'\nstich_width = 1", "has no key 'stich_width'; did you mean 'stitch_width'? the keys are unit"),
        ("stitch_width = 1", "needs 'mesh'; got stitch_width"),
        ("mesh = 3", "mesh is 3; expected a text"),
        ("mesh = 'h.obj'\nspiral = 1", "spiral is 1; expected true or false"),
        ("mesh = 'h.obj'\n[finsh]\nbind_off = 'chain'", "has no key 'finsh'; did you mean 'finish'?"),
        ("mesh = 'h.obj'\n[finish]\nbind_off = 'knot'", "bind off: got 'knot'; expected one of drawn, chain"),
        ("mesh = 'h.obj'\n[[patterns]]\non = 'hem'", "patterns[0] needs 'pattern'; got on"),
        ("mesh = 'h.obj'\n[patterns]\npattern = 'rib2x2'", "patterns is"),
        ("mesh = 'h.obj'\n[[edits]]\nyarn = 1", "edits[0] needs 'edit', the name of an edit; got yarn"),
        ("mesh = 'h.obj'\n[[edits]]\nedit = 'strip'", "edits[0]: edit 'strip': is unknown; expected stripe"),
        ("mesh = 'h.obj'\n[[edits]]\nedit = 'stripe'\nyarns = 1", "edits[0]: stripe:"),
        ("mesh = 'h.obj'\n[[edits]]\nedit = 'stripe'\nyarn = 1\non = 'hm 3'", "edits[0]: selection 'hm 3': 'hm' is"),
        ("mesh = 'h.obj'\nedits = 3", "edits: expected tables [[edits]]"),
        ("mesh = 'h.obj'\n[[colours]]\non = 'hem'", "colours[0]: on 'hem': expected either a yarn number or a colour"),
        ("mesh = 'h.obj'\n[rows]\nmultiple = 2", "multiple: is for rows that are found; give auto (--auto) too"),
        ("mesh = 'h.obj'\n[rows]\nauto = true\nup = [0, 0, nan]", "up: got (0.0, 0.0, nan)"),
        ("mesh = 'h.obj'\n[rows]\nauto = true\n[[rows.marks]]\nkind = 'point'", "rows.marks[0] needs 'points'; got"),
        (
            "mesh = 'h.obj'\n[rows]\nauto = true\n[[rows.marks]]\nkind = 'point'\npoints = [[0, 0, 1e308]]",
            "marks[0]: got points of shape (1, 3); expected finite points",
        ),
        ("mesh = 'h.obj'\n[panels]\nknit = true\nsewn = [[0]]", "panels.sewn[0] is [0]"),
        (
            "mesh = 'h.obj'\n[panels]\nknit = true\n[[panels.directions]]\npanel = 1\ndirection = [0, 0]",
            "directions: panel 1: got (0, 0)",
        ),
        ("mesh = 'h.obj'\n[mesh_relaxation]\nalpha = 2", "alpha: got 2"),
        ("mesh = 'h.obj'\n[physics]\ngravity = [0, 1]", "physics.gravity is [0, 1]"),
        ("mesh = 'h.obj'\n[solver]\nmethod = 'quick'", 'solver.method is "quick"'),
        ("mesh = ", "is no TOML (Invalid value"),
        ("mesh = 'h.obj'\nmesh = 'k.obj'", "is no TOML (Cannot overwrite a value"),
        ("\x00", "is no TOML"),
        ("", "the file is empty"),
    ],
)
def test_a_file_that_is_no_recipe_is_refused_in_one_line(tmp_path, text, message):
    path = tmp_path / "garment.toml"
    path.write_text(text)
    with pytest.raises(FileError) as refused:
        read_recipe(path)
    assert message in str(refused.value) and str(refused.value).startswith(str(path))
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"yarn": "dkk"}, "yarn: got 'dkk'; expected dk"),
        ({"gauge": "22", "stitch_width": 0.8}, "stitch width: got 0.8 cm and a gauge"),
        ({"palette": ("reddish",)}, "palette: colour: got 'reddish'"),
        ({"colours": (RecipeColour(on="hem", colour="nave"),)}, "colours[0]: colour: got 'nave'; expected #rrggbb"),
        ({"colours": (RecipeColour(on="hemm", yarn=1),)}, "colours[0]: selection 'hemm': 'hemm' is unknown; did you"),
        ({"patterns": (RecipePattern(pattern="rib22"),)}, "patterns[0]: pattern 'rib22': is not in the library"),
        ({"patterns": (RecipePattern(pattern="rib2x2", on="hem and"),)}, "patterns[0]: selection 'hem and': ends too"),
        ({"patterns": (RecipePattern(pattern="rib2x2", remainder="cut"),)}, "patterns[0]: remainder 'cut': is unknown"),
        ({"stitches": StitchesSection(edges="none.txt")}, "none.txt: there is no such file"),
        (
            {"rows": RowsSection(auto=True), "label": LabelSection(flip=(3,))},
            "flip: names edges or faces of a labeled mesh, but rows are found without one (--auto); leave one of",
        ),
    ],
)
def test_a_name_or_a_number_of_a_recipe_that_is_not_accepted_is_named(change, message):
    with pytest.raises(StitchMeshError) as refused:
        recipe_options(Recipe(mesh="hat.obj", **change))
    assert message in str(refused.value) and "\n" not in str(refused.value)


def test_found_rows_reach_the_options_of_the_stages():
    shaping = recipe_options(Recipe(mesh="hat.obj", rows=FULL.rows)).shaping
    assert shaping is not None and (shaping.up, shaping.multiple, shaping.short_rows) == ((0.0, 0.0, 1.0), 4, False)
    assert [(mark.kind, mark.role, mark.time, mark.radius) for mark in shaping.marks] == [
        ("border", "begin", 0.0, None), ("stroke", "row", None, None), ("point", "plain", None, 1.5),
    ]  # fmt: skip
    assert shaping.most_shaping == 0.25 and shaping.shaping == "seams"


def test_the_panels_reach_the_options_of_the_stages():
    panels = recipe_options(Recipe(mesh="shirt.obj", panels=FULL.panels)).panels
    directions = (PanelDirection(panel="back", direction=(1.0, 0.0)),)
    assert panels == PanelOptions(directions=directions, sewn=(("back", 2), (0, 1)), shaping="seams")


def test_a_colour_that_the_palette_has_is_its_number_and_another_is_added():
    colours = (RecipeColour(on="hem", colour="navy"), RecipeColour(on="neck", colour="#a03030"))
    options = recipe_options(Recipe(mesh="hat.obj", palette=("white", "#A03030"), colours=colours))
    assert options.palette == ("#ffffff", "#a03030", "#000080")
    assert [edit.arguments["yarn"] for edit in options.edits] == [2, 1]
    stock = recipe_options(Recipe(mesh="hat.obj", colours=colours[:1]))  # other stitches keep the stock colour
    assert len(stock.palette) == 2 and stock.edits[0].arguments["yarn"] == 1


def test_a_colour_needs_a_number_or_a_colour():
    for given in ({}, {"yarn": 1, "colour": "navy"}):
        with pytest.raises(ParameterError, match="expected either a yarn number or a colour"):
            RecipeColour(on="hem", **given)


@pytest.mark.parametrize("path", sorted((ROOT / "examples").glob("*.toml")), ids=lambda path: path.stem)
def test_the_files_that_an_example_names_exist(path):
    recipe = read_recipe(path)
    assert Path(recipe.mesh).is_file() and recipe_options(recipe).patterns
