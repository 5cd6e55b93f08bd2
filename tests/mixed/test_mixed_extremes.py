# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Extreme scenes end finite and valid, or with one line of error; docs/stability.md has all of them."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.extremes.cloths import cases, outcome, row_of
from tests.extremes.outcome import FAILED, REFUSED, VALID
from tests.nightly import mostly_at_night

VALID_CASES = [
    "mass of triangles x 1e-06",
    "mass of triangles x 1e+06",
    "stiffness of triangles x 0.0001",
    "smallest alpha 0.001",
    "smallest alpha 1",
    "time step 1e-06 s",
    "time step 0.01 s",
    "region: one triangle inside",
    "region: two that meet",
    "region: two at one vertex",
    "region: rings beyond the cloth",
    "region: at a seam",
    "0.7 yarns for each cm",
    "drawn over a ball",
    "a knit with yarns on one triangle",
]
REFUSED_CASES = {
    "dragged through a ball": "contact points, the deepest at node",
    "more yarns than memory": "expected fewer yarns for each cm, or a smaller cloth, for at most",
    "a larger region than memory": "expected a region of at most",
    "region outside of the cloth": "holds no triangle of the cloth",
    "a panel that crosses itself": "cross or touch",
}
CASES = {case.name: case for case in cases()}


@pytest.mark.parametrize("name", mostly_at_night(VALID_CASES, by_day=VALID_CASES[::3]))
def test_an_extreme_is_finite_and_valid(name):
    found = outcome(CASES[name], "cpu")
    assert (found.kind, found.words) == (VALID, "")


@pytest.mark.parametrize("name", REFUSED_CASES)
def test_an_extreme_is_refused_in_one_line(name):
    found = outcome(CASES[name], "cpu")
    assert found.kind == REFUSED
    assert REFUSED_CASES[name] in found.words


def test_other_exceptions_are_failures():
    def broken():
        raise ZeroDivisionError("here")

    found = outcome(replace(next(iter(CASES.values())), make=broken), "cpu")
    assert (found.kind, found.words) == (FAILED, "ZeroDivisionError: here")
    assert row_of(next(iter(CASES.values())), found)[1] == "FAILED: ZeroDivisionError: here"
