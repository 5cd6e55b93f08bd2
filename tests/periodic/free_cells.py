# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Repeats of the library: as drawn, and as swatches that find their size without friction.

Without friction the state of rest does not depend on a path. Tests whose facts hold in every state of rest relax from
the generated yarns alone, without the search for the lowest of several states, which takes five times as long. The
search has tests of its own (``relaxation/test_lowest_rest.py``), and each kind of fabric is relaxed with it in at least
one test.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any

import numpy as np
import pytest

import stitchmesh as sm
from stitchmesh.periodic.relaxation import lowest_rest
from stitchmesh.periodic.repeat.drawn_swatch import draw_swatch
from stitchmesh.periodic.resolve_pattern import resolve_pattern
from stitchmesh.periodic.swatch_options import SwatchOptions
from stitchmesh.quality import quality_named
from stitchmesh.yarn import YarnSet

FREE: dict[str, Any] = {"relax_cell": True, "relaxation": "frictionless"}
"""The arguments of ``swatch`` for a free cell without friction."""


@contextmanager
def from_generated_yarns() -> Iterator[None]:
    """Let repeats come to rest from the generated yarns alone."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(lowest_rest, "STARTS", 0)
        yield


@cache
def free_swatch(pattern: str, quality: str = "draft") -> sm.Swatch:
    """Return a swatch of the library that comes to rest from the generated yarns; all tests share it."""
    with from_generated_yarns():
        return sm.swatch(pattern, quality=quality, device="cpu", progress=False, **FREE)


def drawn(pattern: str, quality: str | sm.Quality = "draft") -> YarnSet:
    """Return the yarns of a repeat before they relax."""
    return draw_swatch(resolve_pattern(pattern), SwatchOptions(), quality_named(quality))[1]


def yarn_lengths(yarns: YarnSet) -> np.ndarray:
    """Return the rest length of each yarn [cm]."""
    return np.add.reduceat(yarns.rest_length, yarns.segment_start[:-1])
