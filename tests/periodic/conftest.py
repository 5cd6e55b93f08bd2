# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Fixtures of the tests of swatches."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests.periodic.free_cells import from_generated_yarns


@pytest.fixture
def first_state() -> Iterator[None]:
    """Free repeats come to rest from the generated yarns alone."""
    with from_generated_yarns():
        yield
