# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""cuDSS is used where it is found in version 1, and its absence is no error."""

from __future__ import annotations

import ctypes
import logging
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import warp as wp

from stitchmesh.compute import cudss
from stitchmesh.compute.device import device_named, device_names
from stitchmesh.errors import SolverError

GPUS = [name for name in device_names() if name != "cpu" and cudss.factors_on(device_named(name))]
needs_cudss = pytest.mark.skipif(not GPUS, reason="no GPU with cuDSS: pip install stitchmesh[gpu]")


@pytest.fixture
def forgotten() -> Iterator[None]:
    """The library is looked for again, in this test and after it."""
    cudss.library.cache_clear()
    yield
    cudss.library.cache_clear()


@pytest.mark.parametrize("content", [None, b"no library"])
def test_without_a_library_that_loads_there_is_none(
    content: bytes | None, forgotten: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
) -> None:  # fmt: skip
    path = tmp_path / cudss.LIBRARY
    if content is not None:
        path.write_bytes(content)
    monkeypatch.setattr(cudss, "_candidates", lambda: iter([str(path)]))
    with caplog.at_level(logging.DEBUG, "stitchmesh.compute.cudss"):
        assert cudss.library() is None
    assert str(path) in caplog.messages[0] and "pip install stitchmesh[gpu]" in caplog.messages[-1]


def test_a_library_of_another_version_is_not_used(
    forgotten: None, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(cudss, "_candidates", lambda: iter(["libcudss.so.2"]))
    monkeypatch.setattr(cudss, "_ARGUMENTS", {})
    monkeypatch.setattr(cudss, "_version_of", lambda _found: [2, 0, 0])
    monkeypatch.setattr(ctypes, "CDLL", lambda path: path)
    with caplog.at_level(logging.DEBUG, "stitchmesh.compute.cudss"):
        assert cudss.library() is None
    assert "libcudss.so.2 has version 2, expected 1" in caplog.messages[0]


def test_packages_of_nvidia_come_before_the_system_and_the_newest_first(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for version in (12, 13):
        folder = tmp_path / "nvidia" / f"cu{version}" / "lib"
        folder.mkdir(parents=True)
        (folder / cudss.LIBRARY).touch()
    monkeypatch.syspath_prepend(tmp_path)
    found = [Path(path) for path in cudss._candidates() if str(tmp_path) in path or "/" not in path]
    assert [path.parent.parent.name for path in found[:2]] == ["cu13", "cu12"] and found[-1] == Path(cudss.LIBRARY)


def test_a_refusal_of_the_library_says_what_helps() -> None:
    with pytest.raises(SolverError, match="cuDSS, factors: allocation failed; relax fewer cells at once, or uninstall"):
        cudss._check(2, "factors")


def test_factors_without_the_library_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cudss, "library", lambda: None)
    pattern = [wp.array(part, dtype=wp.int32, device="cpu") for part in ([0, 1], [0])]
    with pytest.raises(SolverError, match=r"cuDSS: is not installed; install it by pip install stitchmesh\[gpu\]"):
        cudss.SymmetricFactors(*pattern)


@needs_cudss
def test_the_factors_of_a_path_have_the_pivots_that_are_known_and_solve() -> None:
    """The Laplace matrix of a path between held ends is positive, and its solutions are lines."""
    count = 200
    starts = np.minimum(2 * np.arange(count + 1), 2 * count - 1)
    columns = np.repeat(np.arange(count), 2)[: 2 * count - 1] + np.arange(2 * count - 1) % 2
    pattern = [wp.array(part, dtype=wp.int32, device=GPUS[0]) for part in (starts, columns)]
    factors = cudss.SymmetricFactors(*pattern)
    for sign in (1.0, -1.0):  # the second time with the analysis of the first
        factors.values.assign(sign * np.where(np.arange(2 * count - 1) % 2 == 0, 2.0, -1.0))
        factors.factor()
        assert (sign * factors.pivots.numpy() > 0.0).all()
        factors.right.assign(np.append(np.zeros(count - 1), sign * (count + 1)))
        factors.solve()
        # Rounding of float64 times the condition of the matrix, which is count^2.
        np.testing.assert_allclose(factors.solution.numpy(), np.arange(1, count + 1), rtol=1e-10)
