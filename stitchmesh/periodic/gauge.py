# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Measurements of a relaxed swatch: spacings, yarn length, thickness, areal density, stress and moments of curling."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from stitchmesh.lattice import lattice_frame
from stitchmesh.mesh import FloatArray, StitchMesh
from stitchmesh.periodic.fabric_shape import thickness_of
from stitchmesh.periodic.relaxation.continuation import size_of
from stitchmesh.quality import Quality
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.yarn_presets import Gauge
from stitchmesh.yarnrelax import YarnMaterial
from stitchmesh.yarnrelax.cell_stress import cell_stress

if TYPE_CHECKING:
    from stitchmesh.yarnrelax.energies.twist import Twist


@dataclass(frozen=True, kw_only=True)
class FabricMeasures:
    """What a ruler and scales measure on a piece of fabric."""

    width: float
    """Width of the repeat [cm]."""
    height: float
    """Height of the repeat, at right angles to its width [cm]."""
    shear: float
    """Displacement of the wales along the courses over the height."""
    spirality: float
    """Angle of the wales to the normal of the courses [degrees]; positive if the wales lean to the right."""
    wales: int
    """Number of wales, or of warps of a weave."""
    courses: int
    """Number of courses, or of wefts of a weave."""
    stitches: int
    """Number of stitches, or of crossings of a weave."""
    control_points: int
    """Number of control points of the yarns."""
    wale_spacing: float
    """Distance of adjacent wales or warps [cm]."""
    course_spacing: float
    """Distance of adjacent courses or wefts [cm]."""
    gauge: Gauge
    """Stitches and rows in 10 cm; warps and wefts in 10 cm of a weave."""
    loop_length: float
    """Actual length of the yarn in one stitch, or at one crossing of a weave [cm]."""
    thickness: float
    """Distance of the two planes between which the fabric lies, measured at the contact radius [cm]."""
    areal_density: float
    """Mass over area [g/cm^2]."""


def measure_fabric(yarns: YarnSet, fabric: StitchMesh | None, mass_per_length: float) -> FabricMeasures:
    """Measure one repeat. This launches no kernel, so that a frame of a live swatch can be measured while it relaxes.

    Args:
        yarns: the yarns, on their lattice.
        fabric: the stitch mesh from which the yarns were generated; None for a weave.
        mass_per_length: the mass per length [g/cm] of yarns that state none.
    """
    assert yarns.lattice is not None
    width, height = size_of(yarns.lattice)
    shear = float(yarns.lattice.periods[1] @ lattice_frame(yarns.lattice.periods)[0]) / height
    wales, courses, stitches = counts_of(yarns, fabric)
    length = float(yarns.lengths.sum())
    return FabricMeasures(
        width=width, height=height, shear=shear, spirality=math.degrees(math.atan(shear)),
        wales=wales, courses=courses, stitches=stitches, control_points=len(yarns.points),
        wale_spacing=width / wales, course_spacing=height / courses,
        gauge=Gauge.of_stitch(width / wales, height / courses),
        loop_length=length / stitches,
        thickness=thickness_of(yarns),
        areal_density=yarns.mass(mass_per_length) / (width * height),
    )  # fmt: skip


def swatch_report(
    yarns: YarnSet, fabric: StitchMesh | None, material: YarnMaterial, quality: Quality, energy: float,
    device: str | None = None, twist: Twist | None = None,
) -> dict[str, Any]:  # fmt: skip
    """Measure a swatch; all values are plain numbers.

    Args:
        yarns: the relaxed yarns, on their lattice.
        fabric: the stitch mesh from which the yarns were generated; None for a weave.
        material: material of the yarns.
        quality: resolution that was used for the relaxation.
        energy: energy of the relaxed repeat [erg].
        device: device of the kernels, for example ``cpu`` or ``cuda:0``.
        twist: the twist of the yarns; None for yarns without torque.

    Returns:
        - the fields of ``FabricMeasures``;
        - course_tension, wale_tension and shear_stress [dyn/cm] that keep the repeat at its size;
        - course_moment and wale_moment [dyn], positive if they curl the courses and the wales towards the right side;
        - energy_per_stitch [erg];
        - yarns_in_row: largest number of yarns in a row of a knit; all but one of them float;
        - warp_crimp and weft_crimp [1] of a weave.
    """
    measures = measure_fabric(yarns, fabric, material.mass_per_length)
    stress = cell_stress(
        yarns, material, quadrature_points=quality.quadrature_points,
        contact_samples=quality.contact_samples, device=device, **({} if twist is None else {"twist": twist}),
    )  # fmt: skip
    report = asdict(measures) | {
        "course_tension": stress.course,
        "wale_tension": stress.wale,
        "shear_stress": stress.shear,
        "course_moment": stress.course_moment,
        "wale_moment": stress.wale_moment,
        "energy_per_stitch": energy / measures.stitches,
    }
    return report | (_crimp(yarns) if fabric is None else {"yarns_in_row": _most_yarns_in_a_row(fabric)})


def _most_yarns_in_a_row(fabric: StitchMesh) -> int:
    rows, _ = np.unique(np.stack([fabric.row, fabric.yarn]), axis=1)
    return int(np.unique(rows, return_counts=True)[1].max())


def counts_of(yarns: YarnSet, fabric: StitchMesh | None) -> tuple[int, int, int]:
    """Return the numbers of wales, courses and stitches of a repeat, or of warps, wefts and crossings of a weave."""
    if fabric is None:
        assert yarns.lattice_step is not None
        wefts, warps = (int((yarns.lattice_step[:, axis] != 0).sum()) for axis in (0, 1))
        return warps, wefts, warps * wefts
    wales = int(fabric.n_bottom[fabric.row == fabric.row.min()].sum())
    return wales, len(np.unique(fabric.row)), fabric.face_count


def _crimp(yarns: YarnSet) -> dict[str, float]:
    """Return the crimp of the warps and of the wefts: length over straight length, minus one."""
    assert yarns.lattice is not None and yarns.lattice_step is not None
    length = np.add.reduceat(yarns.lengths, yarns.segment_start[:-1])
    straight: FloatArray = np.linalg.norm(yarns.lattice.shift(yarns.lattice_step), axis=1)
    crimp = length / straight - 1.0
    is_weft = yarns.lattice_step[:, 0] != 0
    return {"warp_crimp": float(crimp[~is_weft].mean()), "weft_crimp": float(crimp[is_weft].mean())}
