# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Factors L D L^T of sparse symmetric matrices on a GPU, by NVIDIA's library cuDSS where that is installed.

cuDSS is proprietary. StitchMesh contains no part of it; the extra ``gpu`` installs NVIDIA's own package. The calls are
the calls of cuDSS 1 (https://docs.nvidia.com/cuda/cudss/). cuDSS needs cuBLAS and NVRTC. If they lie in another folder,
they must be loaded before it.

cuDSS is told neither to match rows nor to exchange them for better pivots. D is therefore diagonal, and its signs count
the eigenvalues, also of each block of a block-diagonal matrix. cuDSS takes sums in a fixed order (``DETERMINISTIC``),
so that a run is repeatable to the last bit; cuDSS 1.0.0 gives the same bits with 1, 4, 8 and 16 threads of the host.
"""

from __future__ import annotations

import ctypes
import logging
import struct
import weakref
from collections.abc import Iterator
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import warp as wp

from stitchmesh.errors import SolverError

logger = logging.getLogger(__name__)

LIBRARY, THREADING = "libcudss.so.1", "libcudss_mtlayer_gomp.so.1"
"""The library, and its own layer for threads of the host, with which large matrices are analysed faster."""
NEEDED = ("libnvJitLink.so", "libcublasLt.so", "libcublas.so", "libnvrtc.so")
"""Libraries of CUDA that cuDSS needs, without their version numbers."""
CUDA_VERSIONS = (13, 12)
"""Versions of CUDA for which NVIDIA makes packages of cuDSS."""

FLOAT64, INT32 = 1, 10
SYMMETRIC, UPPER = 1, 2
ANALYSIS, FACTORIZATION, REFACTORIZATION, SOLVE = 3, 4, 8, 1008
MATCHING, PIVOT_TYPE, PIVOT_EPSILON, DETERMINISTIC = 3, 7, 9, 24
NO_MATCHING, NO_PIVOTING = 0, 1
DIAGONAL = 8
STATUS = ("success", "not initialized", "allocation failed", "invalid value", "not supported", "execution failed",
          "internal error", "refinement failed")  # fmt: skip
"""Numbers that the headers of cuDSS 1 give to types, phases, settings, data and statuses."""

_P, _I64, _INT, _SIZE = ctypes.c_void_p, ctypes.c_int64, ctypes.c_int, ctypes.c_size_t
_ARGUMENTS: dict[str, tuple[Any, ...]] = {
    "cudssCreate": (_P,), "cudssSetStream": (_P, _P), "cudssSetThreadingLayer": (_P, ctypes.c_char_p),
    "cudssGetProperty": (_INT, _P),
    "cudssConfigCreate": (_P,), "cudssConfigDestroy": (_P,), "cudssConfigSet": (_P, _INT, _P, _SIZE),
    "cudssDataCreate": (_P, _P), "cudssDataDestroy": (_P, _P), "cudssDataGet": (_P, _P, _INT, _P, _SIZE, _P),
    "cudssMatrixCreateDn": (_P, _I64, _I64, _I64, _P, _INT, _INT),
    "cudssMatrixCreateCsr": (_P, _I64, _I64, _I64, _P, _P, _P, _P, _INT, _INT, _INT, _INT, _INT, _INT),
    "cudssMatrixDestroy": (_P,),
    "cudssExecute": (_P, _INT, _P, _P, _P, _P, _P),
}  # fmt: skip


def factors_on(device: wp.Device) -> bool:
    """Whether cuDSS factors matrices on this device: the device is a GPU, and cuDSS is installed."""
    return device.is_cuda and library() is not None


@cache
def library() -> ctypes.CDLL | None:
    """The library cuDSS 1, or None if it is not installed; a message of the debug level says which."""
    for path in _candidates():
        try:
            found = ctypes.CDLL(path)
            for name, arguments in _ARGUMENTS.items():
                function = getattr(found, name)
                function.argtypes, function.restype = arguments, ctypes.c_int
            version = _version_of(found)
        except (OSError, AttributeError, SolverError) as error:
            logger.debug("cuDSS cannot be used: %s", error)
            continue
        if version[0] == 1:
            logger.debug("cuDSS %d.%d.%d factors matrices on GPUs", *version)
            return found
        logger.debug("cuDSS cannot be used: %s has version %d, expected 1", path, version[0])
    logger.debug("the processor factors matrices of GPUs: cuDSS is not installed (pip install stitchmesh[gpu])")
    return None


def _version_of(found: ctypes.CDLL) -> list[int]:
    version = []
    for part in range(3):
        value = ctypes.c_int()
        _check(found.cudssGetProperty(part, ctypes.byref(value)), "version")
        version.append(value.value)
    return version


def _candidates() -> Iterator[str]:
    """Yield the names under which cuDSS may be loaded, each after the libraries that it needs are loaded."""
    folders = _package_folders()
    for version in CUDA_VERSIONS:
        found = [folder / LIBRARY for folder in folders if folder.parent.name == f"cu{version}"]
        for path in filter(Path.is_file, found):
            _load_needed(folders, version)
            yield str(path)
    yield LIBRARY  # of the system


def _package_folders() -> list[Path]:
    """The folders with libraries in the installed packages of NVIDIA."""
    spec = find_spec("nvidia")
    roots = [] if spec is None else [Path(root) for root in spec.submodule_search_locations or ()]
    return [folder for root in roots for folder in sorted(root.glob("*/lib"))]


def _load_needed(folders: list[Path], version: int) -> None:
    for name in NEEDED:
        paths = [folder / f"{name}.{version}" for folder in folders]
        for path in filter(Path.is_file, paths):
            try:
                ctypes.CDLL(str(path), mode=ctypes.RTLD_GLOBAL)
                break
            except OSError as error:
                logger.debug("%s is not loaded: %s", path, error)


def _check(status: int, what: str) -> None:
    if status:
        name = STATUS[status] if status < len(STATUS) else f"status {status}"
        raise SolverError(
            f"cuDSS, {what}: {name}; relax fewer cells at once, or uninstall nvidia-cudss for factors by the processor"
        )


def _loaded() -> ctypes.CDLL:
    found = library()
    if found is None:
        raise SolverError("cuDSS: is not installed; install it by pip install stitchmesh[gpu]")
    return found


@cache
def _handle(device: str) -> ctypes.c_void_p:
    """The handle of cuDSS on a device, which lasts as long as the process."""
    found, handle = _loaded(), ctypes.c_void_p()
    _check(found.cudssCreate(ctypes.byref(handle)), "start")
    layer = next((folder / THREADING for folder in _package_folders() if (folder / THREADING).is_file()), None)
    if layer is not None and found.cudssSetThreadingLayer(handle, str(layer).encode()):
        logger.debug("cuDSS analyses matrices on one thread: %s cannot be loaded", layer)
    return handle


class SymmetricFactors:
    """The factors of a symmetric matrix of fixed pattern; the caller sets ``values`` and calls ``factor``."""

    def __init__(self, row_start: wp.array[Any], columns: wp.array[Any]) -> None:
        """Allocate on the GPU of the pattern.

        Args:
            row_start: index at which each row of the upper triangle starts, shape (n + 1,).
            columns: columns of the entries, ascending in each row and with the diagonal, shape (m,).

        Raises:
            SolverError: cuDSS is not installed, or the memory does not suffice.
        """
        count, device = len(row_start) - 1, row_start.device
        self.values = wp.zeros(len(columns), dtype=wp.float64, device=device)
        """The entries of the upper triangle, shape (m,)."""
        self.right, self.solution, self.pivots = (wp.zeros(count, dtype=wp.float64, device=device) for _ in range(3))
        """A right-hand side, its solution, and the diagonal of D in the order of the rows, shape (n,)."""
        self.holder: object = None
        """The user whose matrix is factored at present. Users that share this object set it and compare it."""
        self._library, self._device, self._is_analysed = _loaded(), device, False
        self._pattern = row_start, columns  # cuDSS keeps their addresses
        self._settings, self._data, *self._matrices = (ctypes.c_void_p() for _ in range(5))
        with wp.ScopedDevice(device):
            self._handle = _handle(device.alias)
            parts = self._handle, self._settings, self._data, *self._matrices
            self._create(count)
        weakref.finalize(self, _destroy, self._library, device, *parts).atexit = False

    def _create(self, count: int) -> None:
        """Create the settings, the data and the matrices of cuDSS."""
        found, (row_start, columns) = self._library, self._pattern
        matrix, solution, right = self._matrices
        _check(found.cudssConfigCreate(ctypes.byref(self._settings)), "settings")
        for setting, kind, value in [(MATCHING, "i", NO_MATCHING), (PIVOT_TYPE, "i", NO_PIVOTING),
                                     (PIVOT_EPSILON, "d", 0.0), (DETERMINISTIC, "i", 1)]:  # fmt: skip
            raw = struct.pack(kind, value)
            _check(found.cudssConfigSet(self._settings, setting, raw, len(raw)), f"setting {setting}")
        _check(found.cudssDataCreate(self._handle, ctypes.byref(self._data)), "data")
        places = row_start.ptr, None, columns.ptr, self.values.ptr
        kinds = INT32, INT32, FLOAT64, SYMMETRIC, UPPER, 0
        _check(found.cudssMatrixCreateCsr(ctypes.byref(matrix), count, count, len(columns), *places, *kinds), "matrix")
        for vector, array in ((solution, self.solution), (right, self.right)):
            created = found.cudssMatrixCreateDn(ctypes.byref(vector), count, 1, count, array.ptr, FLOAT64, 0)
            _check(created, "vector")

    def factor(self) -> None:
        """Factor the matrix with the present ``values``, and find the pivots."""
        if not self._is_analysed:
            self._execute(ANALYSIS, "analysis")
        self._execute(REFACTORIZATION if self._is_analysed else FACTORIZATION, "factors")
        self._is_analysed = True
        size, wrote = 8 * len(self.pivots), _SIZE()
        arguments = self._handle, self._data, DIAGONAL, self.pivots.ptr, size, ctypes.byref(wrote)
        with wp.ScopedDevice(self._device):
            _check(self._library.cudssDataGet(*arguments), "pivots")

    def solve(self) -> None:
        """Solve the linear system with the right-hand side ``right``, and write the ``solution``."""
        self._execute(SOLVE, "solution")

    def _execute(self, phase: int, what: str) -> None:
        arguments = self._handle, phase, self._settings, self._data, *self._matrices
        with wp.ScopedDevice(self._device):
            _check(self._library.cudssSetStream(self._handle, wp.get_stream(self._device).cuda_stream), "stream")
            _check(self._library.cudssExecute(*arguments), what)


def _destroy(found: ctypes.CDLL, device: wp.Device, handle: Any, settings: Any, data: Any, *matrices: Any) -> None:
    with wp.ScopedDevice(device):
        for matrix in matrices:
            found.cudssMatrixDestroy(matrix)
        found.cudssDataDestroy(handle, data)
        found.cudssConfigDestroy(settings)
