# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The constants of a relaxation, on the device: who belongs to whom, rest lengths, quadrature, stiffnesses."""

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
from stitchmesh.yarnrelax.curve import gauss_rule, leg_weights
from stitchmesh.yarnrelax.material import YarnMaterial
from stitchmesh.yarnrelax.precision import vector

OPEN_YARN = 1 << 30
"""Cycle of an open yarn's segments: no number of segments leads back to the first."""


@dataclass(frozen=True, eq=False)
class Model:
    """Constants on the device, and the host values that launches need."""

    yarns: YarnSet
    """The yarns as they were given."""
    material: YarnMaterial
    """Stiffnesses, in the units of the yarns."""
    device: wp.Device
    """Where the kernels run."""
    scalar: Any
    """Warp's floating-point type."""
    contact_samples: int
    """Contact samples a segment."""
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

    @cached_property
    def origin(self) -> NDArray[np.float64]:
        """Middle of the yarns [cm]; positions are relative to it, which saves float32 its digits, shape (3,)."""
        return (self.yarns.points.min(axis=0) + self.yarns.points.max(axis=0)) / 2

    @property
    def sample_count(self) -> int:
        """Number of contact samples."""
        return self.segment_count * self.contact_samples

    def upload(self, values: NDArray[Any], size: int = 1) -> wp.array[Any]:
        """An array of scalars, or of vectors of ``size``, on the device."""
        return wp.array(values, dtype=self.scalar if size == 1 else vector(size, self.scalar), device=self.device)

    def empty(self, count: int, size: int = 1) -> wp.array[Any]:
        """Zeros: scalars, or vectors of ``size``."""
        return wp.zeros(count, dtype=self.scalar if size == 1 else vector(size, self.scalar), device=self.device)

    def launch(self, kernel: wp.Kernel, count: int, inputs: list[Any], outputs: list[Any]) -> None:
        """Run a kernel once."""
        wp.launch(kernel, dim=count, inputs=inputs, outputs=outputs, device=self.device)

    def record(self, kernel: wp.Kernel, count: int, inputs: list[Any], outputs: list[Any]) -> wp.Launch:
        """Prepare a launch that will be repeated."""
        return wp.launch(kernel, dim=count, inputs=inputs, outputs=outputs, device=self.device, record_cmd=True)

    def number(self, value: float) -> Any:
        """A scalar for a kernel argument."""
        return self.scalar(value)


@functools.cache
def _constants_type(scalar: Any) -> Any:
    """The struct of constants in one precision; units as in ``YarnSet`` and ``YarnMaterial``."""
    scalars = wp.array(dtype=scalar)
    integers = wp.array(dtype=wp.int32)
    indices = wp.array(dtype=wp.vec4i)
    annotations = {
        "segment_points": indices,
        "segment_rest_length": scalars,
        "segment_yarn": integers,
        "segment_skip": integers,
        "segment_cycle": integers,
        "sample_radius": scalars,
        "sample_weight": scalars,
        "point_segments": indices,
        "point_radius": scalars,
        "rule": wp.array(dtype=vector(6, scalar)),
        "sample_basis": wp.array(dtype=vector(4, scalar)),
        "sample_legs": wp.array(dtype=vector(3, scalar)),
        "quadrature_points": wp.int32,
        "contact_samples": wp.int32,
        "k_len": scalar,
        "k_length": scalar,
        "k_bend": scalar,
        "k_contact": scalar,
    }
    return wp.struct(type(f"YarnConstants_{scalar.__name__}", (), {"__annotations__": annotations}))


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

    Raises:
        ParameterError: fewer than one quadrature point or contact sample, or yarns on a lattice.
    """
    for name, count in (("quadrature_points", quadrature_points), ("contact_samples", contact_samples)):
        if count < 1:
            raise ParameterError(f"{name}: got {count}; expected at least 1")
    if yarns.lattice is not None:
        raise ParameterError("yarns: got a set with a lattice; relaxation takes yarns without one")
    model = Model(yarns, material, device, scalar, contact_samples, _constants_type(scalar)())
    _put_segments(model)
    _put_samples(model)
    _put_points(model)
    model.constants.rule = model.upload(gauss_rule(quadrature_points), 6)
    model.constants.quadrature_points = quadrature_points
    for name in ("k_len", "k_length", "k_bend", "k_contact"):
        setattr(model.constants, name, getattr(material, name))
    return model


def _put_segments(model: Model) -> None:
    yarns, constants = model.yarns, model.constants
    counts = np.diff(yarns.segment_start)
    cycle = np.where(yarns.closed, counts, OPEN_YARN)[yarns.segment_yarn]
    constants.segment_points = wp.array(yarns.segment_points.astype(np.int32), dtype=wp.vec4i, device=model.device)
    constants.segment_rest_length = model.upload(yarns.rest_length)
    integers = {"segment_yarn": yarns.segment_yarn, "segment_skip": neighbour_reach(yarns), "segment_cycle": cycle}
    for name, values in integers.items():
        setattr(constants, name, wp.array(values.astype(np.int32), dtype=wp.int32, device=model.device))


def _put_samples(model: Model) -> None:
    count, constants = model.contact_samples, model.constants
    place = (np.arange(count) + 0.5) / count
    constants.contact_samples = count
    constants.sample_basis = model.upload(basis(place), 4)
    constants.sample_legs = model.upload(leg_weights(place), 3)
    constants.sample_radius = model.upload(np.repeat(model.yarns.radius[model.yarns.segment_yarn], count))
    constants.sample_weight = model.upload(np.repeat(model.yarns.rest_length / count, count))


def _put_points(model: Model) -> None:
    yarns = model.yarns
    slots = np.full((len(yarns.points), 4), -1, dtype=np.int32)
    segments = np.arange(model.segment_count)
    for slot in range(4):
        slots[yarns.segment_points[:, slot], slot] = segments
    model.constants.point_segments = wp.array(slots, dtype=wp.vec4i, device=model.device)
    model.constants.point_radius = model.upload(yarns.radius[yarns.point_yarn])


def neighbour_reach(yarns: YarnSet) -> NDArray[np.int64]:
    """How many of the segments that follow each segment do not collide with it, shape (S,).

    The model exempts the next segment only, which is sound while a segment is as long as the yarn is thick: two
    segments collide once the rest length between them is at least a diameter. Finer segments are exempt until it
    is, or a straight yarn would push itself apart.
    """
    reach = np.ones(len(yarns.rest_length), dtype=np.int64)
    diameter = 2.0 * yarns.radius
    for yarn in range(yarns.yarn_count):
        first, last = yarns.segment_start[yarn], yarns.segment_start[yarn + 1]
        lengths = yarns.rest_length[first:last]
        if lengths.min() >= diameter[yarn]:
            continue
        count = len(lengths)
        turns = int(np.ceil(diameter[yarn] / lengths.sum())) + 1 if yarns.closed[yarn] else 1
        ends = np.cumsum(np.tile(lengths, turns + 1)) if yarns.closed[yarn] else np.cumsum(lengths)
        # the rest length between segments i and i + m + 1 is ends[i + m] - ends[i]; the factor forgives rounding
        wanted = ends[:count] + diameter[yarn] * (1 - 1e-9)
        reach[first:last] = np.maximum(np.searchsorted(ends, wanted) - np.arange(count), 1)
    return np.minimum(reach, OPEN_YARN)
