# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Steam and plasticity: a swatch at rest whose yarn keeps a part of its bends, and comes to rest again.

``steamed`` is the share of bending and of residual twist that steam, heat or a wash sets (``yarn.lasting_bend``) in the
state to which the other options lead. The pins of a blocked swatch are taken out afterwards, so that its size is the
size after release. A swatch between given periods keeps them. Where the fabric has friction, it comes to rest again
with the friction of its state, whose contacts then hold no slip.

``yield_curvature`` lets the fibres slide where the yarn is bent by more, in turns with relaxation, until no natural
curvature changes any more by ``UNCHANGED`` over a radius. The fabric yields first, and is steamed then.
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from stitchmesh.periodic.relaxation.continuation import size_of
from stitchmesh.periodic.relaxation.off_needles import rest_with_friction
from stitchmesh.periodic.relaxation.spirality import sheared_by_torque
from stitchmesh.periodic.relaxation.way_to_rest import relax_with_digits
from stitchmesh.run import Run
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.lasting_bend import set_yarns, yielded_yarns
from stitchmesh.yarnrelax.energies.term import YarnChoice
from stitchmesh.yarnrelax.relaxation_result import Relaxation, continued

if TYPE_CHECKING:
    from stitchmesh.periodic.relaxation.prepared_swatch import PreparedSwatch

UNCHANGED = 1e-3
"""Largest change of a natural curvature at which the plastic state counts as found [1 / radius]."""
MOST_TURNS = 20
"""Largest number of turns of yielding and relaxing."""

logger = logging.getLogger(__name__)


def keeps_bends(prepared: PreparedSwatch) -> bool:
    """Whether the yarn of a swatch keeps a part of its bends."""
    options = prepared.options
    return bool(options.steamed) or options.yield_curvature is not None


def state_before(relaxed: Relaxation, prepared: PreparedSwatch) -> dict[str, float]:
    """Return width and height [cm] and energy [erg] of a repeat before its yarn keeps bends."""
    assert relaxed.yarns.lattice is not None
    whole = prepared.smallest.whole_lattice(relaxed.yarns.lattice)
    width, height = (size / prepared.options.gamma for size in size_of(whole))
    return {"width": width, "height": height, "energy": prepared.smallest.copies * relaxed.report["energy"]}


def with_lasting_bends(
    prepared: PreparedSwatch, relaxed: Relaxation, run: Run[YarnSet]
) -> tuple[PreparedSwatch, Relaxation]:  # fmt: skip
    """Let the yarn of a swatch at rest yield, then steam it, and let it come to rest again.

    Returns:
        The prepared swatch with what acts on it now (without pins, with the residual twist that is left), and the
        relaxation, whose iterations, seconds and history go on from the given one.

    Raises:
        SolverError: the yarns cannot be relaxed, or a yarn passed through another one.
    """
    if prepared.options.yield_curvature is not None:
        relaxed = _yielded(prepared, relaxed, prepared.options.yield_curvature / prepared.options.gamma, run)
    if prepared.options.steamed:
        share = prepared.options.steamed
        prepared = _after_steam(prepared, share)
        relaxed = _rest_again(prepared, set_yarns(relaxed.yarns, share), relaxed, run)
    return prepared, relaxed


def _yielded(prepared: PreparedSwatch, relaxed: Relaxation, limit: float, run: Run[YarnSet]) -> Relaxation:
    """Let yarn yield beyond a curvature [1/cm] and relax, in turns."""
    for _turn in range(MOST_TURNS):
        after = yielded_yarns(relaxed.yarns, limit)
        change = np.abs(np.abs(after.natural_curvature) - np.abs(relaxed.yarns.natural_curvature))
        if (change * after.radius[after.point_yarn]).max() < UNCHANGED:
            return relaxed
        relaxed = _rest_again(prepared, after, relaxed, run)
    logger.warning("the yarn still yields after %d turns; the swatch is near its plastic state", MOST_TURNS)
    return relaxed


def _after_steam(prepared: PreparedSwatch, share: float) -> PreparedSwatch:
    """Return a swatch with what acts on it after steam: no pins, and the twist that is left."""
    options = prepared.options
    left = None if options.residual_twist is None else (1.0 - share) * options.residual_twist
    after = replace(options, residual_twist=left)
    cell = prepared.cell
    if options.blocked is not None:
        after = replace(after, blocked=None, relax_cell=True)
        cell = sheared_by_torque(after)
    terms = [_untwisted(term, share) for term in prepared.terms]
    return replace(prepared, options=after, cell=cell, terms=terms)


def _untwisted(term: YarnChoice, share: float) -> YarnChoice:
    from stitchmesh.yarnrelax.energies.twist import Twist

    return replace(term, residual=(1.0 - share) * term.residual) if isinstance(term, Twist) else term


def _rest_again(prepared: PreparedSwatch, yarns: YarnSet, before: Relaxation, run: Run[YarnSet]) -> Relaxation:
    """Relax yarns whose natural curvature has changed; the iterations, seconds and history go on from before."""
    terms: Sequence[YarnChoice] = prepared.terms
    if prepared.release is not None:
        return rest_with_friction(
            yarns, prepared.release, prepared.similar, prepared.quality, prepared.device, terms, run, before
        )
    left = int(max(min(prepared.quality.max_iterations, prepared.most_iterations - before.report["iterations"]), 0))
    further = relax_with_digits(
        yarns, replace(prepared.quality, max_iterations=left), material=prepared.similar, device=prepared.device,
        cell=prepared.cell, terms=terms, run=run,
    )  # fmt: skip
    return continued(further, before)
