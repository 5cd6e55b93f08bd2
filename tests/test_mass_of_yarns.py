# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The mass that a named yarn states reaches its yarns on every way, and is what everything reads that has a mass."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

import stitchmesh as sm
from stitchmesh.app.pages.swatch.dial_panel import yarn_of_dials
from stitchmesh.app.pages.yarns.settings import YarnSettings
from stitchmesh.cli.commands.swatch import SwatchCommand
from stitchmesh.cli.options import SwatchFabric
from stitchmesh.errors import ParameterError, YarnError
from stitchmesh.jobs.job import recipe_of
from stitchmesh.jobs.job_file import job_of_table
from stitchmesh.jobs.sections import SwatchTable
from stitchmesh.patterns import read_pattern
from stitchmesh.periodic.relaxation.prepared_swatch import prepare_swatch
from stitchmesh.periodic.repeat.smallest_cell import SmallestCell
from stitchmesh.periodic.session.session import SwatchSession
from stitchmesh.periodic.swatch import in_fabric, scale_yarns
from stitchmesh.periodic.swatch_design import SwatchDesign, SwatchDials
from stitchmesh.periodic.swatch_options import SwatchOptions
from stitchmesh.pipeline.options import RelaxOptions
from stitchmesh.recipe.recipe import Recipe, recipe_options
from stitchmesh.recipe.sections import MaterialSection, YarnAndGauge
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.tiling import tile_yarns
from stitchmesh.yarn.yarn_presets import Yarn
from stitchmesh.yarngen import generate_yarns
from stitchmesh.yarngen.regenerate import regenerate_yarns
from stitchmesh.yarnrelax.model.upload import join_yarns
from tests.io.yarn_sets import ring
from tests.periodic.free_cells import FREE

TEX = 1e-5
"""Mass of a length of yarn of one tex (1 g/km) [g/cm]."""


def fabric_of(name: str) -> SwatchFabric:
    return SwatchFabric(yarn=YarnAndGauge(yarn=name))


def of_a_recipe(name: str) -> tuple[float | None, ...]:
    options = recipe_options(Recipe(mesh="hat.obj", yarn=name))
    return options.yarn_radius, options.drawn_radius, options.mass_per_length


def of_a_job(name: str) -> tuple[float | None, ...]:
    """A job has no names of yarns, but keys for what they state."""
    yarn = Yarn.named(name)
    table = {"yarn_radius": yarn.core_radius, "drawn_radius": yarn.apparent_radius,
             "mass_per_length": yarn.mass_per_length}  # fmt: skip
    options = recipe_options(recipe_of(job_of_table({"mesh": "hat.obj", "generate_yarns": table}, "job.toml")))
    return options.yarn_radius, options.drawn_radius, options.mass_per_length


def of_a_job_of_a_swatch(name: str) -> tuple[float | None, ...]:
    given = fabric_of(name).options(woven=False)
    names = ("yarn_radius", "drawn_radius", "mass_per_length")
    options = SwatchTable(pattern="stockinette", **{key: given[key] for key in names}).options()
    return options.yarn_radius, options.drawn_radius, options.mass_per_length


def of_a_swatch(name: str) -> tuple[float | None, ...]:
    options = SwatchOptions(**fabric_of(name).options(woven=False))
    return options.yarn_radius, options.drawn_radius, options.mass_per_length


def of_the_application(name: str) -> tuple[float | None, ...]:
    options = YarnSettings().knit_options(Yarn.named(name))
    return options.yarn_radius, options.drawn_radius, options.mass_per_length


WAYS: dict[str, Callable[[str], tuple[float | None, ...]]] = {
    "recipe": of_a_recipe, "job": of_a_job, "job of a swatch": of_a_job_of_a_swatch, "swatch": of_a_swatch,
    "application": of_the_application,
}  # fmt: skip


@pytest.mark.parametrize("way", WAYS)
def test_what_a_yarn_states_arrives(way):
    yarn = Yarn.named("aran")
    assert WAYS[way]("aran") == (yarn.core_radius, yarn.apparent_radius, yarn.grams_per_metre / 100.0)


def test_the_browser_designs_with_the_yarn_of_the_command():
    yarn = Yarn.named("aran")
    dials = SwatchDials(**SwatchCommand("stockinette", view=True, fabric=fabric_of("aran")).design_dials())
    design = SwatchDesign(read_pattern("stockinette"), dials)
    options = design.options()
    for name, own in (
        ("mass_per_length", yarn.mass_per_length), ("yarn_radius", yarn.core_radius), ("loop_length", yarn.loop_length),
    ):  # fmt: skip
        assert options[name] == pytest.approx(own, rel=5e-4)  # a dial has four digits
    assert yarn_of_dials(design) == yarn


def test_a_swatch_of_a_named_yarn_weighs_what_its_yarn_weighs():
    """100 g of worsted are 120 to 200 m, 625 tex."""
    tex = 625.0
    options = fabric_of("worsted").options(woven=False) | {"gamma": 1.3}
    made = sm.swatch("stockinette", quality="draft", device="cpu", progress=False, **options)
    metres = made.yarns.lengths.sum() / 100.0
    grams = metres * tex / 1000.0
    area = made.report["width"] * made.report["height"]
    assert made.report["areal_density"] * area == pytest.approx(grams, rel=1e-12)  # rounding of products
    assert made.yarns.mass_per_length == pytest.approx(tex * TEX, rel=1e-12)


def test_a_live_swatch_has_the_mass_of_its_dial():
    design = SwatchDesign(read_pattern("stockinette"), SwatchDials(mass=14.3, gamma=1.2, yarn_radius=0.1))
    with SwatchSession(**design.settings(), device="cpu") as session:
        frame = session.frame
    assert frame.yarns.mass_per_length == pytest.approx(143 * TEX, rel=1e-12)
    assert frame.measures.areal_density * np.prod(frame.size) == pytest.approx(frame.yarns.mass(np.nan), rel=1e-12)


def stating(*masses: float) -> YarnSet:
    curves = [ring([3.0 * place, 0.0, 0.0], count=12) for place in range(len(masses))]
    return replace(
        YarnSet.from_curves(curves, closed=[True] * len(masses), radius=0.1), mass_per_length=np.array(masses)
    )


def test_yarns_that_are_joined_tiled_or_scaled_keep_their_mass_and_thicker_threads_are_as_dense():
    options = SwatchOptions(yarn_radius=0.1, mass_per_length=0.003)
    assert options.stated_masses(np.array([0.1, 0.2])) == pytest.approx([0.003, 0.012], rel=1e-15)
    joined = join_yarns([stating(0.001, np.nan), stating(0.002)])
    np.testing.assert_array_equal(joined.mass_per_length, [0.001, np.nan, 0.002])
    prepared = prepare_swatch(
        "rib1x1", material=None, quality="draft", device="cpu", relax_cell=False, mass_per_length=0.002
    )
    cell = in_fabric(prepared.yarns, prepared.options)
    assert tile_yarns(cell, 2, 3).mass_per_length == pytest.approx(0.002, rel=1e-15)
    # all lengths twice as large, and the mass as before: exact powers of two
    larger = scale_yarns(cell, 2.0)
    assert larger.mass(np.nan) == pytest.approx(cell.mass(np.nan), rel=1e-14)
    assert (larger.mass_per_length == cell.mass_per_length / 2.0).all()


def test_the_smallest_cell_and_its_repeat_have_the_mass_of_their_yarns():
    prepared = prepare_swatch("stockinette", material=None, quality="draft", device="cpu", **FREE)
    repeat = replace(prepared.repeat, mass_per_length=np.full(prepared.repeat.yarn_count, 0.002))
    own: SmallestCell = prepared.smallest
    assert own.copies > 1
    part = own.part_of(repeat)
    assert (part.mass_per_length == 0.002).all()
    heavier = replace(part, mass_per_length=part.mass_per_length * 2.0)
    even = replace(heavier, rest_length=np.full(len(heavier.rest_length), heavier.rest_length.mean()))
    assert (own.repeated(even, repeat).mass_per_length == 0.004).all()


def test_yarns_of_an_edited_fabric_keep_the_mass(hat):
    relaxed = generate_yarns(hat, mass_per_length=0.002, quality="draft")
    generated, start = regenerate_yarns(relaxed, hat, hat, quality="draft")
    assert (generated.mass_per_length == 0.002).all() and (start.mass_per_length == 0.002).all()


@pytest.fixture(scope="module")
def hat() -> sm.StitchMesh:
    mesh = sm.read_mesh("assets/meshes/hat.obj", unit="cm")
    return sm.tessellate(sm.label(mesh), stitch_width=2.0)


def test_a_second_mass_is_refused():
    """A value that would have no effect."""
    with pytest.raises(ParameterError, match=r"stiffness mass_per_length: got one, and yarn that states a mass of"):
        RelaxOptions(stiffness={"mass_per_length": 0.01}).yarn_material(stating(0.002, np.nan))
    with pytest.raises(ParameterError, match="leave it out, or take yarn without a name"):
        MaterialSection(stiffness=("mass_per_length=0.01",)).yarn_material(0.1, 0.002)
    with pytest.raises(ParameterError, match="stiffness mass_per_length"):
        SwatchTable(pattern="rib1x1", stiffness=("mass_per_length=0.01",), mass_per_length=0.002).yarn_material()
    assert RelaxOptions(stiffness={"mass_per_length": 0.01}).yarn_material(stating(np.nan)).mass_per_length > 0.0


@pytest.mark.parametrize("mass", [0.0, np.inf])
def test_a_mass_is_positive_or_not_stated(mass):
    with pytest.raises(YarnError, match=r"mass_per_length 1: got .* g/cm; expected a positive number, or nan"):
        stating(0.1, mass)
