# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A balanced plain weave of taut, flexible and nearly incompressible round yarns, compared with Peirce 1937.

Peirce's yarns have a circular section, a constant length and no bending stiffness. They are straight between crossings
and bend around each other on arcs whose radius is the diameter d. With the yarn length l and the distance p between
crossings, and arcs of the angle t at both ends,

    p = (l - 2 d t) cos t + 2 d sin t,    d = (l - 2 d t) sin t + 2 d (1 - cos t)

and the straight part vanishes at t = 60 degrees: p = sqrt(3) d, where the weave is jammed. In the simulation, this
limit is a yarn whose bending forces are small compared with its tension, whose tension is small compared with its
contact forces, and whose periods are held.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from stitchmesh.periodic.relaxation.continuation import size_of
from stitchmesh.periodic.weave.library import read_weave
from stitchmesh.periodic.weave.yarns import weave_yarns
from stitchmesh.quality import PRESETS
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import RelaxCell, YarnMaterial, relax_yarns
from stitchmesh.yarnrelax.cell_stress import cell_stress

RADIUS = 0.125
"""Radius of the yarn [cm]."""
SPACINGS = (1.8, 2.0, 2.4, 3.0)
"""Distances of adjacent yarns that are compared [diameters]."""
JAMMED = (1.7, 1.6, 1.5)
"""Distances of adjacent yarns beyond jamming [diameters]."""
JAM_ANGLE = np.pi / 3
HALF_WAVES = 8
"""Number of segments between crossings of the four yarns of a repeat."""
SHORTER = 0.01
"""Relative reduction of the rest length from Peirce's yarn length, which makes the yarn taut."""
CONTACT, BENDING = 100.0, 2e-4
"""Stiffnesses relative to those of ``kaldor-simulation``."""
QUALITY = replace(PRESETS["reference"], quadrature_points=5, tolerance=1e-3)


@dataclass(frozen=True)
class Peirce:
    """A balanced plain weave of rigid round yarns."""

    spacing: float
    """Distance between crossings [diameters]."""
    yarn: float
    """Yarn length between crossings [diameters]."""

    @property
    def crimp(self) -> float:
        """Crimp: yarn length divided by spacing, minus one."""
        return self.yarn / self.spacing - 1.0

    @classmethod
    def at(cls, angle: float) -> Peirce:
        """Return the geometry for arcs of an angle [rad]."""
        straight = (2 * np.cos(angle) - 1) / np.sin(angle)
        return cls(straight * np.cos(angle) + 2 * np.sin(angle), straight + 2 * angle)

    @classmethod
    def spaced(cls, spacing: float) -> Peirce:
        """Return the geometry for a spacing [diameters], or the jammed geometry for a spacing below that of jamming."""
        low, high = 0.01, JAM_ANGLE
        for _ in range(60):
            middle = (low + high) / 2
            low, high = (middle, high) if cls.at(middle).spacing > spacing else (low, middle)
        return cls.at(high)


@dataclass(frozen=True)
class Taut:
    """A relaxed weave of taut yarns."""

    yarns: YarnSet
    crimp: float
    """Crimp: yarn length divided by spacing, minus one."""
    nearest: float
    """Smallest distance of axes [diameters], the effective diameter."""
    crown: float
    """Height of the waves of a yarn [diameters]; 1 in Peirce's geometry."""
    tension: float
    """Tension of the fabric [dyn/cm]; negative if the yarns push the periods apart."""
    spacing: float
    """Distance between crossings [diameters]."""
    strain: float
    """Strain of the yarn."""


def taut_weave(spacing: float, *, yarn: float | None = None, contact: float = CONTACT, free: bool = False) -> Taut:
    """Return a relaxed plain weave that is generated at a spacing [diameters], with held or free periods.

    Args:
        spacing: from crossing to crossing [diameters].
        yarn: at rest, from crossing to crossing [diameters]; a little shorter than Peirce's where not given.
        contact: its stiffness over that of ``kaldor-simulation``.
        free: whether the cell relaxes.
    """
    drawn = weave_yarns(read_weave("plain"), yarn_radius=RADIUS, spacing=2 * RADIUS * spacing, quality=QUALITY)
    at_rest = (yarn or (1.0 - SHORTER) * Peirce.spaced(spacing).yarn) * 2 * RADIUS
    count = len(drawn.rest_length)
    drawn = replace(drawn, rest_length=np.full(count, at_rest * HALF_WAVES / count))
    material = YarnMaterial.named("kaldor-simulation")
    material = replace(material, k_contact=material.k_contact * contact, k_bend=material.k_bend * BENDING)
    cell = RelaxCell(shear=False) if free else None
    rest = relax_yarns(drawn, material=material, quality=QUALITY, device="cpu", cell=cell)
    assert rest.yarns.lattice is not None
    between = size_of(rest.yarns.lattice)[0] / 2
    length = float(rest.yarns.lengths.sum()) / HALF_WAVES
    stress = cell_stress(rest.yarns, material, quadrature_points=5, contact_samples=QUALITY.contact_samples)
    crown = np.mean([np.ptp(curve[:, 2]) for curve in rest.yarns.sampled(16)])
    return Taut(
        yarns=rest.yarns, crimp=length / between - 1.0, nearest=rest.report["min_distance_over_radius"] / 2,
        crown=float(crown) / (2 * RADIUS), tension=stress.course, spacing=between / (2 * RADIUS),
        strain=float(rest.yarns.lengths.sum() / rest.yarns.rest_length.sum()) - 1.0,
    )  # fmt: skip


def peirce_table() -> Iterable[list[object]]:
    """Compare the crimp at several spacings for two contact stiffnesses."""
    yield ["p / d", "Peirce's crimp", "crimp", "nearest axes / d", "crown height / d", "tension [dyn/cm]",
           "crimp, contact 10 times as stiff", "nearest axes / d"]  # fmt: skip
    for spacing in SPACINGS:
        soft, hard = taut_weave(spacing), taut_weave(spacing, contact=10 * CONTACT)
        yield [spacing, f"{100 * Peirce.spaced(spacing).crimp:.2f} %", f"{100 * soft.crimp:.2f} %",
               f"{soft.nearest:.4f}", f"{soft.crown:.4f}", f"{soft.tension:.0f}", f"{100 * hard.crimp:.2f} %",
               f"{hard.nearest:.4f}"]  # fmt: skip


def jam_table() -> Iterable[list[object]]:
    """Compare held periods above and below jamming, and a free cell with shorter yarns than the jammed weave."""
    yield ["cell", "tension [dyn/cm]", "crown height / d", "nearest axes / d", "p / d", "strain of the yarn"]
    for spacing in (1.8, *JAMMED):
        yield [f"held at p = {spacing:g} d", *_jam_row(taut_weave(spacing, contact=10 * CONTACT))]
    for share in (1.02, 1.0, 0.95, 0.9):
        found = taut_weave(2.0, yarn=share * Peirce.at(JAM_ANGLE).yarn, contact=10 * CONTACT, free=True)
        yield [f"free, yarn {share:g} of the jammed one's", *_jam_row(found)]


def _jam_row(found: Taut) -> list[object]:
    return [f"{found.tension:.0f}", f"{found.crown:.3f}", f"{found.nearest:.3f}", f"{found.spacing:.3f}",
            f"{100 * found.strain:.1f} %"]  # fmt: skip
