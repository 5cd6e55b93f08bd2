# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Budgets: their amounts as texts and as numbers, and those that no relaxation can keep."""

from __future__ import annotations

import pytest

from stitchmesh.budget.budget import Budget, parse_error, parse_time
from stitchmesh.errors import ParameterError


@pytest.mark.parametrize(
    ("amount", "seconds"),
    [("60 s", 60.0), ("60", 60.0), (0.5, 0.5), ("2min", 120.0), ("500ms", 0.5), (" 1.5 H ", 5400.0),
     ("6e1 sec", 60.0)],
)  # fmt: skip
def test_times(amount, seconds):
    assert parse_time(amount) == pytest.approx(seconds, rel=1e-15)


@pytest.mark.parametrize(
    ("amount", "part"), [("1%", 0.01), ("1 %", 0.01), ("0.01", 0.01), (0.01, 0.01), ("0.1%", 0.001)]
)
def test_errors(amount, part):
    assert parse_error(amount) == pytest.approx(part, rel=1e-15)


@pytest.mark.parametrize(
    ("amount", "said"),
    [("0s", "above zero"), ("-3s", "above zero"), ("nan", "finite"), ("inf", "finite"), (float("nan"), "finite"),
     ("1 day", "expected a time such as"), ("", "expected a time such as"), ("1.2.3s", "expected a time such as"),
     (True, "expected a time such as"), ("1ms", "the shortest is 0.1s")],
)  # fmt: skip
def test_times_that_cannot_be_kept(amount, said):
    with pytest.raises(ParameterError, match=said) as raised:
        parse_time(amount)
    assert str(raised.value).startswith("within: ") and "\n" not in str(raised.value)


@pytest.mark.parametrize(
    ("amount", "said"),
    [("0", "above zero"), ("-1%", "above zero"), ("nan", "above zero"), ("nan%", "above zero"),
     ("inf", "expected at most 50%"), ("60%", "got 60%; expected at most"),
     ("100%", "got 100%; expected"), ("5", "5 % is written 5%"),
     ("1e-9", "ask for that"), ("1e-9%", "ask for that"), ("small", "expected an error such as"),
     ("1s", "expected an error such as")],
)  # fmt: skip
def test_errors_that_cannot_be_kept(amount, said):
    with pytest.raises(ParameterError, match=said) as raised:
        parse_error(amount)
    assert str(raised.value).startswith("error: ") and "\n" not in str(raised.value)


def test_a_budget_needs_a_time_or_an_error():
    assert Budget.of() is None
    assert Budget.of("2min", "1%") == Budget(within=120.0, error=0.01)
    with pytest.raises(ParameterError, match="neither"):
        Budget()


def test_an_error_chooses_the_quality_so_that_none_is_kept():
    with pytest.raises(ParameterError, match="leave one out"):
        Budget(error=0.01, chooses=False)
    assert Budget(within=1.0, chooses=False).error is None
