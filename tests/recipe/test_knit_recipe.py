# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Garments from recipes: the same bits again, what the parts give, and what is refused before anything is written."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stitchmesh.io import read_stitches, read_yarns, write_mesh
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.mesh.upright import Y, Z, upright_turn
from stitchmesh.recipe.recipe import Recipe, recipe_options
from stitchmesh.recipe.recipe_file import read_recipe, write_recipe
from stitchmesh.recipe.sections import PhysicsSection, RowsSection
from stitchmesh.selection import select
from stitchmesh.shaping.marks import TimeMark
from tests.cli.calls import refused_without_files, run
from tests.gallery import tube

DRAFT = ["--quality", "draft", "--device", "cpu", "--max-iterations", "20", "--no-picture"]


@pytest.fixture(scope="module")
def mesh(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("mesh") / "tube.obj"
    write_mesh(path, tube(8, 3, radius=2.5, height=3.0))
    return path


@pytest.fixture(scope="module")
def knitted(tmp_path_factory, mesh) -> Path:
    folder = tmp_path_factory.mktemp("knitted") / "out"
    options = ["--stitch-width", 1, "--pattern", "rib2x2", "--on", "hem 3", "--pattern", "seed", "--on", "neck 3"]
    run("knit", mesh, *options, *DRAFT, "--bind-off", "chain", "-o", folder)
    return folder


def test_each_pattern_lies_on_its_selection(knitted):
    fabric = read_stitches(knitted / "stitches.h5")
    purls = np.flatnonzero(fabric.stitch == Stitch.PURL)
    assert np.isin(purls, select(fabric, "hem 3 or neck 3")).all()
    assert all(np.isin(purls, select(fabric, part)).any() for part in ("hem 3", "neck 3"))
    laid = json.loads((knitted / "report.json").read_text())["patterns"]["laid"]
    assert [(one["name"], one["on"]) for one in laid] == [("2 x 2 rib", "hem 3"), ("Seed stitch", "neck 3")]


def test_the_recipe_that_knit_writes_gives_the_same_bits_again(knitted, tmp_path):
    again = tmp_path / "again"
    run("knit", knitted / "garment.toml", "--no-picture", "-o", again)
    np.testing.assert_array_equal(read_stitches(again / "stitches.h5").stitch,
                                  read_stitches(knitted / "stitches.h5").stitch)  # fmt: skip
    one, other = (read_yarns(folder / "yarns.h5") for folder in (knitted, again))
    np.testing.assert_array_equal(one.points, other.points)
    np.testing.assert_array_equal(one.rest_length, other.rest_length)
    assert (again / "yarns.bcc").read_bytes() == (knitted / "yarns.bcc").read_bytes()
    first, second = read_recipe(knitted / "garment.toml"), read_recipe(again / "garment.toml")
    assert first.patterns == second.patterns and Path(first.mesh).resolve() == Path(second.mesh).resolve()


def test_a_recipe_takes_its_quality_and_device_from_the_command_line(knitted, tmp_path):
    recipe = replace(read_recipe(knitted / "garment.toml"), quality="none", device="gpu")
    write_recipe(tmp_path / "one.toml", recipe)
    options = ["--quality", "draft", "--device", "cpu", "--no-picture", "-o", tmp_path / "out"]
    run("knit", tmp_path / "one.toml", *options)
    made = read_recipe(tmp_path / "out" / "garment.toml")
    assert (made.quality, made.device) == ("draft", "cpu")


def test_colours_stripes_and_edits_of_a_recipe_are_made(mesh, tmp_path):
    recipe = tmp_path / "tube.toml"
    recipe.write_text(f"""
mesh = "{mesh}"
stitch_width = 1.0
quality = "draft"
device = "cpu"
palette = ["#f0e0c0"]
[[edits]]
edit = "change_stitch"
stitch = "p"
on = "hem 4-5"
[[colours]]
on = "hem 2-9 step 4 height 2"
colour = "navy"
[solver]
max_iterations = 5
""")
    run("knit", recipe, "--no-picture", "-o", tmp_path / "out")
    fabric, yarns = read_stitches(tmp_path / "out" / "stitches.h5"), read_yarns(tmp_path / "out" / "yarns.h5")
    assert set(fabric.row[fabric.yarn == 1]) == {1, 2, 5, 6} and set(fabric.row[fabric.stitch == Stitch.PURL]) == {3, 4}
    np.testing.assert_array_equal(fabric.palette, [[0xF0, 0xE0, 0xC0], [0, 0, 0x80]])
    np.testing.assert_array_equal(yarns.palette, fabric.palette)


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ("mesh = 'none.obj'", "none.obj: there is no such file"),
        ("[[patterns]]\npattern = 'rib2x2'\non = 'cuffs 3'", "cuffs 3: the fabric has no such border; its borders"),
        ("[[patterns]]\npattern = 'rib2x2'\non = 'hem 2 and neck 2'", "is empty"),
        ("[[patterns]]\npattern = 'rib2x2'\non = 'hem 3'\n[[patterns]]\npattern = 'moss'\non = 'front'",
         "2 x 2 rib on 'hem 3' and Moss stitch on 'front' both cover"),
        ("[[patterns]]\npattern = 'wide.knit'\non = 'front panel 6'", "on 'front panel 6': pattern"),
        ("[[edits]]\nedit = 'stripe'\nyarn = 1\non = 'rows 99'", "edit stripe: rows 99: the fabric has no such row"),
    ],
)  # fmt: skip
def test_a_recipe_that_cannot_be_made_is_refused_in_one_line_and_nothing_is_written(
    mesh, tmp_path, capsys, lines, message
):
    (tmp_path / "wide.knit").write_text("row 1 RS: k10 p10\nrow 2 WS: k10 p10\n")
    recipe = tmp_path / "garment.toml"
    first = "" if lines.startswith("mesh") else f"mesh = '{mesh}'\n"
    recipe.write_text(f"{first}stitch_width = 1\n{lines}\n")
    assert message in refused_without_files(capsys, tmp_path, "knit", recipe, "--no-picture", "-o", tmp_path / "out")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--stitch-width", "1"], "stitch_width: is part of a recipe; write it into"),
        (["--pattern", "rib2x2"], "pattern: is part of a recipe"),
        (["--max-iterations", "5"], "solver.max_iterations: is part of a recipe"),
    ],
)
def test_options_that_belong_into_the_recipe_are_refused(knitted, tmp_path, capsys, options, message):
    words = ["knit", knitted / "garment.toml", *options, "-o", tmp_path / "out"]
    assert message in refused_without_files(capsys, tmp_path, *words)


def test_patterns_and_selections_on_the_command_line_come_in_pairs(mesh, tmp_path, capsys):
    given = ["--pattern", "rib2x2", "--pattern", "moss", "--on", "hem 3"]
    message = refused_without_files(capsys, tmp_path, "knit", mesh, *given, "-o", tmp_path / "out")
    assert "pattern: got 2 patterns and 1 selections; give one --on SELECTION for each" in message


def test_marks_and_the_body_are_turned_with_a_mesh_that_lies_in_its_file(tmp_path):
    """A tube and a ball in it, as files with y up and with z up, and a mark at its upper border."""
    standing, ball = tube(12, 4, radius=18.0, height=5.0), tube(6, 1, radius=1.0)
    for name, mesh in (("skirt", standing), ("body", ball)):
        write_mesh(tmp_path / f"{name}.obj", mesh)
        write_mesh(tmp_path / f"{name}-z.obj", replace(mesh, vertices=mesh.vertices @ upright_turn(Z)))

    def made(suffix, point):
        mark = TimeMark(kind="border", points=(point,), role="begin")
        recipe = Recipe(
            mesh=str(tmp_path / f"skirt{suffix}.obj"), rows=RowsSection(auto=True, marks=(mark,)),
            physics=PhysicsSection(body=str(tmp_path / f"body{suffix}.obj")),
        )  # fmt: skip
        found = recipe.read_mesh()
        return found, recipe_options(recipe, found.up)

    found, options = made("", (0.0, 20.0, 18.0))
    turned, its_options = made("-z", (0.0, -18.0, 20.0))
    assert (found.up, turned.up) == (Y, Z)
    np.testing.assert_array_equal(turned.mesh.vertices, found.mesh.vertices)
    assert its_options.shaping == options.shaping
    (body,), (its_body,) = options.relaxation.terms, its_options.relaxation.terms
    np.testing.assert_array_equal(its_body.mesh.vertices, body.mesh.vertices)


def test_a_direction_of_knitting_is_one_of_the_mesh_as_it_lies(tmp_path):
    lying = tube(12, 4, radius=18.0, height=5.0)
    write_mesh(tmp_path / "skirt.obj", replace(lying, vertices=lying.vertices @ upright_turn(Z)))
    recipe = Recipe(mesh=str(tmp_path / "skirt.obj"), rows=RowsSection(auto=True, up=Z))
    assert recipe.read_mesh().up == Y and replace(recipe, up=Z).read_mesh().up == Z
