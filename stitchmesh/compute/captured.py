# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Launches that are prepared once and repeated: one graph on a GPU, one launch after the other on a CPU."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import warp as wp

Launcher = Callable[..., Any]
"""``Model.launch``, which runs a kernel immediately, or ``Model.prepare``, which returns a launch for later."""


@dataclass(frozen=True, eq=False)
class ZeroArray:
    """A launch that sets an array to zero."""

    array: wp.array[Any]

    def launch(self) -> None:
        """Set the array to zero."""
        self.array.zero_()


@dataclass(frozen=True, eq=False)
class CopyArray:
    """A launch that copies an array to another."""

    source: wp.array[Any]
    target: wp.array[Any]

    def launch(self) -> None:
        """Copy the array."""
        wp.copy(self.target, self.source)


class CapturedLaunches:
    """Prepared launches in a fixed order."""

    def __init__(self, launches: Sequence[Any], device: wp.Device, *, times: int = 1) -> None:
        """Capture the launches, ``times`` times in a row, as a graph on a GPU."""
        self.launches, self.times = list(launches), times
        self.graph: Any = None
        if device.is_cuda:
            with wp.ScopedCapture(device=device) as capture:
                self._launch_each()
            self.graph = capture.graph

    def launch(self) -> None:
        """Run all launches."""
        if self.graph is not None:
            wp.capture_launch(self.graph)
        else:
            self._launch_each()

    def _launch_each(self) -> None:
        for _ in range(self.times):
            for launch in self.launches:
                launch.launch()
