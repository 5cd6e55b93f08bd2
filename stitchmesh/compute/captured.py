# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Launches that are prepared once and repeated: one graph on a GPU, tables that all cores work through on a CPU."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Any

import warp as wp

from stitchmesh.compute.launch_table import LaunchTable

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
        """Capture the launches, ``times`` times in a row, as a graph on a GPU and as tables on a CPU."""
        self.launches = list(launches)
        self.graph: Any = None
        self.tables: list[Any] = []
        if device.is_cuda:
            with wp.ScopedCapture(device=device) as capture:
                for launch in self.launches * times:
                    launch.launch()
            self.graph = capture.graph
        else:
            self.tables = _in_tables(self.launches * times)

    def launch(self) -> None:
        """Run all launches."""
        if self.graph is not None:
            wp.capture_launch(self.graph)
        for table in self.tables:
            table.launch()


def _in_tables(launches: Sequence[Any]) -> list[Any]:
    """The launches with neighbouring launches of kernels joined in tables; others, such as copies, stay."""
    result: list[Any] = []
    for of_kernels, group in groupby(launches, key=lambda launch: isinstance(launch, wp.Launch)):
        result += [LaunchTable(list(group))] if of_kernels else group
    return result
