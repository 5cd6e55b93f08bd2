# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Materials: their names, and single values that are changed."""

from __future__ import annotations

from dataclasses import replace

import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.yarnrelax import YarnMaterial
from stitchmesh.yarnrelax.model.material import REFERENCE_RADIUS, parse_stiffnesses, stiffness_names


def test_a_changed_value_scales_as_the_value_of_the_material_does():
    """L section 6.2, eq 4: the ratio of the two values does not depend on the scale."""
    plain, soft = YarnMaterial.named("leaf"), YarnMaterial.named("leaf", {"k_bend": 2.5})
    for name in stiffness_names():
        if getattr(plain, name) is None:
            continue  # It follows from another value.
        ratio = 0.5 if name == "k_bend" else 1.0
        assert getattr(soft, name) == ratio * getattr(plain, name)
        before, after = (getattr(material.scaled(0.5), name) for material in (plain, soft))
        assert after == ratio * before  # The factors 0.5 are exact.


def test_yarn_of_another_radius_is_as_dense_and_as_stiff_for_its_size():
    """Twice the radius: four times the mass of a length, and the stiffnesses of the similarity (L section 6.2)."""
    plain = YarnMaterial.named()
    thick = plain.of_radius(2.0 * REFERENCE_RADIUS)
    assert thick.mass_per_length == 4.0 * plain.mass_per_length  # exact powers of two
    assert replace(thick, mass_per_length=0.0) == replace(plain.scaled(2.0), mass_per_length=0.0)
    assert plain.of_radius(REFERENCE_RADIUS) == plain
    with pytest.raises(ParameterError, match="material: yarn radius: got -1"):
        plain.of_radius(-1.0)


def test_values_are_parsed_as_a_user_writes_them():
    assert parse_stiffnesses(["k_bend=2.5", " k_len = 1e3 "]) == {"k_bend": 2.5, "k_len": 1000.0}


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["k_bent=2"], "stiffness 'k_bent': is no value of a material; expected k_bend"),
        (["colour=2"], "expected one of k_len, k_length, k_bend, k_contact"),
        (["k_bend"], "got 'k_bend'; expected NAME=VALUE"),
        (["k_bend=soft"], "stiffness k_bend: got 'soft'; expected a number"),
        (["k_bend=1", "k_bend=2"], "stiffness k_bend: is given twice"),
    ],
)
def test_a_malformed_value_is_refused(words, message):
    with pytest.raises(ParameterError, match=message):
        parse_stiffnesses(words)


def test_unknown_names_and_bad_values_are_refused():
    with pytest.raises(ParameterError, match="got 'leaff'; expected leaf"):
        YarnMaterial.named("leaff")
    with pytest.raises(ParameterError, match="stiffness 'bend': is no value of a material; expected k_bend"):
        YarnMaterial.named("leaf", {"bend": 1.0})
    with pytest.raises(ParameterError, match=r"k_bend is -1; expected a number from 0"):
        YarnMaterial.named("leaf", {"k_bend": -1.0})
