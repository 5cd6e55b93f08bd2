# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Many swatches are those that ``swatch`` makes, and one that cannot be made does not end the others."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import stitchmesh as sm
from stitchmesh.errors import FileError, ParameterError
from stitchmesh.yarnrelax import YarnMaterial
from stitchmesh.yarnrelax.together import relax_together
from stitchmesh.yarnrelax.together.cell_batch import CellBatch

DRAFT: dict[str, Any] = {"quality": "draft", "relax_cell": True}
STATE = {"relaxation": "frictionless"}
FREE = [
    sm.SwatchRequest("stockinette", **DRAFT, options=STATE),
    sm.SwatchRequest("stockinette", material=YarnMaterial.named("leaf"), **DRAFT, options=STATE | {"gamma": 1.1}),
    sm.SwatchRequest("plain", **DRAFT, options=STATE),
]


def alone(request: sm.SwatchRequest) -> sm.Swatch:
    return sm.swatch(
        request.pattern, material=request.material, quality=request.quality, relax_cell=request.relax_cell,
        device="cpu", progress=False, **request.options,
    )  # fmt: skip


def points_of(made: object) -> np.ndarray:
    assert isinstance(made, sm.Swatch)
    return made.yarns.points


@pytest.fixture
def together(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let all relaxations be done together on the CPU too, as on a GPU."""
    monkeypatch.setattr(relax_together, "_on_a_gpu", lambda group_of: group_of)


@pytest.mark.usefixtures("together")
def test_swatches_are_those_of_swatch(monkeypatch: pytest.MonkeyPatch) -> None:
    cells = list[int]()
    relax_batch = relax_together.relax_batch

    def counted(batch: CellBatch, *others: Any, **named: Any) -> Any:
        cells.append(len(batch.given))
        return relax_batch(batch, *others, **named)

    monkeypatch.setattr(relax_together, "relax_batch", counted)
    for request, made in zip(FREE[:2], sm.relax_swatches(FREE[:2], device="cpu", progress=False), strict=True):
        one = alone(request)
        assert isinstance(made, sm.Swatch) and made.report.keys() == one.report.keys()
        assert made.report["converged"] and made.report["starts"] == one.report["starts"] == 5
        assert made.report["pull_throughs"] == 0
        assert len(made.history) > 1 and made.history[0]["iteration"] == 0
        np.testing.assert_array_equal(points_of(made), one.yarns.points)
        for name in ("energy", "width", "height", "thickness"):
            assert made.report[name] == one.report[name]
    assert {2, 8} <= set(cells), "both swatches, and all their displaced starts, are relaxed in one batch each"


@pytest.mark.usefixtures("first_state", "together")
def test_the_bits_of_a_swatch_depend_on_no_other_swatch_of_the_call() -> None:
    every = sm.relax_swatches(FREE, device="cpu", progress=False)
    some = sm.relax_swatches([FREE[2], FREE[0]], device="cpu", progress=False)
    for number, made in zip((2, 0), some, strict=True):
        np.testing.assert_array_equal(points_of(made), points_of(every[number]))
    for request, made in zip(FREE, every, strict=True):
        np.testing.assert_array_equal(points_of(made), alone(request).yarns.points)


@pytest.mark.gpu
def test_stiff_ribs_with_friction_have_the_same_bits_in_all_cells_of_a_gpu() -> None:
    """Their size changes so much that their near lists are made with several reaches, by several captured searches."""
    yarn = sm.Yarn.named("dk")
    options = {"relaxation": "dry", "loop_length": yarn.loop_length, "yarn_radius": yarn.core_radius}
    request = sm.SwatchRequest("rib1x1", material=YarnMaterial.of_yarn(yarn), **DRAFT, options=options)
    first, *others = sm.relax_swatches([request] * 4, device="cuda:0", progress=False)
    for made in others:
        np.testing.assert_array_equal(points_of(made), points_of(first))


@pytest.mark.parametrize("way", ["together", "as on a CPU"])
def test_an_error_is_in_the_place_of_a_swatch_that_cannot_be_made(way: str, request: pytest.FixtureRequest) -> None:
    if way == "together":
        request.getfixturevalue("together")
    requests = [
        sm.SwatchRequest("stockinette", quality="draft"),
        sm.SwatchRequest("stockinette", quality="draft", options={"gamma": -1.0}),
        sm.SwatchRequest("no/such/pattern.txt"),
        sm.SwatchRequest("stockinette", quality="draft", material=replace(YarnMaterial.named(), k_bend=1e30)),
        sm.SwatchRequest("stockinette", quality="draft", options={"gamma": 1.1}),
    ]
    told = list[tuple[int, int]]()
    first, refused, missing, stiff, last = sm.relax_swatches(requests, device="cpu", progress=lambda *d: told.append(d))
    assert told == [(1, 5), (2, 5), (3, 5), (4, 5), (5, 5)]
    assert isinstance(refused, ParameterError) and "gamma" in str(refused)
    assert isinstance(missing, FileError)
    assert isinstance(stiff, ParameterError) and "k_bend" in str(stiff), "refused when all cells are put on the device"
    assert all(isinstance(made, sm.Swatch) and made.report["converged"] for made in (first, last))
