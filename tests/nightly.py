# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Cases of a test that repeat what its other cases prove, and that only ``make test-nightly`` runs."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import Any

import pytest


def at_night(*cases: Any) -> list[Any]:
    """Mark cases of ``parametrize`` as ``nightly``; a tuple holds the values of several parameters."""
    return [
        pytest.param(*(case if isinstance(case, tuple) else (case,)), marks=pytest.mark.nightly) for case in cases
    ]


def mostly_at_night(cases: Iterable[Any], *, by_day: Collection[Any]) -> list[Any]:
    """Mark all but the cases of ``by_day`` as ``nightly``."""
    return [case if case in by_day else at_night(case)[0] for case in cases]
