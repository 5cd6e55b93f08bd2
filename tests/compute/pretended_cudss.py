# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The functions of cuDSS for arrays beside the processor, by SciPy: what calls them is tested without a GPU."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import warp as wp
from scipy.sparse import csr_array, triu
from scipy.sparse.linalg import splu

from stitchmesh.compute import cudss

SUCCESS = 0


def pretend_cudss(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the device ``cpu`` have cuDSS during a test."""
    pretended = PretendedCudss()
    monkeypatch.setattr(cudss, "library", lambda: pretended)
    monkeypatch.setattr(cudss, "factors_on", lambda _device: True)
    monkeypatch.setattr(wp, "get_stream", lambda _device: SimpleNamespace(cuda_stream=0))
    cudss._handle.cache_clear()


def memory(address: int, count: int, kind: Any) -> np.ndarray:
    return np.ctypeslib.as_array((kind * count).from_address(address))


@dataclass
class PretendedCudss:
    """The calls, whose objects are numbered."""

    made: list[Any] = field(default_factory=lambda: [None])
    """The vectors and matrices by their numbers, and the factors of each data."""

    def __getattr__(self, name: str) -> Callable[..., int]:
        """Calls that set, begin and end do nothing."""
        if not name.startswith("cudss"):
            raise AttributeError(name)
        return lambda *_arguments: SUCCESS

    def _make(self, reference: Any, made: Any) -> int:
        self.made.append(made)
        reference._obj.value = len(self.made) - 1
        return SUCCESS

    def cudssDataCreate(self, _handle: Any, data: Any) -> int:
        return self._make(data, {})

    def cudssMatrixCreateDn(self, vector: Any, rows: int, columns: int, ld: int, values: int, *kinds: int) -> int:
        assert (columns, ld, kinds) == (1, rows, (cudss.FLOAT64, 0))
        return self._make(vector, memory(values, rows, ctypes.c_double))

    def cudssMatrixCreateCsr(
        self, matrix: Any, rows: int, columns: int, count: int, start: int, _end: None, places: int, values: int,
        *kinds: int,
    ) -> int:  # fmt: skip
        assert rows == columns and kinds == (cudss.INT32, cudss.INT32, cudss.FLOAT64, cudss.SYMMETRIC, cudss.UPPER, 0)
        pattern = memory(places, count, ctypes.c_int), memory(start, rows + 1, ctypes.c_int)
        return self._make(matrix, (memory(values, count, ctypes.c_double), *pattern))

    def cudssExecute(self, _handle: Any, phase: int, _settings: Any, data: Any, *operands: Any) -> int:
        kept, (upper, solution, right) = self.made[data.value], (self.made[operand.value] for operand in operands)
        if phase == cudss.ANALYSIS:
            kept["analysed"] = True
        elif phase in (cudss.FACTORIZATION, cudss.REFACTORIZATION):
            assert kept["analysed"] and (phase == cudss.REFACTORIZATION) == ("pivots" in kept)
            kept |= factors(upper)
        else:
            solution[:] = kept["factors"].solve(right)
        return SUCCESS

    def cudssDataGet(self, _handle: Any, data: Any, what: int, target: int, size: int, _wrote: Any) -> int:
        pivots = self.made[data.value]["pivots"]
        assert what == cudss.DIAGONAL and size == pivots.nbytes
        memory(target, len(pivots), ctypes.c_double)[:] = pivots
        return SUCCESS


def factors(parts: tuple[np.ndarray, ...]) -> dict[str, Any]:
    """The factors of the symmetric matrix of an upper triangle without an exchange of rows, and its pivots."""
    upper = csr_array(parts, copy=True)
    whole, count = (upper + triu(upper, 1).T).tocsc(), upper.shape[0]
    try:
        found = splu(whole, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    except RuntimeError:  # a pivot is exactly zero
        return {"pivots": np.full(count, np.nan)}
    exchanged = not np.array_equal(found.perm_r, found.perm_c)
    return {"factors": found, "pivots": np.full(count, np.nan) if exchanged else found.U.diagonal()[found.perm_c]}
