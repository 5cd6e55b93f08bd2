# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Damaged files for all readers: some in every run of the tests, very many with ``make test-nightly``."""

from __future__ import annotations

import os

SEED = os.environ.get("STITCHMESH_SEED", "1")
"""Seed of what is tried in one night; ``make test-nightly`` takes the date."""
