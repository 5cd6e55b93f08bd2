# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Kill all commands that write files, or refuse their files, and print what was left.

    python -m tests.crashes kills --kills 200
    python -m tests.crashes refusals               # as root, on a small disk of its own
"""

from __future__ import annotations

import sys

from benchmarks.options import begun
from benchmarks.table import show
from tests.crashes.kills import kills
from tests.crashes.refusals import refusals

if __name__ == "__main__":
    sys.exit(show(begun((kills, refusals), "python -m tests.crashes", sys.argv[1:], __doc__ or "")))
