# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Functions that launch kernels exclude each other, in whichever threads they are called."""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest

from stitchmesh.compute import device
from stitchmesh.compute.device import alone, others_may_launch
from stitchmesh.errors import MeshError
from stitchmesh.linking.certificate import doubled_linking, linking_certificate, refuse_pull_through
from stitchmesh.linking.polygon_linking import linking_numbers
from stitchmesh.meshrelax import relax_mesh
from stitchmesh.patterns import read_pattern
from stitchmesh.periodic.repeat.torus import torus_mesh
from stitchmesh.periodic.weave.library import read_weave
from stitchmesh.periodic.weave.yarns import weave_yarns
from stitchmesh.quality import PRESETS
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import RelaxCell, YarnMaterial, relax_yarns, yarn_energies, yarn_forces
from stitchmesh.yarnrelax.cell_stress import cell_stress
from stitchmesh.yarnrelax.relax import relax_partly
from stitchmesh.yarnrelax.together.relax_cells import relax_cells
from tests.nightly import mostly_at_night

SAFETY = 120.0  # Time after which a test that blocks fails [s]; a test that passes waits for a much shorter time.
RADIUS = 0.125
MATERIAL = YarnMaterial.named("kaldor-simulation")
CPU: dict[str, Any] = {"device": "cpu"}


def woven(name: str) -> YarnSet:
    return weave_yarns(read_weave(name), yarn_radius=RADIUS, quality="draft")


def refused_mesh() -> None:
    """Relax a mesh that is not valid; the error is raised while the thread has the access."""
    fabric = torus_mesh(read_pattern("stockinette"), stitch_width=1.0, stitch_height=0.8)
    with suppress(MeshError):
        relax_mesh(fabric, surface=fabric)


PLAIN = woven("plain")
CALLS: dict[str, Callable[[], Any]] = {
    "relax_yarns": partial(relax_yarns, PLAIN, quality="draft", **CPU),
    "settled_yarns": partial(relax_partly, PLAIN, material=MATERIAL, quality=PRESETS["draft"], iterations=20, **CPU),
    "refuse_pull_through": partial(refuse_pull_through, PLAIN, PLAIN, **CPU),
    "relax_cells": partial(relax_cells, [PLAIN], quality="draft", **CPU),
    "cell_stress": partial(cell_stress, PLAIN, MATERIAL, **CPU),
    "yarn_energies": partial(yarn_energies, PLAIN, MATERIAL, **CPU),
    "yarn_forces": partial(yarn_forces, PLAIN, MATERIAL, **CPU),
    "doubled_linking": partial(doubled_linking, PLAIN, **CPU),
    "linking_certificate": partial(linking_certificate, PLAIN, **CPU),
    "relax_mesh": refused_mesh,
    "linking_numbers": partial(linking_numbers, np.eye(3), [range(3)]),
}


@pytest.mark.parametrize("name", mostly_at_night(CALLS, by_day=[*CALLS][::3]))
def test_functions_that_launch_kernels_wait_for_the_access(name: str) -> None:
    thread = threading.Thread(target=CALLS[name])
    with alone():
        thread.start()
        while thread.is_alive() and len(device._queue) < 2:
            pass
        assert thread.is_alive()
    thread.join(SAFETY)
    assert not thread.is_alive() and not device._queue


def test_a_call_that_fails_releases_the_access() -> None:
    with pytest.raises(TypeError):
        doubled_linking()  # type: ignore[call-arg]
    assert not device._queue


def test_relaxations_in_two_threads_give_the_same_bits_as_one_after_another() -> None:
    cells = [woven(name) for name in ("plain", "twill-2x1")]
    brief = replace(PRESETS["draft"], max_iterations=60)
    found: list[YarnSet | None] = [None] * len(cells)

    def relax(number: int) -> None:
        cell = RelaxCell(shear=False)
        found[number] = relax_yarns(cells[number], quality=brief, cell=cell, **CPU).yarns

    threads = [threading.Thread(target=relax, args=[number]) for number in range(len(cells))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(SAFETY)
    together = [yarns.points for yarns in found if yarns is not None]
    for number in range(len(cells)):
        relax(number)
    singly = [yarns.points for yarns in found if yarns is not None]
    assert len(together) == len(singly) == len(cells)
    assert all(np.array_equal(*pair) for pair in zip(together, singly, strict=True))


def test_threads_launch_in_the_order_of_their_requests() -> None:
    turns: list[int] = []

    def take_turn(number: int) -> None:
        with alone():
            turns.append(number)

    threads = [threading.Thread(target=take_turn, args=[number]) for number in range(8)]
    with alone(), alone():  # a thread may enter again during its own turn
        for count, thread in enumerate(threads, start=2):
            thread.start()
            while len(device._queue) < count:
                pass
        assert turns == []
    for thread in threads:
        thread.join(SAFETY)
    assert turns == list(range(8))


def test_a_thread_that_waits_lets_others_launch_and_takes_its_access_again() -> None:
    order: list[str] = []

    def other() -> None:
        with alone():
            order.append("other")

    thread = threading.Thread(target=other)
    with alone():
        thread.start()
        while len(device._queue) < 2:
            pass
        with others_may_launch():
            thread.join(SAFETY)
        order.append("own")
        assert device._queue[0] == threading.get_ident()
    assert order == ["other", "own"] and not device._queue


def test_an_interrupt_while_a_thread_waits_for_its_access_is_raised_once_it_has_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    own = threading.get_ident()
    waits: list[int] = []

    def interrupted(_seconds: float | None = None) -> None:
        waits.append(1)
        device._queue.remove(-1)  # the other thread is done
        raise KeyboardInterrupt

    def leave() -> None:
        with alone(), others_may_launch():
            monkeypatch.setattr(device._turn, "wait", interrupted)
            device._queue.append(-1)

    with pytest.raises(KeyboardInterrupt):
        leave()
    assert waits == [1] and own not in device._queue
