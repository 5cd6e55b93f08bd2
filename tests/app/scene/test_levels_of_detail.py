# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What is sent of yarns: everything once, afterwards what changed."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from stitchmesh.app.scene.drawing import YarnTubes
from stitchmesh.app.scene.levels_of_detail import LEVELS, add_tubes, update_tubes
from stitchmesh.errors import ParameterError
from stitchmesh.render.yarn_blocks import make_blocks
from tests.yarnrelax.stockinette import tube


class Carrier:
    """A mesh of a scene that remembers the properties that it was given."""

    def __init__(self) -> None:
        self.properties: dict[str, Any] = {}

    def _queue_update(self, name: str, value: Any) -> None:
        self.properties[name] = value


class Scene:
    """A scene of viser that adds carriers."""

    def add_mesh_simple(self, *arguments: Any, **options: Any) -> Carrier:
        return Carrier()


def tubes() -> YarnTubes:
    yarns = tube(6, 20)
    return YarnTubes(make_blocks(yarns), yarns.points, np.full((len(yarns.points), 3), 7, dtype=np.uint8))


def test_everything_that_the_page_needs_is_sent_at_first():
    drawing = tubes()
    sent = add_tubes(Scene(), "/yarns", drawing).properties
    stored = len(drawing.blocks.source)
    assert len(sent["yarn_points"]) == 3 * stored and sent["yarn_points"].dtype == np.uint16
    assert len(sent["yarn_index"]) == stored and sent["yarn_index"].dtype == np.uint8
    blocks = len(sent["yarn_blocks"]) - 1
    assert len(sent["yarn_low"]) == len(sent["yarn_step"]) == 3 * blocks
    assert sent["yarn_runs"][-1] == stored and sent["yarn_blocks"][-1] == len(sent["yarn_radius"])
    assert len(sent["yarn_levels"]) == 4 * len(LEVELS) and len(sent["yarn_copies"]) == 3
    # a page keeps no array of another type than these
    kinds = {value.dtype for value in sent.values() if isinstance(value, np.ndarray)}
    assert kinds == {np.dtype(name) for name in ("uint8", "uint16", "uint32", "float32")}


def test_a_frame_sends_positions_only_and_colours_send_colours_only():
    before, carrier = tubes(), Carrier()
    assert update_tubes(carrier, before, replace(before, points=before.points + 1.0))
    assert set(carrier.properties) == {"yarn_points", "yarn_low", "yarn_step"}
    carrier = Carrier()
    assert update_tubes(carrier, before, replace(before, colours=before.colours + 1))
    assert set(carrier.properties) == {"yarn_index", "yarn_palette"}
    carrier = Carrier()
    assert update_tubes(carrier, before, replace(before, copies=np.eye(3)))
    assert set(carrier.properties) == {"yarn_copies"}
    carrier = Carrier()
    assert update_tubes(carrier, before, replace(before)) and not carrier.properties


def test_other_blocks_need_everything_anew():
    before, carrier = tubes(), Carrier()
    assert not update_tubes(carrier, before, tubes()) and not carrier.properties


def test_drawings_that_contradict_themselves_are_refused():
    drawing = tubes()
    with pytest.raises(ParameterError, match=r"tubes: got colours \(5, 3\) for points"):
        replace(drawing, colours=drawing.colours[:5])
    with pytest.raises(ParameterError, match=r"tubes: got copies of shape \(3,\); expected \(n, 3\)"):
        replace(drawing, copies=np.zeros(3))
