# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Thousands of random edits of all garments: every result is a valid fabric, every edit can be undone exactly."""

from __future__ import annotations

from collections import Counter
from functools import cache
from random import Random

import pytest

from stitchmesh.editing.edit import EDITS
from stitchmesh.editing.history import History, replay_edits
from stitchmesh.errors import StitchMeshError
from stitchmesh.io import read_mesh
from stitchmesh.labeling import label
from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.tessellate import tessellate
from stitchmesh.yarngen.generate import checked_radius, trace_yarn_routes
from tests.editing.random_edits import arrays_of, bits, random_edit
from tests.gallery import GARMENTS
from tests.nightly import mostly_at_night

WIDTH = {"dress": 5.0, "glove": 1.2, "poncho": 6.0, "sock": 1.6, "swatch": 1.0, "sweater": 4.5}
"""Stitch widths [cm] that give garments of a few hundred stitches; 2 cm for all other garments."""
TRIED = 240
"""Number of edits tried on each garment; about two of three are possible."""


@cache
def coarse(name: str) -> StitchMesh:
    path = next(path for path in GARMENTS if path.stem == name)
    return tessellate(label(read_mesh(path, unit="cm")), stitch_width=WIDTH.get(name, 2.0))


def edited(name: str, seed: int, count: int, check_every: int = 10**9) -> tuple[History, Counter[str]]:
    random, history, done = Random(seed), History(coarse(name)), Counter()
    for number in range(count):
        edit = random_edit(random, history.fabric)
        before = history.fabric
        try:
            history.apply(edit)
        except StitchMeshError as refusal:
            assert "\n" not in str(refusal)
            assert history.fabric is before
            continue
        done[edit.name] += 1
        if number % check_every == 0:
            StitchMesh(**arrays_of(history.fabric))
    return history, done


@pytest.mark.parametrize("name", mostly_at_night([path.stem for path in GARMENTS], by_day=("hat",)))
def test_every_edit_gives_a_valid_fabric_and_can_be_undone_redone_and_replayed(name, tmp_path):
    history, done = edited(name, seed=len(name), count=TRIED, check_every=10)
    assert sum(done.values()) > TRIED / 2 and len(done) > len(EDITS) / 2
    start, end, count = bits(coarse(name)), bits(history.fabric), len(history.edits)
    StitchMesh(**arrays_of(history.fabric))
    history.write(tmp_path / "log.jsonl")
    for _ in range(count):
        history.undo()
    assert bits(history.fabric) == start
    for _ in range(count):
        history.redo()
    assert bits(history.fabric) == end
    assert bits(replay_edits(coarse(name), tmp_path / "log.jsonl")) == end


@pytest.mark.parametrize("name", mostly_at_night([path.stem for path in GARMENTS], by_day=("hat",)))
def test_edited_fabrics_have_yarns(name):
    """Every loop is worked, and every yarn end joins one other end or is tied off; ``link_ends`` checks this."""
    fabric = edited(name, seed=3, count=60)[0].fabric
    routes = trace_yarn_routes(fabric, checked_radius(fabric, None), 4)
    used = [entry // 2 for entries, _ in routes.yarns for entry in entries]
    assert sorted(used) == list(range(len(routes.parts.face)))
    assert (fabric.stitch != Stitch.PANEL).all()
