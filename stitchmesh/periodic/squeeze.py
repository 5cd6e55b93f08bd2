# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Squeeze tests: thickness of a free swatch against the pressure of two plates, and how flat its yarn becomes.

The swatch is first relaxed without stress and without friction. It then lies between two plates (``Plates``), which
touch it and approach step by step. In each state the yarns relax, while width and height of the cell keep their
values, as they do in a tester of thickness, where friction holds the fabric. With the energy e of yarns and plates over
the area of the fabric and the distance T of the plates, which is the thickness, the pressure is -de / dT.

Yarn is as soft as its material says. By the law of van Wyk (``YarnMaterial.compressed_by``) it is a mass of fibres, and
the thickness under a high pressure p follows p^(-1/3). The radius of the yarn is then the radius at which its fibres
begin to touch others, the one that is seen, and not the one of a core.

Cross-sections flatten where they are squeezed: at constant width, a section is as high as the distance of the axes of
two equal yarns (``flattening``). The model has one radius in all directions, so a section that is flat at one contact
is not wider at the next.
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from stitchmesh.errors import ParameterError, check_kind
from stitchmesh.io.contents import FilePath
from stitchmesh.lattice import lattice_frame
from stitchmesh.linking.certificate import refuse_pull_through
from stitchmesh.mesh import FloatArray
from stitchmesh.patterns import Pattern
from stitchmesh.periodic.relaxation.prepared_swatch import prepare_swatch
from stitchmesh.periodic.relaxation.way_to_rest import relax_with_digits
from stitchmesh.periodic.stretch import refine_for_tension, write_points
from stitchmesh.periodic.swatch import Swatch, relax_prepared
from stitchmesh.periodic.validated_range import NOT_JUDGED, RangeVerdict, fabric_of, thickness_verdict
from stitchmesh.periodic.weave.weave import Weave
from stitchmesh.quality import DEFAULT_QUALITY, Quality, quality_named
from stitchmesh.run import SHOWN, Run
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import YarnMaterial
from stitchmesh.yarnrelax.energies.plates import Plates, plates_pressure

logger = logging.getLogger(__name__)

LEAST_PART = 0.2
"""Smallest part of the free thickness to which a fabric is squeezed."""
LARGEST_STEP = 0.05
"""Largest relative change of the thickness at a time."""
LIGHT, HEAVY = 0.5 * 980.665, 50.0 * 980.665
"""Pressures between which testers state compressibility [dyn/cm^2]: 0.5 and 50 gf/cm^2 (KES-FB3, Kawabata 1980)."""


@dataclass(frozen=True)
class SqueezePoint:
    """One relaxed state of a squeeze test."""

    thickness: float
    """Distance of the plates [cm]."""
    pressure: float
    """Pressure of each plate [dyn/cm^2]."""
    energy: float
    """Energy of yarns and plates over the area of the fabric [erg/cm^2]."""
    flattening: float
    """Height of the flattest cross-section over its width: the smallest distance of two axes in diameters."""
    residual: float
    """Relative force residual."""
    converged: bool
    """Whether the relaxation converged."""


@dataclass(frozen=True, eq=False)
class SqueezeCurve:
    """The result of a squeeze test."""

    free: Swatch
    """The cell without stress."""
    points: tuple[SqueezePoint, ...]
    """Measurements from the free thickness down."""
    states: tuple[YarnSet, ...]
    """Relaxed yarns at each thickness."""
    ranges: RangeVerdict = NOT_JUDGED
    """Whether the thickness lies where measurements were compared."""

    def __repr__(self) -> str:
        """Return one line: the range of thicknesses."""
        first, last = self.points[0].thickness, self.points[-1].thickness
        return f"SqueezeCurve({len(self.points)} thicknesses from {first:.3g} to {last:.3g} cm)"

    def column(self, name: str) -> FloatArray:
        """Return one measurement of all points, shape (n,)."""
        return np.array([getattr(point, name) for point in self.points], dtype=np.float64)

    def thickness_at(self, pressure: float) -> float:
        """Return the thickness under a pressure [cm], between the measured ones.

        Raises:
            ParameterError: the pressure is above the largest one of the curve, or negative.
        """
        pressures, thickness = self.column("pressure"), self.column("thickness")
        if not 0.0 <= pressure <= pressures[-1]:
            found = f"thickness: got a pressure of {pressure:g} dyn/cm2"
            raise ParameterError(f"{found}; expected 0 to {pressures[-1]:.4g}: squeeze further")
        return float(np.interp(pressure, pressures, thickness))

    @property
    def compressibility(self) -> float | None:
        """Loss of thickness from ``LIGHT`` to ``HEAVY`` over the thickness at ``LIGHT``; None if squeezed less."""
        if self.points[-1].pressure < HEAVY:
            return None
        return 1.0 - self.thickness_at(HEAVY) / self.thickness_at(LIGHT)


def squeeze_test(
    pattern: str | Pattern | Weave,
    parts: Sequence[float],
    *,
    material: YarnMaterial | None = None,
    quality: str | Quality = DEFAULT_QUALITY,
    device: str | None = None,
    run: Run[SqueezePoint] = SHOWN,
    **options: Any,
) -> SqueezeCurve:
    """Squeeze a swatch between two plates, and measure their pressure.

    The curve ends before the first part at which the yarns do not come to rest.

    Args:
        pattern: a pattern or a weave, the name of one in the library, or the path of a file.
        parts: thicknesses over the free thickness, below 1 and falling, for example (0.9, 0.8, 0.7).
        material: material of the yarn; ``compressed_by("van-wyk")`` makes it soft; by default the material
            ``stitchmesh``, scaled to the radius of the yarn.
        quality: a preset or a ``Quality``; it is refined as for a stretch test (``refine_for_tension``).
        device: device of the kernels, for example ``cpu`` or ``cuda:0``; by default the first GPU, or the CPU if there
            is no GPU.
        run: progress of the relaxation of each state; ``on_state`` is called with each point. The test obeys nothing
            else of it.
        options: fields of ``SwatchOptions``, except the period and the blocking.

    Raises:
        ParameterError: the parts do not fall from 1 to ``LEAST_PART``, or a period or a tension is given.
        FileError, PatternError, SolverError: an error of ``swatch``.
    """
    run.refuse_all_but("squeeze_test", "on_state")
    steps = [1.0, *parts]
    if len(steps) < 2 or not all(after < before for before, after in pairwise(steps)):
        raise ParameterError(f"squeeze, parts: got {list(parts)}; expected falling parts of the thickness, below 1")
    if steps[-1] < LEAST_PART:
        raise ParameterError(f"squeeze, parts: got {steps[-1]:g}; expected at least {LEAST_PART:g}")
    if material is not None:
        check_kind("squeeze_test, material", material, YarnMaterial)
    for name in {"period", "blocked"} & options.keys():
        raise ParameterError(f"{name}: got one for a squeeze test, which begins at the free cell; leave it out")
    chosen = refine_for_tension(quality_named(quality))
    prepared = prepare_swatch(
        pattern, material=material, quality=chosen, device=device, relax_cell=True, relaxation="frictionless", **options
    )
    relaxing: Run[YarnSet] = Run(run.progress)
    free, own = relax_prepared(prepared, prepared.yarns, relaxing), prepared.smallest
    yarns = own.part_of(free.yarns)
    before = thickness = free_thickness(yarns)
    points, states = list[SqueezePoint](), list[YarnSet]()
    for part in steps:
        wanted = part * thickness
        count = max(int(np.ceil(np.log(before / wanted) / LARGEST_STEP - 1e-9)), 1)
        for distance in np.geomspace(before, wanted, count + 1)[1:]:
            yarns = _squeezed(yarns, distance / before)
            before = float(distance)
            found = relax_with_digits(
                yarns, prepared.quality, material=prepared.material, device=device, terms=[Plates(before)], run=relaxing
            )
            yarns = found.yarns
        assert yarns.lattice is not None
        if points and not found.report["converged"]:
            logger.warning("squeeze: not at rest at %g of the free thickness; the curve ends before it", part)
            break
        points.append(SqueezePoint(
            before, plates_pressure(before, yarns, prepared.material), found.report["energy"] / yarns.lattice.area,
            found.report["min_distance_over_radius"] / 2.0, found.report["residual"], found.report["converged"],
        ))  # fmt: skip
        states.append(own.repeated(yarns, free.yarns))
        if run.on_state is not None:
            run.on_state(points[-1])
    refuse_pull_through(free.yarns, states[-1], device)
    return SqueezeCurve(free, tuple(points), tuple(states), thickness_verdict(fabric_of(prepared.source)))


def free_thickness(yarns: YarnSet) -> float:
    """Return the distance of plates that just touch a fabric [cm]: its yarns begin a radius before their axes."""
    assert yarns.lattice is not None
    height = yarns.points @ lattice_frame(yarns.lattice.periods)[2]
    radius = yarns.radius[yarns.point_yarn]
    return float((height + radius).max() - (height - radius).min())


def _squeezed(yarns: YarnSet, factor: float) -> YarnSet:
    """Return yarns with their heights over the middle plane, which is moved to 0, times a factor."""
    assert yarns.lattice is not None
    normal = lattice_frame(yarns.lattice.periods)[2]
    height = yarns.points @ normal
    middle = (height.max() + height.min()) / 2.0
    wanted = (height - middle) * factor
    return replace(yarns, points=yarns.points + np.outer(wanted - height, normal))


UNITS = {"thickness": "cm", "pressure": "dyn_per_cm2", "energy": "erg_per_cm2"}
"""Units of the columns that have a unit."""


def write_squeeze(path: FilePath, curve: SqueezeCurve) -> None:
    """Write a squeeze curve as a table: the fields of ``SqueezePoint`` with their units, and the pressure in kPa.

    Args:
        path: a ``.csv`` file; missing folders are made.
        curve: the result of a squeeze test.

    Raises:
        FileError: the file cannot be written.
    """
    kilopascal = [point.pressure * 1e-4 for point in curve.points]
    write_points(path, curve.points, UNITS, {"pressure_kilopascal": kilopascal})
