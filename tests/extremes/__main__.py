# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Run extreme cases and print the tables of docs/stability.md; the exit status is 1 if a case failed.

    python -m tests.extremes yarns
    python -m tests.extremes swatches --only gamma
    python -m tests.extremes cloths
"""

from __future__ import annotations

import sys

from benchmarks.options import begun
from benchmarks.table import show
from tests.extremes.cloths import cloths
from tests.extremes.swatches import swatches
from tests.extremes.yarns import yarns

if __name__ == "__main__":
    sys.exit(show(begun((yarns, swatches, cloths), "python -m tests.extremes", sys.argv[1:], __doc__ or "")))
