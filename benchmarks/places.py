# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Where the files of the project are."""

from __future__ import annotations

from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
MESHES = ROOT / "assets" / "meshes"
DOCS = ROOT / "docs"
MIXED_SCENES = ROOT / "examples" / "mixed"
