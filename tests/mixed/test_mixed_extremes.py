# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Some extreme scenes of docs/stability.md end finite and valid, or with one line; the night has all of them."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.extremes.cloths import cases, outcome, row_of
from tests.extremes.outcome import FAILED, REFUSED, VALID

VALID_CASES = ("stiffness of triangles x 0.0001", "region: two at one vertex", "a knit with yarns on one triangle")
CASES = {case.name: case for case in cases()}


@pytest.mark.parametrize("name", VALID_CASES)
def test_an_extreme_is_finite_and_valid(name):
    found = outcome(CASES[name], "cpu")
    assert (found.kind, found.words) == (VALID, "")


def test_an_extreme_is_refused_in_one_line():
    found = outcome(CASES["dragged through a ball"], "cpu")
    assert found.kind == REFUSED
    assert "contact points, the deepest at node" in found.words


def test_other_exceptions_are_failures():
    def broken():
        raise ZeroDivisionError("here")

    found = outcome(replace(next(iter(CASES.values())), make=broken), "cpu")
    assert (found.kind, found.words) == (FAILED, "ZeroDivisionError: here")
    assert row_of(next(iter(CASES.values())), found)[1] == "FAILED: ZeroDivisionError: here"
