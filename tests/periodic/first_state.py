# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Free repeats without the search for the lowest of several states, which takes five times as long.

Tests whose facts hold in every state of rest relax from the generated yarns alone. The search has tests of its own
(``relaxation/test_lowest_rest.py``), and each kind of fabric is relaxed with it in at least one test.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from stitchmesh.periodic.relaxation import lowest_rest


@contextmanager
def from_generated_yarns() -> Iterator[None]:
    """Let repeats come to rest from the generated yarns alone."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(lowest_rest, "STARTS", 0)
        yield
