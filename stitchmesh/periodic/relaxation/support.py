# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The planes between which a swatch of free size lies, and the pins that block it.

A knitter lays a swatch on a table, pats it flat and measures it. Its weight and friction keep it flat. The yarns here
have neither, and without them a fabric buckles: the loops of most patterns can straighten further when courses or
columns fold over one another. A free swatch therefore lies between two frictionless planes (``Confinement``). Their
distance is the flat thickness of the fabric (``FlatFabric``) and ``CLEARANCE`` more. Stockinette does not touch them.
The planes are elastic, and press on a fabric that would buckle about as much as its weight does (docs/swatches.md). A
few stitches are thicker, such as decreases and cables. They press into the planes: between planes that are as far apart
as the thickest stitch, plain courses slide behind one another, and the eyelets of lace close.

Knitters block lace: they wet it and pin it out. ``blocking`` replaces the pins by a tension in both directions, as dead
loads on the borders of the repeat. The tension is the force over the length of the border as the repeat is generated:
the nominal tension of a stretch test (``stretch``). The virial theorem gives a lower bound for the strain: the legs of
the yarn carry the loads,

    sum over legs of  f l (t1^2 + t2^2)  >=  P1 width + P2 height,    t1^2 + t2^2 <= 1

because contacts only push. The mean force f of the yarn is therefore at least the right side over the length of the
yarn.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np

from stitchmesh.errors import OverloadError, ParameterError
from stitchmesh.mesh import FloatArray
from stitchmesh.periodic.fabric_shape import FlatFabric
from stitchmesh.periodic.relaxation.continuation import size_of
from stitchmesh.periodic.swatch_options import SwatchOptions
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import RelaxCell, YarnMaterial
from stitchmesh.yarnrelax.energies.term import YarnChoice

CLEARANCE = 0.018
"""Distance of the planes beyond the flat thickness, over the length of yarn in a stitch: 0.3 diameters in a compact
loop. Stockinette with loops of 14 to 40 diameters rests 0.12 to 0.69 diameters thicker than it is generated, 0.007 to
0.017 of its loops (``benchmarks/run.py free-swatches shapes``)."""
TEARING_STRAIN = 0.3
"""Strain at which a yarn tears; wool breaks at 25 to 35 % (dry) and spun cotton at 5 to 10 %."""


def planes(options: SwatchOptions, flat: FlatFabric, radius: FloatArray) -> list[YarnChoice]:
    """Return the term of the planes; no term for a swatch of fixed size, an unsupported one, or a given ``RelaxCell``.

    Args:
        options: options of the swatch.
        flat: the fabric as it is generated.
        radius: radius of each yarn during the relaxation [cm], shape (Y,).
    """
    free = options.freedom
    lies = free is True or (free is False and options.blocked is not None)
    if options.unsupported or not lies:
        return []
    from stitchmesh.yarnrelax.energies.confinement import Confinement

    distance = 2.0 * float(radius.mean()) * (flat.common - 1.0) + CLEARANCE * flat.stitch_length
    return [Confinement(half_thickness=distance / 2.0)]


def planes_report(terms: Sequence[YarnChoice], yarns: YarnSet, material: YarnMaterial, gamma: float) -> dict[str, Any]:
    """Return the action of the planes on a fabric at rest: ``planes_distance`` [cm] and ``planes_pressure`` [dyn/cm^2].

    Both are None for a fabric that lies on nothing.

    Args:
        terms: what acts on the fabric, with the planes between which it lies, if it lies on something.
        yarns: the fabric at rest, at gamma times its size.
        material: material of the yarns at that size.
        gamma: the ratio of these lengths to the lengths in the fabric.
    """
    from stitchmesh.yarnrelax.energies.confinement import Confinement, plane_pressure

    planes = next((term for term in terms if isinstance(term, Confinement)), None)
    if planes is None:
        return {"planes_distance": None, "planes_pressure": None}
    distance, pressure = 2.0 * planes.half_thickness / gamma, gamma**3 * plane_pressure(planes, yarns, material)
    return {"planes_distance": distance, "planes_pressure": pressure}


def blocking(drawn: YarnSet, options: SwatchOptions, material: YarnMaterial) -> RelaxCell:
    """Return a cell with the tension of a blocked swatch on its borders, for a fabric of its final size.

    Args:
        drawn: the generated yarns.
        options: options of the swatch, blocked.
        material: material of the yarns.

    Raises:
        ParameterError: the tension tears the yarn.
    """
    assert drawn.lattice is not None and options.blocked is not None
    width, height = (size / options.gamma for size in size_of(drawn.lattice))
    force = 2.0 * options.blocked * width * height * options.gamma / float(drawn.rest_length.sum())
    strain = force / material.axial_stiffness if material.axial_stiffness > 0.0 else np.inf
    refuse_tearing(strain, options)
    return RelaxCell(options.blocked * height, options.blocked * width, shear=False)


def remedy_of(cell: RelaxCell | None, *, lies: bool) -> str:
    """Return the advice for a fabric that does not lie flat.

    Args:
        cell: degrees of freedom of the cell; None for a repeat of fixed size.
        lies: whether the fabric lies between the planes.
    """
    if lies:
        return "give it a tension (--blocked), or less yarn (--gamma)"
    if cell is None:
        return "it buckles at this size; let its size relax too (--relax-cell)"
    return "let it lie on a table (no --unsupported, relax_cell=True), or block it (--blocked)"


def refuse_tearing(strain: float, options: SwatchOptions) -> None:
    """Refuse a blocked swatch whose yarn is strained too far.

    Raises:
        ParameterError: the strain is above ``TEARING_STRAIN``.
    """
    if options.blocked is not None and strain > TEARING_STRAIN:
        found = f"blocked: {options.blocked:g} dyn/cm strain the yarn by {100 * strain:.3g} %, and it tears at"
        raise ParameterError(f"{found} {100 * TEARING_STRAIN:g} %; give a smaller tension")


@contextmanager
def tearing(options: SwatchOptions) -> Iterator[None]:
    """While a blocked swatch relaxes, replace the error of yarns that are pressed through one another.

    Raises:
        ParameterError: the tension is too large for the contacts of the yarn.
    """
    try:
        yield
    except OverloadError as error:
        if options.blocked is None:
            raise
        found = f"blocked: {options.blocked:g} dyn/cm press yarns into one another ({str(error).partition(':')[0]})"
        raise ParameterError(f"{found}; give a smaller tension") from error
