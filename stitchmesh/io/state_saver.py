# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Files with the yarns and the report of a garment, at the end of its relaxation and during it."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from pathlib import Path

from stitchmesh.io.atomic import write_json
from stitchmesh.io.yarns import write_yarns
from stitchmesh.yarn import YarnSet


def save_yarns(folder: Path, yarns: YarnSet, report: Mapping[str, object]) -> None:
    """Write ``yarns.h5``, ``yarns.bcc`` and ``report.json``, each file atomically."""
    write_yarns(folder / "yarns.h5", yarns)
    write_yarns(folder / "yarns.bcc", yarns)
    write_json(folder / "report.json", report)


class StateSaver:
    """Keeps the last good state of a relaxation, and writes it at intervals.

    The generated yarns are the first state.
    """

    EVERY_SECONDS = 60.0
    """Shortest interval between two writes [s]."""

    def __init__(self, folder: Path, report: Mapping[str, object], start: YarnSet) -> None:
        """Begin with the generated yarns; ``report`` has the entries of the stages before."""
        self._folder, self._report, self._state = folder, report, start
        self._saved = -math.inf  # The first good state is written at once, so that a running job can be looked at.

    def keep(self, state: YarnSet) -> None:
        """Keep a good state, and write ``yarns.h5`` and the report if the last write is older than the interval."""
        self._state = state
        if time.monotonic() - self._saved > self.EVERY_SECONDS:
            write_yarns(self._folder / "yarns.h5", state)
            write_json(self._folder / "report.json", self._unfinished)
            self._saved = time.monotonic()

    def save(self) -> None:
        """Write all files of the last good state, marked as unfinished."""
        save_yarns(self._folder, self._state, self._unfinished)

    @property
    def _unfinished(self) -> dict[str, object]:
        return {**self._report, "yarnrelax": {"unfinished": True}}
