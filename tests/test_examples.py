# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Every example runs, and its yarns are valid and have small strains."""

from __future__ import annotations

import importlib.util
import sys
from dataclasses import replace
from unittest.mock import MagicMock

import numpy as np
import pytest

import stitchmesh as sm
from stitchmesh.compute.device import device_named
from stitchmesh.recipe.knit_recipe import knit_recipe
from stitchmesh.recipe.recipe_file import read_recipe
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.motion.carried_points import distances_from_mesh
from tests.gallery import ROOT
from tests.nightly import mostly_at_night

IN_BLENDER = ROOT / "examples" / "blender_render.py"
"""The example that Blender's own Python runs."""
WITH_NEWTON = ROOT / "examples" / "animate_skirt.py"
"""The example of which another program simulates the cloth."""
EXAMPLES = sorted(set((ROOT / "examples").glob("*.py")) - {IN_BLENDER, WITH_NEWTON})
BY_DAY = ROOT / "examples" / "purl_a_band.py"
"""An example that makes stitches, edits them and relaxes their yarns, as most of the others do."""
RECIPES = sorted((ROOT / "examples").glob("*.toml"))


@pytest.mark.parametrize("path", mostly_at_night(EXAMPLES, by_day=[BY_DAY]), ids=lambda path: path.stem)
def test_example_runs(path, tmp_path):
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    yarns = module.main(tmp_path, 2.2)
    assert np.isfinite(yarns.points).all()
    assert np.abs(yarns.strain).max() < 0.05  # The largest strain of a garment's yarn that the README allows.
    assert any(tmp_path.iterdir())


@pytest.fixture
def skirt_example():
    """The example of a skirt whose cloth Newton simulates, loaded without Newton."""
    spec = importlib.util.spec_from_file_location(WITH_NEWTON.stem, WITH_NEWTON)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_stitches_of_the_animated_skirt_lie_on_its_cloth(skirt_example, tmp_path, monkeypatch):
    """The simulation is left out: its first frame is the skirt."""
    monkeypatch.setattr(skirt_example, "simulate", lambda *given: None)
    mesh = skirt_example.skirt()
    skirt_example.main(tmp_path, mesh)
    fabric = sm.read_stitches(tmp_path / "stitches.h5")
    away = distances_from_mesh(mesh, fabric.vertices, device_named("cpu"))
    assert away.max() < 0.1  # The stitches lie on the smooth surface, beside quads of about 1 cm.
    np.testing.assert_array_equal(skirt_example.turned(mesh.vertices, 0.0, 100.0), mesh.vertices)


def test_newton_simulates_the_skirt(skirt_example, tmp_path):
    pytest.importorskip("newton")
    skirt_example.simulate(skirt_example.skirt(), tmp_path / "cloth.usdc", 2)
    cloth = sm.read_moving_mesh(tmp_path / "cloth.usdc")
    first, second = cloth.motion.vertices
    assert np.abs(first - skirt_example.skirt().vertices).max() < 1e-5  # The file has single precision, in metres.
    assert 0.0 < np.abs(second - first).max() < 1.0


@pytest.fixture
def blender_example(monkeypatch):
    """The example for Blender, loaded without Blender: its modules are empty."""
    monkeypatch.setitem(sys.modules, "bpy", MagicMock())
    monkeypatch.setitem(sys.modules, "mathutils", MagicMock())
    spec = importlib.util.spec_from_file_location("blender_render", IN_BLENDER)
    module = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, "blender_render", module)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("closed", [True, False])
def test_blender_draws_the_curves_of_the_yarns(blender_example, closed):
    """The points that the example draws are those of ``YarnSet.sampled``."""
    control = np.random.default_rng(3).normal(size=(9, 3))
    yarn = YarnSet.from_curves([control], closed=[closed], radius=0.1)
    (curve,) = yarn.sampled(blender_example.POINTS_OF_SEGMENT)
    expected = np.concatenate([curve, curve[:1]]) if closed else curve
    np.testing.assert_allclose(blender_example.on_spline(control, closed), expected, atol=1e-12)  # double precision


def test_blender_gets_colours_in_linear_light(blender_example):
    """The ends of the scale, and the value of middle grey by the definition of sRGB (IEC 61966-2-1)."""
    assert blender_example.linear("#000000") == (0.0, 0.0, 0.0)
    assert blender_example.linear("#ffffff") == pytest.approx((1.0, 1.0, 1.0))
    assert blender_example.linear("808080") == pytest.approx((0.2158605,) * 3, abs=1e-6)


@pytest.mark.parametrize("path", mostly_at_night(RECIPES, by_day=RECIPES[:1]), ids=lambda path: path.stem)
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
