# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Public functions are short enough to be held in mind."""

from __future__ import annotations

import inspect

import stitchmesh as sm

MOST = 8
"""Largest number of parameters of a public function."""
LONGER = {
    "relax_edited": 9,
}
"""Functions that take more. None may join, and none may grow."""


def test_public_functions_take_at_most_eight_parameters():
    functions = {name: getattr(sm, name) for name in sm.__all__ if inspect.isfunction(getattr(sm, name))}
    counts = {name: len(inspect.signature(function).parameters) for name, function in functions.items()}
    assert {name: count for name, count in counts.items() if count > LONGER.get(name, MOST)} == {}
