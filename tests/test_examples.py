# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Every example runs, and its yarns are valid and have small strains."""

from __future__ import annotations

import importlib.util
from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.recipe.knit_recipe import knit_recipe
from stitchmesh.recipe.recipe_file import read_recipe
from tests.gallery import ROOT

EXAMPLES = sorted((ROOT / "examples").glob("*.py"))
RECIPES = sorted((ROOT / "examples").glob("*.toml"))


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_example_runs(path, tmp_path):
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    yarns = module.main(tmp_path, 2.5)
    assert np.isfinite(yarns.points).all()
    assert np.abs(yarns.strain).max() < 0.05  # The largest strain of a garment's yarn that the README allows.
    assert any(tmp_path.iterdir())


@pytest.mark.parametrize("path", RECIPES, ids=lambda path: path.stem)
def test_recipe_is_knitted(path, tmp_path):
    """A few iterations are enough for all stages to run; the colours and the patterns are those of the recipe."""
    recipe = read_recipe(path)
    made = knit_recipe(replace(recipe, device="cpu", solver=replace(recipe.solver, max_iterations=3)), tmp_path)
    assert np.isfinite(made.yarns.points).all() and (tmp_path / "garment.toml").exists()
    assert len(made.fabric.palette) == 1 + made.fabric.yarn.max()
    laid = made.report["patterns"]["laid"]
    assert [part["on"] for part in laid] == [part.on for part in recipe.patterns]
    for part in laid:  # Shaping and remainders leave few stitches of a region without its pattern.
        assert sum(one["faces"] for one in part["left_out"]) < 0.05 * part["faces"], part["name"]


def test_there_are_examples():
    assert EXAMPLES and RECIPES
