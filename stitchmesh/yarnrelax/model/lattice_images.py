# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Images on a lattice: the places of the neighbours of an element in a periodic fabric.

An element may refer to a control point or a contact sample in another image. The place of that point is its own place
plus a u + b v, with the periods u and v and a stored integer image (a, b) (design, section 2). Images are numbered in a
table. Several fabrics may be relaxed together, each in a cell with its own periods; all cells share the table. A fabric
without a lattice has no images. For it, overloads of the functions below read only the place, so that no kernel tests
whether a fabric is periodic.
"""

# overloads, which Warp distinguishes by the types of their arguments
# ruff: noqa: F811
# mypy: disable-error-code="no-redef"

from __future__ import annotations

from typing import Any, TypeAlias

import warp as wp

from stitchmesh.compute.precision import Scalar, ScalarType, Vec3, Vec4

NO_TURNS = wp.constant(2147483647)
"""Mark of an image that no number of turns of a yarn reaches."""


LatticeImages: TypeAlias = Any
"""``Images32``, ``Images64`` or ``NoImages``."""

@wp.struct
class NoImages:
    """A fabric without a lattice."""

    sample_count: wp.int32


@wp.struct
class Images32:
    """Periods and numbered images, single precision."""

    sample_count: wp.int32
    periods: wp.array[wp.vec3f]
    image: wp.array[wp.vec2i]
    corner_image: wp.array[wp.vec4i]
    segment_cell: wp.array[wp.int32]
    resting: wp.array[wp.int32]
    sample_cell: wp.array[wp.int32]
    box: wp.array[wp.vec3f]
    frame: wp.array[wp.vec3f]


@wp.struct
class Images64:
    """Periods and numbered images, double precision."""

    sample_count: wp.int32
    periods: wp.array[wp.vec3d]
    image: wp.array[wp.vec2i]
    corner_image: wp.array[wp.vec4i]
    segment_cell: wp.array[wp.int32]
    resting: wp.array[wp.int32]
    sample_cell: wp.array[wp.int32]
    box: wp.array[wp.vec3d]
    frame: wp.array[wp.vec3d]


def images_struct(scalar: ScalarType, *, on_lattice: bool) -> Any:
    """Return the kind of struct for yarns in one precision, with or without a lattice."""
    if not on_lattice:
        return NoImages
    return Images32 if scalar is wp.float32 else Images64


def images_with(images: Any, struct: Any, *, table: wp.array[Any], periods: wp.array[Any]) -> Any:
    """Return images with another table or other periods; ``struct`` is the struct of ``images_struct`` on a lattice."""
    other = struct()
    for name in struct.vars:
        setattr(other, name, getattr(images, name))
    other.image, other.periods = table, periods
    return other


@wp.func
def image_shift(images: Images32, cell: int, number: int) -> wp.vec3f:
    """Displacement of an image of a cell."""
    ab = images.image[number]
    return images.periods[2 * cell] * wp.float32(ab[0]) + images.periods[2 * cell + 1] * wp.float32(ab[1])


@wp.func
def image_shift(images: Images64, cell: int, number: int) -> wp.vec3d:
    """Displacement of an image of a cell."""
    ab = images.image[number]
    return images.periods[2 * cell] * wp.float64(ab[0]) + images.periods[2 * cell + 1] * wp.float64(ab[1])


@wp.func
def exact_shift(images: NoImages, cell: int, number: int) -> wp.vec3d:
    """Displacement of an image of a cell in double precision: zero without a lattice."""
    return wp.vec3d()


@wp.func
def exact_shift(images: Images32, cell: int, number: int) -> wp.vec3d:
    """Displacement of an image of a cell in double precision."""
    ab = images.image[number]
    u, v = wp.vec3d(images.periods[2 * cell]), wp.vec3d(images.periods[2 * cell + 1])
    return u * wp.float64(ab[0]) + v * wp.float64(ab[1])


@wp.func
def exact_shift(images: Images64, cell: int, number: int) -> wp.vec3d:
    """Displacement of an image of a cell in double precision."""
    return image_shift(images, cell, number)


@wp.func
def turns_of(image: wp.vec2i, step: wp.vec2i) -> int:
    """The number n with image = n step; ``NO_TURNS`` where there is none."""
    turns = int(0)
    if step[0] != 0:
        turns = image[0] // step[0]
    elif step[1] != 0:
        turns = image[1] // step[1]
    if turns * step[0] != image[0] or turns * step[1] != image[1]:
        turns = NO_TURNS
    return turns


@wp.func
def corner_place(images: NoImages, points: wp.array[Vec3], s: int, slot: int, point: int) -> Any:
    """Place of control point ``slot`` of segment ``s``."""
    return points[point]


@wp.func
def corner_place(images: Images32, points: wp.array[Vec3], s: int, slot: int, point: int) -> Any:
    """Place of control point ``slot`` of segment ``s``, in the image of the segment."""
    return points[point] + image_shift(images, images.segment_cell[s], images.corner_image[s][slot])


@wp.func
def corner_place(images: Images64, points: wp.array[Vec3], s: int, slot: int, point: int) -> Any:
    """Place of control point ``slot`` of segment ``s``, in the image of the segment."""
    return points[point] + image_shift(images, images.segment_cell[s], images.corner_image[s][slot])


@wp.func
def sample_number(images: NoImages, entry: int) -> int:
    """Sample of an entry of a candidate list."""
    return entry


@wp.func
def sample_number(images: Images32, entry: int) -> int:
    """Sample of an entry of a candidate list."""
    return entry % images.sample_count


@wp.func
def sample_number(images: Images64, entry: int) -> int:
    """Sample of an entry of a candidate list."""
    return entry % images.sample_count


@wp.func
def image_count(images: NoImages) -> int:
    """Number of images, including the fabric itself."""
    return 1


@wp.func
def image_count(images: Images32) -> int:
    """Number of images, including the fabric itself."""
    return images.image.shape[0]


@wp.func
def image_count(images: Images64) -> int:
    """Number of images, including the fabric itself."""
    return images.image.shape[0]


@wp.func
def shifted_by(images: NoImages, place: Vec3, cell: int, number: int) -> Any:
    """A place in an image."""
    return place


@wp.func
def shifted_by(images: Images32, place: Vec3, cell: int, number: int) -> wp.vec3f:
    """A place in an image."""
    return place + image_shift(images, cell, number)


@wp.func
def shifted_by(images: Images64, place: Vec3, cell: int, number: int) -> wp.vec3d:
    """A place in an image."""
    return place + image_shift(images, cell, number)


@wp.func
def turns_to(images: NoImages, yarn_step: wp.vec2i, number: int) -> int:
    """Number of turns of a yarn that lead to an image; ``NO_TURNS`` where there is none."""
    return 0


@wp.func
def turns_to(images: Images32, yarn_step: wp.vec2i, number: int) -> int:
    """Number of turns of a yarn that lead to an image; ``NO_TURNS`` where there is none."""
    return turns_of(images.image[number], yarn_step)


@wp.func
def turns_to(images: Images64, yarn_step: wp.vec2i, number: int) -> int:
    """Number of turns of a yarn that lead to an image; ``NO_TURNS`` where there is none."""
    return turns_of(images.image[number], yarn_step)


@wp.func
def image_of(images: NoImages, entry: int, count: int) -> int:
    """Image of a list entry that is image * ``count`` + number."""
    return 0


@wp.func
def image_of(images: Images32, entry: int, count: int) -> int:
    """Image of a list entry that is image * ``count`` + number."""
    return entry // count


@wp.func
def image_of(images: Images64, entry: int, count: int) -> int:
    """Image of a list entry that is image * ``count`` + number."""
    return entry // count


@wp.func
def entry_shift(images: NoImages, zero: Vec4, p: int, entry: int) -> Any:
    """Displacement of the lattice image of an entry in the list of sample ``p``: zero without a lattice."""
    return zero


@wp.func
def entry_shift(images: Images32, zero: Vec4, p: int, entry: int) -> wp.vec4f:
    """Displacement of the lattice image of an entry in the list of sample ``p``; the fourth component is 0."""
    shift = image_shift(images, images.sample_cell[p], entry // images.sample_count)
    return wp.vec4f(shift[0], shift[1], shift[2], zero[3])


@wp.func
def entry_shift(images: Images64, zero: Vec4, p: int, entry: int) -> wp.vec4d:
    """Displacement of the lattice image of an entry in the list of sample ``p``; the fourth component is 0."""
    shift = image_shift(images, images.sample_cell[p], entry // images.sample_count)
    return wp.vec4d(shift[0], shift[1], shift[2], zero[3])


@wp.func
def cell_of(images: NoImages, s: int) -> int:
    """The cell of a segment."""
    return 0


@wp.func
def cell_of(images: Images32, s: int) -> int:
    """The cell of a segment."""
    return images.segment_cell[s]


@wp.func
def cell_of(images: Images64, s: int) -> int:
    """The cell of a segment."""
    return images.segment_cell[s]


@wp.func
def rests(images: NoImages, cell: int) -> bool:
    """Whether launches leave out a cell (``Model.resting``); the only piece takes part in all."""
    return False


@wp.func
def rests(images: Images32, cell: int) -> bool:
    """Whether launches leave out a cell (``Model.resting``)."""
    return images.resting[cell] != 0


@wp.func
def rests(images: Images64, cell: int) -> bool:
    """Whether launches leave out a cell (``Model.resting``)."""
    return images.resting[cell] != 0


@wp.func
def cell_of_sample(images: NoImages, p: int) -> int:
    """The cell of a contact sample."""
    return 0


@wp.func
def cell_of_sample(images: Images32, p: int) -> int:
    """The cell of a contact sample."""
    return images.sample_cell[p]


@wp.func
def cell_of_sample(images: Images64, p: int) -> int:
    """The cell of a contact sample."""
    return images.sample_cell[p]


@wp.func
def apart_from_cell(images: NoImages, place: Vec3, cell: int, reach: Scalar) -> bool:
    """Whether a place is farther than a reach from the box around all segments of a cell."""
    return False


@wp.func
def apart_from_cell(images: Images32, place: wp.vec3f, cell: int, reach: wp.float32) -> bool:
    """Whether a place is farther than a reach from the box around all segments of a cell."""
    low, high = images.box[2 * cell], images.box[2 * cell + 1]
    return (
        place[0] < low[0] - reach or place[1] < low[1] - reach or place[2] < low[2] - reach
        or place[0] > high[0] + reach or place[1] > high[1] + reach or place[2] > high[2] + reach
    )  # fmt: skip


@wp.func
def apart_from_cell(images: Images64, place: wp.vec3d, cell: int, reach: wp.float64) -> bool:
    """Whether a place is farther than a reach from the box around all segments of a cell."""
    low, high = images.box[2 * cell], images.box[2 * cell + 1]
    return (
        place[0] < low[0] - reach or place[1] < low[1] - reach or place[2] < low[2] - reach
        or place[0] > high[0] + reach or place[1] > high[1] + reach or place[2] > high[2] + reach
    )  # fmt: skip


@wp.func
def grid_place(images: NoImages, place: Vec3, cell: int, pitch: Scalar) -> Any:
    """Coordinates of a place in the hash grid."""
    return place


@wp.func
def grid_place(images: Images32, place: wp.vec3f, cell: int, pitch: wp.float32) -> wp.vec3f:
    """Coordinates of a place in the hash grid, where the cells of different fabrics are far from each other."""
    along, up, out = cell % 10, (cell // 10) % 10, cell // 100
    return place + wp.vec3f(wp.float32(along), wp.float32(up), wp.float32(out)) * pitch


@wp.func
def grid_place(images: Images64, place: wp.vec3d, cell: int, pitch: wp.float64) -> wp.vec3d:
    """Coordinates of a place in the hash grid, where the cells of different fabrics are far from each other."""
    along, up, out = cell % 10, (cell // 10) % 10, cell // 100
    return place + wp.vec3d(wp.float64(along), wp.float64(up), wp.float64(out)) * pitch
