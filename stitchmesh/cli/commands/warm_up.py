# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``warm-up``."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Annotated

from stitchmesh.cli.options import Device
from stitchmesh.cli.summary import AsJson, print_result
from stitchmesh.cli.words import help_entry


@dataclass(frozen=True)
class WarmUpCommand:
    """Compile all kernels for a processor once, so that later commands start at once."""

    device: Device = None
    workers: Annotated[int | None, help_entry("N", "one for each core, as far as the memory suffices")] = None
    """number of processes that compile"""
    json: AsJson = False

    def run(self) -> None:
        """Compile the kernels that have not been compiled, and say how many these are and where they lie."""
        from stitchmesh.cli.progress import show_progress
        from stitchmesh.first_use import warm_up

        with show_progress() as progress:
            done = warm_up(self.device, workers=self.workers, progress=progress)
        compiled = f"Compiled {done.compiled:,} kernels for {done.device} in {done.seconds:.0f} s"
        lines = [
            f"{compiled} with {done.workers} processes; {done.kept:,} had been compiled before.",
            f"They lie in {done.folder}; the variable WARP_CACHE_PATH chooses another folder.",
        ]
        print_result(asdict(done) | {"folder": str(done.folder)}, lines, as_json=self.json)
