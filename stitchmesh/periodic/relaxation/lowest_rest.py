# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The lowest of several states of rest of a small free repeat.

Fabrics have several states of rest, and chance decides which one the generated yarns reach: noise of a hundredth of a
radius on their points takes slack ribs and moss stitch to states whose sizes differ by a tenth. A repeat with few
stitches (``sampling.SMALL_CELL``) that lies between planes is therefore also relaxed from ``STARTS`` displaced starts,
always the same ones, with the sampling of the coarsest preset. The state at rest with the least energy is kept, and all
finer samplings continue from it. States whose energies differ by less than ``SAME_ENERGY`` count as equal, and the
earliest of them is kept, so that the choice does not depend on rounding.

Smooth waves (``perturbation``) and the free changes of size displace a start. The lean of the cell is held, here as in
every relaxation of a swatch: if it were free, ribs would lie on their side.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from stitchmesh.compute.shared_work import compute_each
from stitchmesh.errors import SolverError, StitchMeshError
from stitchmesh.periodic.relaxation.perturbation import perturb
from stitchmesh.periodic.relaxation.prepared_swatch import PreparedSwatch
from stitchmesh.time_limit import seconds_left
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.linking.certificate import refuse_pull_through
from stitchmesh.yarnrelax.relax import relax_partly
from stitchmesh.yarnrelax.relaxation_result import Relaxation, continued

STARTS = 4
"""Number of displaced starts."""
SAME_ENERGY = 1e-4
"""Relative difference of energies below which states count as equally low."""
KICKS = 3
"""Number of displacements that make a start; the yarns are separated after each of them."""

Relax = Callable[[YarnSet, int], Relaxation]
"""A function that relaxes yarns. Its second argument is the number of iterations already made, which count for a common
limit."""

logger = logging.getLogger(__name__)


def lowest_rest(prepared: PreparedSwatch, yarns: YarnSet, relax: Relax) -> Relaxation:
    """Relax yarns, and displaced starts if the repeat has several states; return the way to the lowest state.

    The report has ``starts``, the number of starts that came to rest, and the iterations and seconds of all starts
    together. The entries of the history are numbered by these iterations. No displaced start is made if the yarns
    themselves do not come to rest, or when a time limit is reached. The starts do not depend on each other, unless they
    share a number of iterations.

    Args:
        prepared: the prepared repeat.
        yarns: its yarns, from which the first relaxation starts.
        relax: relaxes yarns with the first sampling of the path, after a given number of iterations.

    Raises:
        SolverError: the yarns cannot be relaxed.
    """
    last = relax(yarns, 0)
    found = [last]
    for some in _independent_starts(prepared) if prepared.has_states and last.report["converged"] else ():
        done = last.report["iterations"]
        others = compute_each([partial(_from_start, prepared, yarns, number, relax, done) for number in some])
        for number, other in zip(some, others, strict=True):
            if isinstance(other, SolverError):
                logger.debug("start %d of the search for the lowest state: %s", number + 1, other)
            elif isinstance(other, StitchMeshError):
                raise other
            elif other is not None:
                last = continued(other, Relaxation(last.yarns, last.report, []))
                found.append(last)
    rested = [each for each in found if each.report["converged"]] or found
    least = min(each.report["energy"] for each in rested)
    kept = next(each for each in rested if each.report["energy"] <= least + SAME_ENERGY * abs(least))
    spent = {name: last.report[name] for name in ("iterations", "seconds")}
    return replace(kept, report=kept.report | spent | {"starts": len(rested)})


def perturbed_start(prepared: PreparedSwatch, yarns: YarnSet, random: np.random.Generator) -> YarnSet:
    """Return yarns of a prepared repeat after ``KICKS`` equal displacements, separated after each of them.

    Raises:
        SolverError: the yarns cannot be separated.
    """
    assert prepared.cell is not None
    state = random.bit_generator.state
    for _kick in range(KICKS):
        random.bit_generator.state = state
        # Iterations between two displacements
        yarns = relax_partly(
            perturb(yarns, random, prepared.cell.free), material=prepared.similar, quality=prepared.path[0],
            iterations=20, device=prepared.device, cell=prepared.cell, terms=prepared.terms,
        )  # fmt: skip
    return yarns


def _independent_starts(prepared: PreparedSwatch) -> list[range]:
    """Return the numbers of the displaced starts in groups that do not depend on each other."""
    if prepared.most_iterations == math.inf:
        return [range(STARTS)]
    return [range(number, number + 1) for number in range(STARTS)]


def _from_start(
    prepared: PreparedSwatch, yarns: YarnSet, number: int, relax: Relax, done: int
) -> Relaxation | None:  # fmt: skip
    """Relax from a displaced start; None where no time is left for it.

    Raises:
        SolverError: the start cannot be relaxed.
    """
    if seconds_left() <= 0.0:
        return None
    start = perturbed_start(prepared, yarns, np.random.default_rng(number))
    other = relax(start, done)
    refuse_pull_through(prepared.drawn, other.yarns, prepared.device)
    return other
