# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Spirality: yarn with a torque turns its loops, so that the wales of single jersey lean.

Spinning leaves residual twist tau in a yarn, which it would lose if it hung free. Held in a fabric, it carries the
torque M = 2 pi GJ tau. A loop of stockinette that leans has turned about itself: the spherical area that its tangent
encloses (``energies.twist``), psi, is zero for an upright loop, which is its own mirror image. The torque does the work
M psi, so that a cell whose size is free shears until the loops resist. With Z twist the wales of the right side lean to
the right, and with S twist to the left. In 1x1 rib, interlock and garter, half turns of the fabric about an axis in its
plane exchange the two sides and reverse the lean, but keep the yarn as it is. They have no spirality: what they lean,
they lean to one of two sides by themselves, and with either twist.

The turns of each period of yarn are fixed, because no turn passes from repeat to repeat. The twist of a yarn that
writhes therefore falls a little, and its torque with it.

Too lively yarn snarls: a ring of radius R that was bent from straight yarn leaves its plane at the torque
M = sqrt(3) EI / R (Michell 1889), and its twist is then 2 pi sqrt(3) EI / GJ. The ring that is as long as the yarn of a
plain stitch has the ``snarling`` share M R / (sqrt(3) EI) of this torque.
"""

from __future__ import annotations

import logging
import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from stitchmesh.periodic.swatch_options import SwatchOptions
from stitchmesh.quality import Quality
from stitchmesh.yarnrelax import RelaxCell, YarnMaterial

if TYPE_CHECKING:
    from stitchmesh.yarnrelax.energies.twist import Twist

PER_METRE = 2.0 * math.pi / 100.0
"""Twist of one turn in a metre [rad/cm]."""

LIVELY_TOLERANCE = 2e-4
"""Largest residual at rest under a torque. No Hessian of twist tells what remains to go, and at the residual of
``draft`` a rib may still stand degrees from where it comes to rest."""

logger = logging.getLogger(__name__)


def well_balanced(quality: Quality, options: SwatchOptions) -> Quality:
    """Return the quality with the tolerance that a torque needs; the same quality without a torque."""
    if not options.residual_twist:
        return quality
    return replace(quality, tolerance=min(quality.tolerance, LIVELY_TOLERANCE))


def sheared_by_torque(options: SwatchOptions) -> RelaxCell:
    """Return the degrees of freedom of a free cell: it shears only if its yarn has a torque.

    Ribs without friction would shear to one of two sides by themselves.
    """
    return RelaxCell(shear=bool(options.residual_twist))


def torque(options: SwatchOptions, material: YarnMaterial, gamma: float) -> list[Twist]:
    """Return the term of the residual twist; no term for yarn without any.

    Args:
        options: options of the swatch.
        material: material of the yarn in the fabric.
        gamma: size of the yarns on which the term acts over their size in the fabric.
    """
    if not options.residual_twist:
        return []
    from stitchmesh.yarnrelax.energies.twist import Twist

    residual = PER_METRE * options.residual_twist / gamma
    return [Twist(material.scaled(gamma).twist_stiffness, residual=residual, laid=True)]


def torque_report(options: SwatchOptions, material: YarnMaterial, loop_length: float) -> dict[str, Any]:
    """Return the ``torque`` of the yarn [dyn cm], and its share of the torque at which yarn snarls, ``snarling``.

    Both are left out for yarn without residual twist.

    Args:
        options: options of the swatch.
        material: material of the yarn.
        loop_length: length of the yarn in a stitch [cm].
    """
    if not options.residual_twist:
        return {}
    found = PER_METRE * options.residual_twist * material.torsional_rigidity
    share = abs(found) * loop_length / (2.0 * math.pi * math.sqrt(3.0) * material.flexural_rigidity)
    if share > 1.0:
        logger.warning("the yarn is so lively that free loops of it snarl: its torque is %.2g of this limit", share)
    return {"torque": found, "snarling": share}
