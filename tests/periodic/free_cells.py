# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Swatches that find their size without friction, whose state of rest does not depend on a path."""

from __future__ import annotations

from functools import cache
from typing import Any

import stitchmesh as sm
from tests.periodic.first_state import from_generated_yarns

FREE: dict[str, Any] = {"relax_cell": True, "relaxation": "frictionless"}
"""Their arguments of ``swatch``."""


@cache
def free_swatch(pattern: str, quality: str = "draft") -> sm.Swatch:
    """Return a swatch of the library that comes to rest from the generated yarns; all tests share it."""
    with from_generated_yarns():
        return sm.swatch(pattern, quality=quality, device="cpu", progress=False, **FREE)
