# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The spread of a size over starts with the noise of a real yarn."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

import stitchmesh as sm
from stitchmesh.cli.summary import swatch_summary
from stitchmesh.errors import ParameterError
from stitchmesh.periodic.relaxation.continuation import size_of
from stitchmesh.periodic.swatch import NOISE, shaken_yarns
from stitchmesh.quality import PRESETS
from stitchmesh.yarnrelax.together import relax_together
from tests.periodic.free_cells import FREE

pytestmark = pytest.mark.usefixtures("first_state")
GIVEN: dict[str, Any] = {"quality": "draft"} | FREE


@cache
def made(**options: Any) -> sm.Swatch:
    return sm.swatch("stockinette", device="cpu", progress=False, **GIVEN | options)


def test_the_spread_is_that_of_the_sizes_of_all_starts() -> None:
    """The size itself is that without shaken starts, and the spread of stockinette is below a hundredth."""
    alone, spread = made(), made(shaken=1)
    assert size_of(spread.lattice) == size_of(alone.lattice)
    assert 0.0 < max(spread.report["size_spread"]) < 0.01
    assert "size_spread" not in alone.report
    lines = swatch_summary(spread, "stockinette", None)
    assert any(line.startswith("Spread: widths differ by ") for line in lines)
    assert not any(line.startswith("Spread") for line in swatch_summary(alone, "stockinette", None))


@pytest.mark.nightly
def test_swatches_that_are_made_together_have_shaken_starts_too(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(relax_together, "_on_a_gpu", lambda group_of: group_of)
    # with the friction that a knit has where nothing else is asked for
    request = sm.SwatchRequest("stockinette", quality="draft", relax_cell=True, shaken=2)
    (together,) = sm.relax_swatches([request], device="cpu", progress=False)
    assert isinstance(together, sm.Swatch)
    assert together.report["shaken_at_rest"] == 2


def test_a_swatch_that_is_not_at_rest_has_no_spread() -> None:
    quality = replace(PRESETS["draft"], max_iterations=1)
    report = made(shaken=1, quality=quality).report
    assert not report["converged"] and report["size_spread"] is None


def test_noise_has_the_stated_size_and_is_another_one_for_each_start() -> None:
    yarns = made().yarns
    first, second = (shaken_yarns(yarns, number).points - yarns.points for number in (0, 1))
    assert first.std() / yarns.radius[0] == pytest.approx(NOISE, rel=0.2)  # about 100 numbers: 7 %
    assert not np.allclose(first, second)
    np.testing.assert_array_equal(shaken_yarns(yarns, 1).points - yarns.points, second)


@pytest.mark.parametrize("starts", [-1, 10**9])
def test_numbers_of_starts_that_are_not_possible_are_refused(starts: int) -> None:
    with pytest.raises(ParameterError, match=r"got -1 starts|states of 16 control points"):
        made(shaken=starts)
