# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Designs of swatches: dials that act, the settings of a session, and designs as JSON."""

from __future__ import annotations

import json
from dataclasses import fields, replace

import pytest

import stitchmesh as sm
from stitchmesh.errors import ParameterError, PatternError
from stitchmesh.periodic.repeat.drawn_swatch import draw_swatch
from stitchmesh.periodic.swatch_design import (
    FACTORS,
    SwatchDesign,
    SwatchDials,
    acting_dials,
    design_table,
    read_design,
)
from stitchmesh.periodic.swatch_options import SwatchOptions
from stitchmesh.quality import PRESETS
from stitchmesh.yarn.rest_length import RestLengths, apply_rest_lengths

EXAMPLES = ("honeycomb", "peerie", "half-cardigan", "double-plain-stitched")
"""Patterns with slipped stitches, floats, tucks, and warps and wefts in two layers."""


@pytest.mark.parametrize("name", EXAMPLES)
def test_a_factor_acts_exactly_where_the_yarns_accept_it(name):
    source = sm.resolve_pattern(name)
    fabric, yarns = draw_swatch(source, SwatchOptions(longest_float=40), PRESETS["draft"])
    accepted = set()
    for factor in FACTORS:
        try:
            apply_rest_lengths(yarns, RestLengths(**{factor: 0.9}), fabric=fabric)
        except ParameterError:
            continue
        accepted.add(factor)
    assert acting_dials(source) & set(FACTORS) == accepted


@pytest.mark.parametrize("name", ["honeycomb", "twill-2x1"])
def test_every_dial_can_be_turned_for_every_pattern(name):
    """Dials without effect are left out of the settings, so that a session accepts any design."""
    turned = {"floats": 0.9, "held": 0.8, "warp": 1.1, "weft": 0.9, "k_bend": 2.0, "loop_length": 4.0, "columns": 1}
    design = SwatchDesign(sm.resolve_pattern(name)).turned(**turned)
    with sm.SwatchSession("stockinette", device="cpu", stopped=True) as session:
        session.set(**design.settings())
        assert session.step(timeout=60.0).report["iteration"] > 0


def test_settings_of_the_first_design_are_the_defaults_of_a_swatch():
    """Except for the mass of the yarn, which is that of the material and which a design states, and longer floats."""
    options = SwatchDesign(sm.resolve_pattern("stockinette")).options()
    own = ("material", "longest_float", "loop_length", "mass_per_length")
    given = {name: value for name, value in options.items() if name not in own}
    assert SwatchOptions(**given) == SwatchOptions()
    assert options["material"] == sm.YarnMaterial.named()
    assert options["mass_per_length"] == options["material"].mass_per_length
    plain = draw_swatch(sm.resolve_pattern("stockinette"), SwatchOptions(), PRESETS["draft"])[1]
    same = draw_swatch(
        sm.resolve_pattern("stockinette"), SwatchOptions(loop_length=options["loop_length"]), PRESETS["draft"]
    )[1]
    assert (plain.points == same.points).all()


@pytest.mark.parametrize("name", ["peerie", "twill-2x1"])
def test_a_design_comes_back_from_json(name):
    source = replace(sm.resolve_pattern(name), palette=((1, 2, 3), (250, 128, 0)))
    design = SwatchDesign(source, quality="standard").turned(gamma=1.25, width=3.5, mass=33.0)
    assert read_design(json.loads(json.dumps(design_table(design)))) == design


def test_an_old_design_without_some_dials_has_their_defaults():
    table = design_table(SwatchDesign(sm.resolve_pattern("rib2x2")))
    table["dials"] = {"gamma": 1.5}
    assert read_design(table).dials == SwatchDials(gamma=1.5)


@pytest.mark.parametrize(
    ("change", "error", "message"),
    [
        ({"dials": {"gama": 1.0}}, ParameterError, "did you mean 'gamma'"),
        ({"dials": {"gamma": 99.0}}, ParameterError, "gamma: got 99.0; expected 0.1 to 10"),
        ({"dials": {"held": "a"}}, ParameterError, "expected a number"),
        ({"quality": "best"}, ParameterError, "quality: got 'best'"),
        ({"text": "round 1: k1 z2"}, PatternError, "line 1"),
    ],
    ids=["unknown dial", "out of bounds", "no number", "quality", "text"],
)
def test_a_damaged_table_is_refused(change, error, message):
    table = design_table(SwatchDesign(sm.resolve_pattern("rib2x2"))) | change
    with pytest.raises(error, match=message):
        read_design(table)


@pytest.mark.parametrize("value", [float("nan"), 0.0, 10**400])  # the last one is no float
def test_numbers_out_of_bounds_are_refused(value):
    for dial in (field.name for field in fields(SwatchDials)):
        with pytest.raises(ParameterError, match=f"{dial.replace('_', ' ')}: got .*; expected"):
            SwatchDials(**{dial: value})
