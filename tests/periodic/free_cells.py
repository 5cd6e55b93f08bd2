# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Swatches that find their size without friction, whose state of rest does not depend on a path."""

from __future__ import annotations

from typing import Any

FREE: dict[str, Any] = {"relax_cell": True, "relaxation": "frictionless"}
"""Their arguments of ``swatch``."""
