# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Images on a lattice: the places of the neighbours of an element in a periodic fabric.

An element may refer to a control point or a contact sample in another image. The place of that point is its own place
plus a u + b v, with the periods u and v and a stored integer image (a, b) (design, section 2). Images are numbered in a
table. Several fabrics may be relaxed together, each in a cell with its own periods; all cells share the table. A fabric
without a lattice has no images. For it, overloads of the functions below read only the place, so that no kernel tests
whether a fabric is periodic. Functions that only the search for pairs needs are in ``collision/broad_phase``.
"""

# overloads, which Warp distinguishes by the types of their arguments
# ruff: noqa: F811
# mypy: disable-error-code="no-redef"

from __future__ import annotations

import functools
from typing import Any, TypeAlias

import warp as wp

from stitchmesh.compute.kernel_variants import KernelForm, named_type
from stitchmesh.compute.precision import ScalarType, Vec3, Vec4, vector

LatticeImages: TypeAlias = Any
"""The struct of ``images_struct`` in either precision, or ``NoImages``."""
named_type("LatticeImages", lambda form: [images_of(form)])


@wp.struct
class NoImages:
    """A fabric without a lattice."""

    sample_count: wp.int32


@functools.cache
def images_struct(scalar: ScalarType, *, on_lattice: bool) -> Any:
    """Return the struct of periods and numbered images in one precision, or the one of a fabric without a lattice."""
    if not on_lattice:
        return NoImages
    threes, integers = wp.array(dtype=vector(3, scalar)), wp.array(dtype=wp.int32)
    annotations = {
        "sample_count": wp.int32,
        "periods": threes,
        "image": wp.array(dtype=wp.vec2i),
        "corner_image": wp.array(dtype=wp.vec4i),
        "segment_cell": integers,
        "resting": integers,
        "sample_cell": integers,
        "box": threes,
        "frame": threes,
    }
    return wp.struct(type(f"Images_{scalar.__name__}", (), {"__annotations__": annotations}))


def images_of(form: KernelForm) -> Any:
    """Return the struct of the images of a form."""
    return images_struct(form.scalar, on_lattice=form.on_lattice)


def images_with(images: Any, struct: Any, *, table: wp.array[Any], periods: wp.array[Any]) -> Any:
    """Return images with another table or other periods; ``struct`` is the struct of ``images_struct`` on a lattice."""
    other = struct()
    for name in struct.vars:
        setattr(other, name, getattr(images, name))
    other.image, other.periods = table, periods
    return other


@wp.func
def image_shift(images: LatticeImages, cell: int, number: int) -> Any:
    """Displacement of an image of a cell on a lattice."""
    ab = images.image[number]
    u, v = images.periods[2 * cell], images.periods[2 * cell + 1]
    return u * type(u[0])(ab[0]) + v * type(u[0])(ab[1])


@wp.func
def exact_shift(images: NoImages, cell: int, number: int) -> wp.vec3d:
    """Displacement of an image of a cell in double precision: zero without a lattice."""
    return wp.vec3d()


@wp.func
def exact_shift(images: LatticeImages, cell: int, number: int) -> wp.vec3d:
    """Displacement of an image of a cell in double precision."""
    ab = images.image[number]
    u, v = wp.vec3d(images.periods[2 * cell]), wp.vec3d(images.periods[2 * cell + 1])
    return u * wp.float64(ab[0]) + v * wp.float64(ab[1])


@wp.func
def corner_place(images: NoImages, points: wp.array[Vec3], s: int, slot: int, point: int) -> Any:
    """Place of control point ``slot`` of segment ``s``."""
    return points[point]


@wp.func
def corner_place(images: LatticeImages, points: wp.array[Vec3], s: int, slot: int, point: int) -> Any:
    """Place of control point ``slot`` of segment ``s``, in the image of the segment."""
    return points[point] + image_shift(images, images.segment_cell[s], images.corner_image[s][slot])


@wp.func
def sample_number(images: NoImages, entry: int) -> int:
    """Sample of an entry of a candidate list."""
    return entry


@wp.func
def sample_number(images: LatticeImages, entry: int) -> int:
    """Sample of an entry of a candidate list."""
    return entry % images.sample_count


@wp.func
def shifted_by(images: NoImages, place: Vec3, cell: int, number: int) -> Any:
    """A place in an image."""
    return place


@wp.func
def shifted_by(images: LatticeImages, place: Vec3, cell: int, number: int) -> Any:
    """A place in an image."""
    return place + image_shift(images, cell, number)


@wp.func
def image_of(images: NoImages, entry: int, count: int) -> int:
    """Image of a list entry that is image * ``count`` + number."""
    return 0


@wp.func
def image_of(images: LatticeImages, entry: int, count: int) -> int:
    """Image of a list entry that is image * ``count`` + number."""
    return entry // count


@wp.func
def entry_shift(images: NoImages, zero: Vec4, p: int, entry: int) -> Any:
    """Displacement of the lattice image of an entry in the list of sample ``p``: zero without a lattice."""
    return zero


@wp.func
def entry_shift(images: LatticeImages, zero: Vec4, p: int, entry: int) -> Any:
    """Displacement of the lattice image of an entry in the list of sample ``p``; the fourth component is 0."""
    shift = image_shift(images, images.sample_cell[p], entry // images.sample_count)
    return type(zero)(shift[0], shift[1], shift[2], zero[3])


@wp.func
def cell_of(images: NoImages, s: int) -> int:
    """The cell of a segment."""
    return 0


@wp.func
def cell_of(images: LatticeImages, s: int) -> int:
    """The cell of a segment."""
    return images.segment_cell[s]


@wp.func
def rests(images: NoImages, cell: int) -> bool:
    """Whether launches leave out a cell (``Model.resting``); the only piece takes part in all."""
    return False


@wp.func
def rests(images: LatticeImages, cell: int) -> bool:
    """Whether launches leave out a cell (``Model.resting``)."""
    return images.resting[cell] != 0


@wp.func
def cell_of_sample(images: NoImages, p: int) -> int:
    """The cell of a contact sample."""
    return 0


@wp.func
def cell_of_sample(images: LatticeImages, p: int) -> int:
    """The cell of a contact sample."""
    return images.sample_cell[p]
