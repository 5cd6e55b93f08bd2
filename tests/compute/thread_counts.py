# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Any number of threads for tests, on a machine with any number of cores."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from stitchmesh.compute import launch, threads


@contextmanager
def thread_count(count: int) -> Iterator[None]:
    """Share all launches, also the smallest, among ``count`` threads."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(threads, "core_count", lambda: count)
        patch.setattr(launch, "PARTS_PER_THREAD", 1)
        patch.setattr(threads, "_choice", threads._Choice(count))
        yield
