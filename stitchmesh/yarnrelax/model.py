# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The constants of a relaxation, on the device: who belongs to whom, rest lengths, quadrature, stiffnesses.

On the device lengths are in units of the mean yarn radius and relative to the middle of the yarns, so that single
precision keeps its digits whatever the units of the scene and wherever it lies. Energies stay in erg; a force is in
erg per unit. By the similarity of L section 6.2 the material is scaled to match.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.errors import ParameterError
from stitchmesh.yarn import YarnSet, basis
from stitchmesh.yarnrelax.curve import gauss_rule, leg_weights, sample_places
from stitchmesh.yarnrelax.image_table import put_images
from stitchmesh.yarnrelax.images import Images32, Images64, NoImages
from stitchmesh.yarnrelax.material import YarnMaterial
from stitchmesh.yarnrelax.neighbours import UNENDING, neighbour_reach
from stitchmesh.yarnrelax.precision import vector
from stitchmesh.yarnrelax.sampling import sample_counts

BLOCK = 64
"""Threads of a block on a GPU; small blocks spread a swatch over all of it, and large scenes lose nothing."""


@dataclass(frozen=True, eq=False)
class Model:
    """Constants on the device, and the host values that launches need."""

    yarns: YarnSet
    """The yarns as they were given [cm]."""
    material: YarnMaterial
    """Stiffnesses, for lengths in units."""
    device: wp.Device
    """Where the kernels run."""
    scalar: Any
    """Warp's floating-point type."""
    sample_start: NDArray[np.int64]
    """Where each segment's contact samples start, shape (S + 1,)."""
    quadrature_points: int
    """Gauss points a segment."""
    constants: Any
    """The struct that kernels receive."""

    @property
    def point_count(self) -> int:
        """Number of control points."""
        return len(self.yarns.points)

    @property
    def segment_count(self) -> int:
        """Number of segments."""
        return len(self.yarns.rest_length)

    @property
    def sample_count(self) -> int:
        """Number of contact samples."""
        return int(self.sample_start[-1])

    @cached_property
    def origin(self) -> NDArray[np.float64]:
        """Middle of the yarns [cm], the origin of positions on the device, shape (3,)."""
        return (self.yarns.points.min(axis=0) + self.yarns.points.max(axis=0)) / 2

    @cached_property
    def unit(self) -> float:
        """Length unit on the device [cm]: the mean yarn radius."""
        return float(self.yarns.radius.mean())

    @cached_property
    def size(self) -> float:
        """Largest coordinate of the yarns as given in units, at least one."""
        return max(float(np.abs(self.to_device(self.yarns.points)).max()), 1.0)

    @cached_property
    def radius(self) -> NDArray[np.float64]:
        """Radius of each yarn in units, shape (Y,)."""
        return self.yarns.radius / self.unit

    @cached_property
    def rest_length(self) -> NDArray[np.float64]:
        """Rest length of each segment in units, shape (S,)."""
        return self.yarns.rest_length / self.unit

    def to_device(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Positions [cm] in units from the origin, shape (n, 3)."""
        return (points - self.origin) / self.unit

    def from_device(self, points: wp.array[Any]) -> NDArray[np.float64]:
        """Positions [cm] of points on the device, shape (n, 3)."""
        return points.numpy().astype(np.float64) * self.unit + self.origin

    def upload(self, values: NDArray[Any], size: int = 1) -> wp.array[Any]:
        """An array of scalars, or of vectors of ``size``, on the device."""
        return wp.array(values, dtype=self.scalar if size == 1 else vector(size, self.scalar), device=self.device)

    def integers(self, values: NDArray[Any]) -> wp.array[Any]:
        """An array of 32-bit integers on the device."""
        return wp.array(values.astype(np.int32), dtype=wp.int32, device=self.device)

    def empty(self, count: int | tuple[int, int], size: int = 1) -> wp.array[Any]:
        """Zeros: scalars, or vectors of ``size``."""
        return wp.zeros(count, dtype=self.scalar if size == 1 else vector(size, self.scalar), device=self.device)

    def launch(
        self, kernel: wp.Kernel, count: int, inputs: list[Any], outputs: list[Any], *, tile: int = 0
    ) -> None:
        """Run a kernel once: ``count`` threads, or ``count`` blocks that share tiles of ``tile`` elements."""
        if tile:
            wp.launch_tiled(kernel, dim=count, inputs=inputs, outputs=outputs, device=self.device, block_dim=tile)
        else:
            wp.launch(kernel, count, inputs, outputs, device=self.device, block_dim=BLOCK)

    def record(
        self, kernel: wp.Kernel, count: int, inputs: list[Any], outputs: list[Any], *, tile: int = 0
    ) -> wp.Launch:
        """Prepare a launch that will be repeated; arguments as for ``launch``."""
        if tile:
            return wp.launch_tiled(
                kernel, dim=count, inputs=inputs, outputs=outputs, device=self.device, block_dim=tile, record_cmd=True
            )
        return wp.launch(kernel, count, inputs, outputs, device=self.device, block_dim=BLOCK, record_cmd=True)

    def number(self, value: float) -> Any:
        """A scalar for a kernel argument."""
        return self.scalar(value)


@functools.cache
def _constants_type(scalar: Any, images: Any) -> Any:
    """The struct of constants in one precision, with or without images; lengths in units."""
    scalars = wp.array(dtype=scalar)
    integers = wp.array(dtype=wp.int32)
    indices = wp.array(dtype=wp.vec4i)
    annotations = {
        "images": images,
        "segment_points": indices,
        "segment_rest_length": scalars,
        "segment_yarn": integers,
        "segment_skip": integers,
        "segment_cycle": integers,
        "yarn_step": wp.array(dtype=wp.vec2i),
        "yarn_segments": integers,
        "sample_start": integers,
        "sample_segment": integers,
        "sample_weight": scalars,
        "yarn_radius": scalars,
        "point_segments": indices,
        "rule": wp.array(dtype=vector(6, scalar)),
        "sample_basis": wp.array(dtype=vector(4, scalar)),
        "sample_legs": wp.array(dtype=vector(3, scalar)),
        "quadrature_points": wp.int32,
        "k_contact": scalar,
    }
    name = f"YarnConstants_{scalar.__name__}_{images.__name__ if hasattr(images, '__name__') else images.key}"
    return wp.struct(type(name, (), {"__annotations__": annotations}))


def put_model(
    yarns: YarnSet,
    material: YarnMaterial,
    *,
    quadrature_points: int,
    contact_samples: int,
    scalar: Any,
    device: wp.Device,
) -> Model:
    """Send everything that stays constant to the device.

    Args:
        yarns: the yarns, on a lattice or not.
        material: stiffnesses, CGS.
        quadrature_points: Gauss points a segment.
        contact_samples: contact samples a segment; a long segment gets as many as leave no gap (``sampling``).
        scalar: Warp's floating-point type.
        device: where the kernels run.

    Raises:
        ParameterError: fewer than one quadrature point or contact sample.
    """
    for name, count in (("quadrature_points", quadrature_points), ("contact_samples", contact_samples)):
        if count < 1:
            raise ParameterError(f"{name}: got {count}; expected at least 1")
    counts = sample_counts(yarns, contact_samples)
    kind = NoImages if yarns.lattice is None else Images32 if scalar is wp.float32 else Images64
    model = Model(
        yarns,
        material.scaled(1.0 / float(yarns.radius.mean())),
        device,
        scalar,
        np.concatenate([[0], np.cumsum(counts)]),
        quadrature_points,
        _constants_type(scalar, kind)(),
    )
    model.constants.images = put_images(model, kind)
    _put_segments(model)
    _put_samples(model, counts)
    _put_points(model)
    model.constants.rule = model.upload(gauss_rule(quadrature_points), 6)
    model.constants.quadrature_points = quadrature_points
    model.constants.k_contact = model.material.k_contact
    return model


def _put_segments(model: Model) -> None:
    yarns, constants = model.yarns, model.constants
    counts = np.diff(yarns.segment_start)
    returns = yarns.closed if yarns.lattice_step is None else yarns.closed & ~yarns.lattice_step.any(axis=1)
    steps = np.zeros((yarns.yarn_count, 2)) if yarns.lattice_step is None else yarns.lattice_step
    constants.yarn_step = wp.array(steps.astype(np.int32), dtype=wp.vec2i, device=model.device)
    constants.yarn_segments = model.integers(counts)
    constants.segment_points = wp.array(yarns.segment_points.astype(np.int32), dtype=wp.vec4i, device=model.device)
    constants.segment_rest_length = model.upload(model.rest_length)
    constants.segment_yarn = model.integers(yarns.segment_yarn)
    constants.segment_skip = model.integers(neighbour_reach(yarns))
    constants.segment_cycle = model.integers(np.where(returns, counts, UNENDING)[yarns.segment_yarn])


def _put_samples(model: Model, counts: NDArray[np.int64]) -> None:
    constants = model.constants
    place = sample_places(int(counts.max()))
    constants.sample_start = model.integers(model.sample_start)
    constants.sample_segment = model.integers(np.repeat(np.arange(model.segment_count), counts))
    constants.sample_weight = model.upload(np.repeat(model.rest_length / counts, counts))
    constants.sample_basis = model.upload(basis(place), 4)
    constants.sample_legs = model.upload(leg_weights(place), 3)
    constants.yarn_radius = model.upload(model.radius)


def _put_points(model: Model) -> None:
    yarns = model.yarns
    slots = np.full((len(yarns.points), 4), -1, dtype=np.int32)
    segments = np.arange(model.segment_count)
    for slot in range(4):
        slots[yarns.segment_points[:, slot], slot] = segments
    model.constants.point_segments = wp.array(slots, dtype=wp.vec4i, device=model.device)
