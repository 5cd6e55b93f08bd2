# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Smallest distances between yarns, and between distant parts of one yarn.

A hash grid sorts sample points of all segments. Each segment then finds the nearest sample point of the segments that
may touch it, in all lattice images. Only pairs of points that are near enough are looked at. The points are in double
precision on every device.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.device import alone, device_named
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.launch import launch
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.yarn import YarnSet

SAMPLES_PER_SEGMENT = 4
"""Number of points of each segment between which distances are measured."""
CELL = 2.0
"""Smallest width of a cell of the hash grid over the radius of a search, which then looks into eight cells at most. A
cell is no smaller than the mean length of a segment either, because near points would lie in too many cells then."""
SMALLEST_GRID, LARGEST_GRID = 16, 256
"""Bounds of the number of cells along each axis of the hash grid, which has about a cell for each point. The grid is
periodic, so its size limits the memory but not the space."""
FARTHEST_CELL = 2.0**30
"""Largest number of a cell along an axis, counted from the origin, so that it is an integer of 32 bits."""
NONE = -1
"""Stands for the segment that is nearest to a segment without near ones."""


@wp.func
def home_of(home: wp.array[wp.vec2i], i: int) -> wp.vec2i:
    """Image of the cell in which a point lies; zero without a lattice."""
    if home.shape[0] == 0:
        return wp.vec2i(0, 0)
    return home[i]


@wp.func
def within_box(box: wp.array[wp.vec3d], place: wp.vec3d) -> bool:
    """Whether a place lies in a box, given by its lowest and its highest corner."""
    low, high = box[0], box[1]
    return (
        place[0] >= low[0] and place[1] >= low[1] and place[2] >= low[2]
        and place[0] <= high[0] and place[1] <= high[1] and place[2] <= high[2]
    )  # fmt: skip


@wp.func
def neighbours_along_yarn(ahead: int, count: int, closed: bool, step: wp.vec2i, image: wp.vec2i) -> bool:
    """Whether two segments of one yarn share control points, or nearly: they are at most two segments apart.

    Args:
        ahead: number of segments from the one to the other.
        count: number of segments of the yarn.
        closed: whether the yarn is closed; the other segment may then lie one turn further.
        step: lattice image in which the yarn continues after a turn.
        image: lattice image of the other segment, seen from the one.
    """
    for turn in range(-1, 2):
        same_place = turn * step[0] == image[0] and turn * step[1] == image[1] and (closed or turn == 0)
        if same_place and wp.abs(ahead + turn * count) <= 2:
            return True
    return False


@kernel
def find_nearest(
    # model
    within: wp.float64,
    segment_start: wp.array[wp.int32],
    closed: wp.array[wp.bool],
    step: wp.array[wp.vec2i],
    images: wp.array[wp.vec2i],
    shift: wp.array[wp.vec3d],
    box: wp.array[wp.vec3d],
    # state in
    grid: wp.uint64,
    samples: wp.array[wp.vec3d],
    home: wp.array[wp.vec2i],
    # state out
    distance: wp.array[wp.float64],
    nearest: wp.array[wp.int32],
) -> None:
    """Find the segment whose samples are nearest to those of each segment, and their distance.

    Of segments at the same distance the first one is taken.
    """
    s = wp.tid()
    per_segment = samples.shape[0] / distance.shape[0]
    yarn = wp.lower_bound(segment_start, s + 1) - 1
    first, end = segment_start[yarn], segment_start[yarn + 1]
    least = distance[s]
    found = int(NONE)
    for image in range(images.shape[0]):
        for i in range(s * per_segment, (s + 1) * per_segment):
            here = samples[i] - shift[image]
            if not within_box(box, here):
                continue
            for j in wp.hash_grid_query(grid, here, within):
                apart = wp.length(samples[j] - here)
                other = j / per_segment
                if apart <= within and (apart < least or (apart == least and other < found)):
                    seen = images[image] + home_of(home, i) - home_of(home, j)
                    own = other >= first and other < end
                    if not own or not neighbours_along_yarn(other - s, end - first, closed[yarn], step[yarn], seen):
                        least = apart
                        found = other
    distance[s] = least
    nearest[s] = found


def smallest_distance(
    yarns: YarnSet, within: float, device: str | None = "cpu"
) -> tuple[float, tuple[int, int]]:
    """Smallest distance [cm] between sample points of segments that may touch, and a control point of either segment.

    Segments of one yarn with fewer than two segments between them do not touch.

    Args:
        yarns: the yarns; on a lattice, distances to all images are measured too.
        within: largest distance that is searched [cm].
        device: "cpu", "cuda:0" ...; None for the first GPU, or the CPU if there is no GPU.

    Returns:
        The distance [cm] and the numbers of two control points; infinity and 0 where no distance is at most ``within``.

    Raises:
        ParameterError: the device is unknown.
    """
    distance, nearest = _nearest_segments(yarns, within, device)
    segment = int(distance.argmin())
    if nearest[segment] == NONE:
        return np.inf, (0, 0)
    one, other = yarns.segment_points[[segment, nearest[segment]], 1].tolist()
    return float(distance[segment]), (one, other)


def crowded_points(yarns: YarnSet, within: float, device: str | None = "cpu") -> IntArray:
    """Return control points at all places where segments that may touch are closer than a distance [cm].

    The arguments are those of ``smallest_distance``.
    """
    _, nearest = _nearest_segments(yarns, within, device)
    return np.unique(yarns.segment_points[nearest != NONE, 1])


@alone()
def _nearest_segments(
    yarns: YarnSet, within: float, device: str | None
) -> tuple[FloatArray, NDArray[np.int32]]:
    """The distance [cm] from each segment to the nearest one that may touch it, and that segment, shape (S,) each.

    Where none is within the distance, the distance is infinite and the segment ``NONE``.
    """
    place, samples, home = device_named(device), yarns.samples(SAMPLES_PER_SEGMENT), np.zeros((0, 2), dtype=np.int64)
    images, shift = np.zeros((1, 2), dtype=np.int64), np.zeros((1, 3))
    step = np.zeros((yarns.yarn_count, 2), dtype=np.int64) if yarns.lattice_step is None else yarns.lattice_step
    if yarns.lattice is not None:
        home = yarns.lattice.image_of(samples)
        samples = samples - yarns.lattice.shift(home)
        images = yarns.lattice.near_images(samples, within)
        shift = yarns.lattice.shift(images)
    low, high = ([reduced(axis) for axis in samples.T] for reduced in (np.min, np.max))
    box = np.array([low, high]) + np.array([[-within], [within]])

    def sent(values: NDArray[Any], kind: Any) -> wp.array[Any]:
        """The values on the device."""
        return wp.array(np.ascontiguousarray(values, dtype=kind[0]), dtype=kind[1], device=place)

    number, pair, vector = (np.int32, wp.int32), (np.int32, wp.vec2i), (np.float64, wp.vec3d)
    points = sent(samples, vector)
    cells = int(np.clip(round(len(samples) ** (1 / 3)), SMALLEST_GRID, LARGEST_GRID))
    grid = wp.HashGrid(cells, cells, cells, device=place, dtype=wp.float64)
    length = float(yarns.rest_length.mean())
    grid.build(points, max(CELL * within, length, float(np.abs(box).max()) / FARTHEST_CELL))
    count = len(yarns.segment_points)
    distance = wp.full(count, np.inf, dtype=wp.float64, device=place)
    nearest = wp.zeros(count, dtype=wp.int32, device=place)
    model = [wp.float64(within), sent(yarns.segment_start, number), sent(yarns.closed, (np.bool_, wp.bool))]
    model += [sent(step, pair), sent(images, pair), sent(shift, vector), sent(box, vector)]
    launch(find_nearest, count, [*model, wp.uint64(grid.id), points, sent(home, pair)], [distance, nearest], place)
    return distance.numpy(), nearest.numpy()
