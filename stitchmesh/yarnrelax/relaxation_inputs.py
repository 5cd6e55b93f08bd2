# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The inputs of a relaxation: checked, with defaults, and as a fingerprint for checkpoints."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import warp as wp

from stitchmesh import __version__
from stitchmesh.compute.device import device_named
from stitchmesh.errors import ParameterError, check_kind
from stitchmesh.memory_need import check_relaxation_memory
from stitchmesh.mesh import FloatArray, StitchMesh
from stitchmesh.quality import Quality, quality_named
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.constraints.borders import KeepBorders
from stitchmesh.yarnrelax.energies.shape import KeepShape
from stitchmesh.yarnrelax.energies.term import (
    Choice,
    ConstraintChoice,
    YarnChoice,
    refuse_in_free_cells,
    terms_and_constraints,
)
from stitchmesh.yarnrelax.fingerprint import fingerprint, yarn_fingerprint
from stitchmesh.yarnrelax.model.material import YarnMaterial, material_of
from stitchmesh.yarnrelax.simulation import YarnSimulation
from stitchmesh.yarnrelax.solvers.cell_strain import RelaxCell

MASSES = ("yarns.mass_per_length", "material.mass_per_length")
"""Inputs that older checkpoints hold even if nothing reads the mass."""


@dataclass(frozen=True, eq=False)
class RelaxationInputs:
    """Everything from which a relaxation follows; the arguments of ``relax_yarns``."""

    yarns: YarnSet
    material: YarnMaterial
    quality: Quality
    device: wp.Device
    terms: Sequence[YarnChoice] = ()
    constraints: Sequence[ConstraintChoice] = ()
    points: FloatArray | None = None
    """Control points to start from [cm], shape (N, 3); None for the points of the yarns."""
    cell: RelaxCell | None = None

    def start(self) -> YarnSimulation:
        """Return a simulation with these inputs.

        Raises:
            OverloadError: the yarns are too close to each other.
        """
        return YarnSimulation.start(
            self.yarns, self.material, self.quality, self.device, self.terms, self.constraints, self.points,
            cell=self.cell,
        )  # fmt: skip

    def fingerprint(self) -> dict[str, str]:
        """Return the inputs of a relaxation as short strings, without the start and without masses that nothing reads.

        Raises:
            ParameterError: a term or a constraint has a value that cannot be compared.
        """
        found = {"stitchmesh": __version__, "device": "cuda" if self.device.is_cuda else "cpu"}
        yarn = yarn_fingerprint(self.yarns) | fingerprint("material", self.material)
        found |= {key: value for key, value in yarn.items() if key not in MASSES}
        found |= fingerprint("quality", self.quality, without=("tolerance", "largest_change", "max_iterations"))
        found |= {"cell": "kept"} if self.cell is None else fingerprint("cell", self.cell)
        for kind, choices in (("term", self.terms), ("constraint", self.constraints)):
            for number, choice in enumerate(choices):
                name = f"{kind} {number}"
                found |= {name: type(choice).__name__} | fingerprint(f"{name} ({type(choice).__name__})", choice)
        if self.quality.solver == "dynamics" or any(term.reads_mass for term in self.terms):
            found |= {key: yarn[key] for key in MASSES if key in yarn}
        return found


def checked_inputs(
    yarns: YarnSet,
    material: YarnMaterial | None,
    quality: str | Quality,
    device: str | None,
    keep_shape: StitchMesh | None,
    choices: Sequence[Choice],
    cell: RelaxCell | None,
    start: YarnSet | None,
) -> RelaxationInputs:
    """Check the arguments of ``relax_yarns``, and return them with their defaults.

    Raises:
        ParameterError: an argument does not fit the yarns, or the relaxation does not fit the memory.
    """
    chosen = quality_named(quality)
    on_device = device_named(device)
    place = f"a relaxation of {len(yarns.points):,} control points"
    check_relaxation_memory(place, len(yarns.points), chosen, device)
    if material is None:
        material = material_of(yarns)
    check_kind("relax_yarns, material", material, YarnMaterial)
    terms, constraints = terms_and_constraints(choices)
    if keep_shape is not None:
        check_kind("relax_yarns, keep_shape", keep_shape, StitchMesh)
        terms.append(KeepShape(keep_shape))
        constraints.append(KeepBorders(keep_shape))
    points = None if start is None else _start_points(start, yarns)
    if cell is not None:
        refuse_in_free_cells(terms, constraints)
    return RelaxationInputs(yarns, material, chosen, on_device, terms, constraints, points, cell)


def _start_points(start: YarnSet, yarns: YarnSet) -> FloatArray:
    """Return control points of the same yarns to start from [cm], shape (N, 3).

    Raises:
        ParameterError: ``start`` holds other yarns.
    """
    if not (np.array_equal(start.start, yarns.start) and np.array_equal(start.closed, yarns.closed)):
        found = f"{start.yarn_count} yarns of {len(start.points)} control points"
        expected = f"{yarns.yarn_count} of {len(yarns.points)}, closed where they are"
        raise ParameterError(f"start: got {found}; expected the same yarns, {expected}")
    return start.points
