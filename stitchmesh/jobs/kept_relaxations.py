# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Checkpoints of a computation that relaxes yarns several times, such as the search for the lowest state of a swatch.

Each relaxation of the computation has a folder of checkpoints, whose name is the checksum of the inputs. The last
checkpoint is written at the end of the relaxation; a relaxation that continues from it gives the same result without an
iteration. A computation that begins again therefore passes through the finished relaxations, continues the stopped
relaxation, and ends with the same bits as without a stop. The short work between the relaxations is done again.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from stitchmesh.compute.shared_work import Call, Worker
from stitchmesh.run import CHECKPOINT, SHOWN, Checkpoints
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import relax_yarns
from stitchmesh.yarnrelax.checkpoint import seconds_of
from stitchmesh.yarnrelax.fingerprint import checksum
from stitchmesh.yarnrelax.load_steps import relax_through_steps

FOLDER = "relaxations"
"""Folder of the folders of the relaxations."""
NO_INPUTS = ("run", "device")
"""Arguments of relaxations that decide no bit; each checkpoint holds the kind of the device."""


@dataclass(frozen=True)
class KeptRelaxations(Worker):
    """The relaxations of one computation in a folder; as a worker, it continues each of them."""

    folder: Path
    """Folder of the computation."""
    every: int
    """Iterations between two checkpoints of a relaxation."""
    check: Callable[[], None]
    """Called before each piece of work; it raises an exception if the computation is to stop."""
    on_state: Callable[[YarnSet], None] | None = None
    """Called every few seconds with the last accepted state of the present relaxation."""

    def do(self, call: Call) -> Any:
        """Do one piece of work; a relaxation writes checkpoints, and continues from the last one if there is any."""
        self.check()
        return self._relax(call) if call.function in (relax_yarns, relax_through_steps) else call.do()

    def exist(self) -> bool:
        """Return whether an earlier run has begun a relaxation."""
        return any(True for _ in self._checkpoints())

    def seconds(self) -> float:
        """Return the time that earlier runs have spent on relaxations [s].

        Raises:
            FileError: a checkpoint is damaged.
        """
        return sum(seconds_of(path) for path in self._checkpoints())

    def remove(self) -> None:
        """Remove all checkpoints, because the result of the computation is kept."""
        shutil.rmtree(self.folder / FOLDER, ignore_errors=True)

    def _relax(self, call: Call) -> Any:
        given = {name: value for name, value in sorted(call.arguments.items()) if name not in NO_INPUTS}
        key = checksum("relaxation", given)
        checkpoints = Checkpoints(self.folder / FOLDER / key, self.every)
        resume = checkpoints.path if checkpoints.path.is_file() else None
        run = replace(
            call.arguments.get("run", SHOWN), on_state=self.on_state, checkpoints=checkpoints, resume=resume
        )  # fmt: skip
        return replace(call, arguments={**call.arguments, "run": run}).do()

    def _checkpoints(self) -> Iterator[Path]:
        """Yield the newest checkpoint of each relaxation."""
        yield from (self.folder / FOLDER).glob(f"*/{CHECKPOINT}")
