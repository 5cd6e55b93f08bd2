# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Garments with finished measures: the sums of their stitches at rest, whole repeats, and a mesh of the measures."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.io import write_mesh
from stitchmesh.labeling import label
from stitchmesh.pipeline.garment import Garment, whole_mesh
from stitchmesh.pipeline.stage_table import ROWS, STITCHES, run_stages
from stitchmesh.recipe.finished import GROUND, FinishedGarment, finished_garment, parse_measures
from stitchmesh.recipe.garment_measures import GarmentMeasures
from stitchmesh.recipe.recipe import Recipe, recipe_options
from stitchmesh.recipe.sections import RecipePattern
from stitchmesh.run import Run
from tests.gallery import tube

ASKED = {"girth": 40.0, "length": 12.0}


@pytest.fixture(scope="module")
def made(tmp_path_factory) -> FinishedGarment:
    path = tmp_path_factory.mktemp("mesh") / "tube.obj"
    write_mesh(path, tube(8, 3, radius=5.0, height=4.0))
    rib = RecipePattern(pattern="rib1x1", on="hem 4")
    recipe = Recipe(mesh=str(path), quality="draft", device="cpu", yarn="worsted", patterns=(rib,))
    found = finished_garment(recipe, ASKED, quality="draft", progress=False)
    write_mesh(path, found.mesh)
    return found


def test_the_measures_come_true_and_the_mesh_has_them(made: FinishedGarment) -> None:
    # Whole stitches of 0.5 cm and whole rows of 0.4 cm are half of one off at most: 0.6 and 1.7 %.
    assert made.measures["girth"] == pytest.approx(ASKED["girth"], rel=0.01)
    assert made.measures["length"] == pytest.approx(ASKED["length"], rel=0.018)
    assert not made.notes
    measures = GarmentMeasures(label(made.mesh))
    assert [measures.value(name) for name in ASKED] == pytest.approx(list(ASKED.values()), rel=1e-3)


def test_the_recipe_makes_the_stitches_whose_sizes_at_rest_are_the_measures(made: FinishedGarment) -> None:
    recipe = made.recipe
    found = recipe.read_mesh()
    options = recipe_options(recipe, found.up)
    garment = Garment.begin(whole_mesh(found.mesh), options)
    fabric = run_stages((*ROWS, *STITCHES), garment, lambda stage, done: stage.run(done, Run(None))).fabric
    rows, counts = np.unique(fabric.row, return_counts=True)
    gauges = [made.gauges[name] for name in made.gauges if name != GROUND]
    ribbed = gauges[0].stitch_height * 4 + made.gauges[GROUND].stitch_height * (len(rows) - 4)
    assert ribbed == pytest.approx(made.measures["length"], rel=1e-6)
    assert counts[-1] * made.gauges[GROUND].stitch_width == pytest.approx(made.measures["girth"], rel=1e-6)
    assert options.relaxation.rest_lengths.loop_length == recipe.rest_lengths.loop_length


def test_rib_draws_in_when_nothing_holds_it(made: FinishedGarment) -> None:
    assert made.measures["hem"] < 0.8 * made.measures["girth"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "expected each measure once"),
        ("chest", "expected each measure once"),
        ("chest=96,chest=95", "expected each measure once"),
        ("chest=-5", "expected each measure once"),
        ("chest=5%", "expected each measure once"),
        ("chest=5 parsec", "expected each measure once"),
    ],
)
def test_measures_that_say_nothing_are_refused(text: str, message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        parse_measures(text)


def test_units_of_measures() -> None:
    assert parse_measures("chest=38in, length=62") == pytest.approx({"chest": 96.52, "length": 62.0})


def test_a_measure_that_the_garment_has_not_is_refused(made: FinishedGarment) -> None:
    recipe = replace(made.recipe, stitches=replace(made.recipe.stitches, counts=()))
    with pytest.raises(ParameterError, match="does not have it"):
        finished_garment(recipe, {"sleeve length": 40.0}, quality="draft", progress=False)
