# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Where the matrices of cells are."""

from __future__ import annotations

import pytest

from tests.compute.pretended_cudss import pretend_cudss
from tests.compute.test_cudss import GPUS, needs_cudss
from tests.yarnrelax.hessian.places import Place, on_device, on_host


@pytest.fixture(params=["host", "pretended GPU", pytest.param("GPU", marks=needs_cudss)])
def place(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> Place:
    """What puts the matrices of cells beside the processor, or on a GPU as far as there is one."""
    if request.param == "host":
        return on_host
    if request.param == "pretended GPU":
        pretend_cudss(monkeypatch)
        return lambda owners, matrix: on_device("cpu", owners, matrix)
    return lambda owners, matrix: on_device(GPUS[0], owners, matrix)
