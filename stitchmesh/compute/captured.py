# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Launches that are prepared once and repeated: one graph on a GPU, one after the other on a CPU."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import warp as wp


@dataclass(frozen=True, eq=False)
class Zeroing:
    """Sets an array to zero when it is launched."""

    array: wp.array[Any]

    def launch(self) -> None:
        """Do it."""
        self.array.zero_()


@dataclass(frozen=True, eq=False)
class Copying:
    """Copies an array to another when it is launched."""

    source: wp.array[Any]
    target: wp.array[Any]

    def launch(self) -> None:
        """Do it."""
        wp.copy(self.target, self.source)


class Recording:
    """Recorded launches, in their order."""

    def __init__(self, launches: Sequence[Any], device: wp.Device, *, times: int = 1) -> None:
        """Make a graph of them on a GPU, in which they come so many times."""
        self.launches, self.times = list(launches), times
        self.graph: Any = None
        if device.is_cuda:
            with wp.ScopedCapture(device=device) as capture:
                self._one_by_one()
            self.graph = capture.graph

    def launch(self) -> None:
        """Run them all."""
        if self.graph is not None:
            wp.capture_launch(self.graph)
        else:
            self._one_by_one()

    def _one_by_one(self) -> None:
        for _ in range(self.times):
            for launch in self.launches:
                launch.launch()
