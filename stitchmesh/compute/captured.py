# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Launches that are prepared once and repeated: graphs on a GPU, tables that all cores work through on a CPU."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import chain, groupby
from typing import Any

import warp as wp

from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.launch import LaunchTable, prepare

Launcher = Callable[..., Any]
"""``Model.launch``, which runs a kernel immediately, or ``Model.prepare``, which returns a launch for later."""
WORDS = wp.constant(4096)
"""Words of four bytes that a block sets or copies on a CPU."""


@kernel(tile=1)
def clear_words(
    # state out
    words: wp.array[wp.int32],
) -> None:
    """Set words to zero; one block for each ``WORDS`` words."""
    block, _lane = wp.tid()
    for k in range(block * WORDS, wp.min((block + 1) * WORDS, words.shape[0])):
        words[k] = 0


@kernel(tile=1)
def copy_words(
    # state in
    source: wp.array[wp.int32],
    # state out
    target: wp.array[wp.int32],
) -> None:
    """Copy words; one block for each ``WORDS`` words."""
    block, _lane = wp.tid()
    for k in range(block * WORDS, wp.min((block + 1) * WORDS, source.shape[0])):
        target[k] = source[k]


@dataclass(frozen=True, eq=False)
class ZeroArray:
    """A launch that sets an array to zero."""

    array: wp.array[Any]

    def launch(self) -> None:
        """Set the array to zero."""
        self.array.zero_()

    def as_kernel(self) -> wp.Launch:
        """Return the same as the launch of a kernel, which a table can hold."""
        return _of_words(clear_words, self.array)


@dataclass(frozen=True, eq=False)
class CopyArray:
    """A launch that copies an array to another of the same size."""

    source: wp.array[Any]
    target: wp.array[Any]

    def launch(self) -> None:
        """Copy the array."""
        wp.copy(self.target, self.source)

    def as_kernel(self) -> wp.Launch:
        """Return the same as the launch of a kernel, which a table can hold."""
        return _of_words(copy_words, self.source, self.target)


@dataclass(frozen=True, eq=False)
class GridBuild:
    """A launch that sorts points into a hash grid; a graph cannot hold it, nor can ``Branches`` or a ``CapturedLoop``.

    Warp copies the description of the grid (its arrays, and the width of its cells) from one place on the host, which
    all grids of a precision share. The replay of a graph would therefore describe the grid as the one that was built
    last, with other arrays or cells of another width, and a query would not find all neighbours.
    """

    grid: wp.HashGrid
    places: wp.array[Any]
    """Coordinates of the points, shape (N, 3)."""
    width: float
    """Width of a cell of the grid, in the unit of the coordinates."""

    def launch(self) -> None:
        """Sort the points."""
        self.grid.build(self.places, self.width)


@dataclass(frozen=True, eq=False)
class Branches:
    """Two independent sequences of launches: neither reads what the other writes. A GPU runs them side by side."""

    first: Sequence[Any]
    second: Sequence[Any]

    def launch_beside(self, streams: Iterator[wp.Stream]) -> None:
        """Run the first sequence on the present stream of the device, and the second one on the next of ``streams``."""
        beside = next(streams)
        with wp.ScopedStream(beside):
            _launch_all(self.second, streams)
        _launch_all(self.first, streams)
        beside.device.stream.wait_stream(beside)


def _launch_all(launches: Sequence[Any], streams: Iterator[wp.Stream]) -> None:
    """Run launches; each pair of branches takes the next stream."""
    for launch in launches:
        if isinstance(launch, Branches):
            launch.launch_beside(streams)
        else:
            launch.launch()


def _streams_for(launches: Sequence[Any], device: wp.Device) -> Iterator[wp.Stream]:
    """Return a stream for each pair of branches, also for branches within branches."""
    within = [each for each in launches if isinstance(each, Branches)]
    own = [wp.Stream(device) for _ in within]
    inner = [_streams_for([*each.first, *each.second], device) for each in within]
    return chain(own, *inner)


def _in_a_row(launches: Sequence[Any]) -> list[Any]:
    """Return the launches in one sequence, without branches."""
    result: list[Any] = []
    for launch in launches:
        result += _in_a_row([*launch.first, *launch.second]) if isinstance(launch, Branches) else [launch]
    return result


class CapturedLaunches:
    """Prepared launches in a fixed order."""

    def __init__(self, launches: Sequence[Any], device: wp.Device, *, times: int = 1) -> None:
        """Capture the launches, ``times`` times in a row, as graphs on a GPU and as tables on a CPU."""
        self.launches = list(launches)
        """They hold the arrays of the graphs."""
        whole = self.launches * times
        self.parts = _in_graphs(whole, device) if device.is_cuda else _in_tables(_in_a_row(whole))
        """Graphs or tables, and the launches between them."""

    def launch(self) -> None:
        """Run all launches."""
        for part in self.parts:
            part.launch()


@dataclass(frozen=True, eq=False)
class _Graph:
    """Launches that a GPU runs as one."""

    graph: Any

    def launch(self) -> None:
        """Run the launches."""
        wp.capture_launch(self.graph)


class CapturedLoop:
    """Repeats launches until a number on the device is zero.

    Some GPUs can test the number themselves, without the host, so that one graph holds all repetitions. Other GPUs and
    CPUs run batches of repetitions, and the host tests the number after each batch. Repetitions must therefore change
    nothing once the number is zero.
    """

    def __init__(
        self, first: Sequence[Any], repeated: Sequence[Any], condition: wp.array[Any], device: wp.Device, *, batch: int
    ) -> None:
        """Capture the launches.

        Args:
            first: launches that run once, before the others, and set the condition.
            repeated: launches that are repeated; they set the condition again.
            condition: the number, an array of one integer.
            device: where the launches run.
            batch: repetitions between two tests by the host.
        """
        self._condition = condition
        self._graph: Any = None
        if device.is_cuda and wp.is_conditional_graph_supported():
            self._launches = [*first, *repeated]  # their arrays live as long as the graph
            streams = _streams_for(self._launches, device)
            with wp.ScopedCapture(device=device) as capture:
                _launch_all(first, streams)
                wp.capture_while(condition, lambda: _launch_all(repeated, streams))
            self._graph = capture.graph
        else:
            self._first = CapturedLaunches(first, device)
            self._batch = CapturedLaunches(repeated, device, times=batch)

    def launch(self) -> None:
        """Run the first launches once, and then the others until the condition is zero."""
        if self._graph is not None:
            wp.capture_launch(self._graph)
            return
        self._first.launch()
        while self._condition.numpy()[0] != 0:
            self._batch.launch()


def _in_graphs(launches: Sequence[Any], device: wp.Device) -> list[Any]:
    """Join neighbouring launches into graphs, between which grids are built."""

    def graph(members: Sequence[Any]) -> _Graph:
        streams = _streams_for(members, device)
        with wp.ScopedCapture(device=device) as capture:
            _launch_all(members, streams)
        return _Graph(capture.graph)

    return _joined(launches, lambda launch: not isinstance(launch, GridBuild), graph)


def _in_tables(launches: Sequence[Any]) -> list[Any]:
    """Join neighbouring launches of kernels into tables, and keep all other launches as they are."""
    kernels = [each.as_kernel() if _is_of_words(each) else each for each in launches]
    return _joined(kernels, lambda launch: isinstance(launch, wp.Launch), LaunchTable)


def _joined(launches: Sequence[Any], suits: Callable[[Any], bool], join: Callable[[list[Any]], Any]) -> list[Any]:
    """Join neighbouring launches that suit, and keep all others as they are."""
    result: list[Any] = []
    for suitable, group in groupby(launches, key=suits):
        members = list(group)
        result += [join(members)] if suitable else members
    return result


def _is_of_words(launch: Any) -> bool:
    """Whether a launch clears or copies one whole array, so that a kernel can do it word by word."""
    arrays = [array for array in vars(launch).values() if isinstance(launch, ZeroArray | CopyArray)]
    return bool(arrays) and all(array.is_contiguous and array.size for array in arrays)


def _of_words(kernel: wp.Kernel, *arrays: wp.array[Any]) -> wp.Launch:
    """Return the launch of a kernel that works on arrays of the same size as words of four bytes."""
    count = arrays[0].capacity // 4
    words = [wp.array(ptr=array.ptr, dtype=wp.int32, shape=count, device=array.device) for array in arrays]
    return prepare(kernel, -(-count // int(WORDS)), words, [], arrays[0].device)
