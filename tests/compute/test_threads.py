# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The number of threads: what is given last counts, and what cannot be is refused or replaced."""

from __future__ import annotations

import logging
from pathlib import Path

import pytest

from stitchmesh.compute import threads
from stitchmesh.compute.threads import VARIABLE, core_count, each_block, set_threads, thread_count
from stitchmesh.errors import ParameterError


@pytest.fixture(autouse=True)
def four_cores(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(threads, "_choice", threads._Choice())
    monkeypatch.setattr(threads, "core_count", lambda: 4)
    monkeypatch.delenv(VARIABLE, raising=False)


def test_a_given_number_precedes_the_environment_variable_and_this_precedes_all_cores(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert thread_count() == 4
    monkeypatch.setenv(VARIABLE, "3")
    set_threads(2)
    assert thread_count() == 2
    set_threads(None)
    assert thread_count() == 3


@pytest.mark.parametrize("number", [0, -2, 1.5, "two"])
def test_a_number_below_one_or_not_whole_is_refused(number: int) -> None:
    with pytest.raises(ParameterError, match=r"^threads: got .*; expected a whole number of at least 1$"):
        set_threads(number)
    assert thread_count() == 4


def test_a_bad_environment_variable_is_refused_by_its_name(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, "0")
    with pytest.raises(ParameterError, match=f"^{VARIABLE}: got '0'"):
        thread_count()


def test_more_threads_than_cores_become_the_cores_and_this_is_said(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING):
        set_threads(99)
    assert thread_count() == 4
    assert [record.getMessage() for record in caplog.records] == [
        "threads: got 99, but this process may use 4 cores; 4 are taken"
    ]


@pytest.mark.parametrize(("quota", "cores"), [("150000 100000", 2), ("max 100000", 64), ("20000 100000", 1), ("", 64)])
def test_the_quota_of_a_container_limits_the_cores(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, quota: str, cores: int
) -> None:
    (tmp_path / "cpu.max").write_text(quota)
    monkeypatch.setattr(threads, "QUOTA_FILE", tmp_path / "cpu.max")
    monkeypatch.setattr(threads.os, "sched_getaffinity", lambda _process: range(64), raising=False)
    assert core_count() == cores  # the function itself, not the replaced one


def test_blocks_cover_all_elements_in_order_for_any_number_of_threads() -> None:
    for number in (1, 3):
        set_threads(number)
        blocks = each_block(lambda some: (some.start, some.stop), 10, 4)
        assert blocks == [(0, 4), (4, 8), (8, 10)]
    assert each_block(lambda some: some, 0, 4) == []


def test_blocks_within_blocks_do_not_wait_for_each_other() -> None:
    set_threads(2)
    found = each_block(lambda some: each_block(lambda own: own.stop - own.start, some.stop, 3), 8, 2)
    assert [sum(parts) for parts in found] == [2, 4, 6, 8]
