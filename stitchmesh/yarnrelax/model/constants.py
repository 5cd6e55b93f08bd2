# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The constants of a relaxation on the device: topology, rest lengths, quadrature and stiffnesses.

On the device, lengths are in units of the mean yarn radius and relative to the middle of the yarns, so that single
precision keeps its digits whatever the units and the position of the scene. Energies stay in erg, so a force is in erg
per unit. By the similarity of L section 6.2 the material is scaled to match. ``upload`` creates a model.
"""

from __future__ import annotations

import functools
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.kernel_variants import named_type
from stitchmesh.compute.launch import launch, prepare
from stitchmesh.compute.precision import ScalarType, vector
from stitchmesh.yarnrelax.model.cells import CellTables
from stitchmesh.yarnrelax.model.lattice_images import images_of, images_struct
from stitchmesh.yarnrelax.model.material import carried_lengths, point_masses

YarnConstants: TypeAlias = Any
"""The struct of ``constants_struct``, in either precision, with or without images."""
YarnContact: TypeAlias = Any
"""``StiffContact`` or ``SoftContact``."""
CellConstants: TypeAlias = Any
"""``YarnConstants`` with images: those of yarns on a lattice."""
ExactConstants: TypeAlias = Any
"""``CellConstants`` in double precision."""


@dataclass(frozen=True, eq=False)
class Model(CellTables):
    """The constants on the device, and the host values that launches need."""

    device: wp.Device
    """Where the kernels run."""
    scalar: ScalarType
    """Warp's floating-point type."""
    sample_start: NDArray[np.int64]
    """Where each segment's contact samples start, shape (S + 1,)."""
    quadrature_points: int
    """Number of Gauss points in a segment."""
    constants: Any
    """The struct that kernels receive."""

    @property
    def sample_count(self) -> int:
        """Number of contact samples."""
        return int(self.sample_start[-1])

    @cached_property
    def cell_points(self) -> wp.array[Any]:
        """``point_start`` on the device."""
        return self.integers(self.point_start)

    @cached_property
    def cell_segments(self) -> wp.array[Any]:
        """``segment_start`` on the device."""
        return self.integers(self.segment_start)

    @cached_property
    def cell_samples(self) -> wp.array[Any]:
        """Where each cell's contact samples start, on the device."""
        return self.integers(self.sample_start[self.segment_start])

    @cached_property
    def resting(self) -> wp.array[Any]:
        """1 for each cell that the launches of forces and of Hessians leave out, else 0, shape (C,)."""
        return self.integers(np.zeros(self.cell_count))

    @contextmanager
    def only_in(self, cells: NDArray[np.bool_] | None) -> Iterator[None]:
        """In this block, leave out all but ``cells``, shape (C,), and cells that launches mark; None changes nothing.

        For a cell that is left out, the output of a launch keeps its last value. A block within another one replaces
        its choice.
        """
        if cells is None:
            yield
            return
        outer = self._left_out[-1] if self._left_out else np.zeros_like(cells)
        self._leave_out(~cells, outer)
        self._left_out.append(~cells)
        try:
            yield
        finally:
            self._left_out.pop()
            self._leave_out(outer, ~cells)

    @cached_property
    def _left_out(self) -> list[NDArray[np.bool_]]:
        """The cells that the open blocks of ``only_in`` leave out, each of shape (C,)."""
        return []

    def _leave_out(self, cells: NDArray[np.bool_], before: NDArray[np.bool_]) -> None:
        """Leave out these cells instead of those before, shape (C,)."""
        if (cells != before).any():
            self.resting.assign(cells)

    @cached_property
    def largest_cell(self) -> int:
        """Number of contact samples of the cell with the most."""
        return int(np.diff(self.sample_start[self.segment_start]).max())

    def upload(self, values: NDArray[Any], size: int = 1) -> wp.array[Any]:
        """Return an array of scalars, or of vectors of ``size``, on the device."""
        return wp.array(values, dtype=self.scalar if size == 1 else vector(size, self.scalar), device=self.device)

    @property
    def entries_at_once(self) -> int:
        """Number of entries of a candidate list that a thread loads at the same time."""
        return entries_at_once(on_gpu=self.device.is_cuda)

    def integers(self, values: NDArray[Any]) -> wp.array[Any]:
        """Return an array of 32-bit integers on the device."""
        return wp.array(values.astype(np.int32), dtype=wp.int32, device=self.device)

    def empty(self, count: int | tuple[int, int], size: int = 1) -> wp.array[Any]:
        """Return an array of zeros: scalars, or vectors of ``size``."""
        return wp.zeros(count, dtype=self.scalar if size == 1 else vector(size, self.scalar), device=self.device)

    def launch(self, kernel: wp.Kernel, count: int, inputs: list[Any], outputs: list[Any]) -> None:
        """Run a kernel once: ``count`` threads, or ``count`` blocks."""
        launch(kernel, count, inputs, outputs, self.device)

    def prepare(self, kernel: wp.Kernel, count: int, inputs: list[Any], outputs: list[Any]) -> wp.Launch:
        """Prepare a launch that will be repeated, with the arguments of ``launch``."""
        return prepare(kernel, count, inputs, outputs, self.device)

    def masses(self) -> list[NDArray[np.float64]]:
        """Mass of each control point [g], shape (N,), as a list of one array (``simulation.term.LoadedPoints``).

        Raises:
            ParameterError: a yarn has no mass.
        """
        return [point_masses(self)]

    def areas(self) -> list[NDArray[np.float64]]:
        """Diameter times length of the yarn that each control point carries [cm^2], as a list of one array."""
        carried = carried_lengths(self.rest_length, self.yarns.segment_points, self.point_count)
        return [2.0 * self.radius[self.yarns.point_yarn] * carried * self.unit**2]

    def number(self, value: float) -> Any:
        """Return a scalar for a kernel argument."""
        return self.scalar(value)

    def numbers(self, *values: float) -> Any:
        """Return a vector of scalars for a kernel argument."""
        return vector(len(values), self.scalar)(*(float(value) for value in values))


def entries_at_once(*, on_gpu: bool) -> int:
    """Return the number of entries of a candidate list that a thread loads at the same time."""
    return 4 if on_gpu else 1


@wp.struct
class StiffContact:
    """The usual law of contact, for which the kernels are compiled without any other law."""

    unused: wp.int32


@wp.struct
class SoftContact:
    """Samples of which some have van Wyk's law."""

    soft: wp.array[wp.int32]
    """1 for a sample with van Wyk's law, shape (P,)."""


@functools.cache
def constants_struct(scalar: ScalarType, images: Any, contact: Any = StiffContact) -> Any:
    """Return the struct of constants in one precision, with or without images; lengths are in units."""
    scalars = wp.array(dtype=scalar)
    integers = wp.array(dtype=wp.int32)
    indices = wp.array(dtype=wp.vec4i)
    annotations = {
        "images": images,
        "contact": contact,
        "segment_points": indices,
        "segment_rest_length": scalars,
        "segment_yarn": integers,
        "segment_stiffness": wp.array(dtype=vector(3, scalar)),
        "segment_natural": wp.array(dtype=vector(2, scalar)),
        "segment_skip": integers,
        "segment_cycle": integers,
        "yarn_step": wp.array(dtype=wp.vec2i),
        "yarn_segments": integers,
        "sample_start": integers,
        "sample_segment": integers,
        "sample_weight": scalars,
        "sample_stiffness": scalars,
        "yarn_radius": scalars,
        "point_segments": indices,
        "rule": wp.array(dtype=vector(6, scalar)),
        "sample_basis": wp.array(dtype=vector(4, scalar)),
        "sample_legs": wp.array(dtype=vector(3, scalar)),
        "quadrature_points": wp.int32,
    }
    name = f"YarnConstants_{scalar.__name__}_{images.__name__ if hasattr(images, '__name__') else images.key}"
    name += "_soft" * (contact is SoftContact)
    return wp.struct(type(name, (), {"__annotations__": annotations}))


named_type("YarnConstants", lambda form: [constants_struct(form.scalar, images_of(form))])
named_type("CellConstants", lambda form: [constants_struct(form.scalar, images_of(form))] if form.on_lattice else [])
named_type(
    "ExactConstants",
    lambda form: [constants_struct(wp.float64, images_struct(wp.float64, on_lattice=True))] if form.on_lattice else [],
)
