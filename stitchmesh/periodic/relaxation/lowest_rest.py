# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The lowest of several states of rest of a small free repeat.

Fabrics have several states of rest, and chance decides which one the generated yarns reach: noise of a hundredth of a
radius on their points takes slack ribs and moss stitch to states whose sizes differ by a tenth. A repeat with few
stitches (``sampling.SMALL_CELL``) that lies between planes is therefore also relaxed from ``STARTS`` displaced starts,
always the same ones, with the sampling of the coarsest preset. The state at rest with the least energy is kept, and all
finer samplings continue from it. States whose energies differ by less than ``SAME_ENERGY`` count as equal, and the
earliest of them is kept, so that the choice does not depend on rounding.

Smooth waves (``perturb``) and the free changes of size displace a start. The lean of the cell is held, here as in
every relaxation of a swatch: if it were free, ribs would lie on their side.

A displacement is a sum of a few waves over the cell and a strain of the cell, and moves no yarn through another one.
With s and t the coordinates of a place in periods,

    u = sum over m, n of  Re c_mn exp(2 pi i (m s + n t))        |m|, |n| <= WAVES, c_mn random in space

u does not depend on the height. If its gradient has a norm below 1, places move without meeting: x -> x + u(x) is a
homeomorphism that can be shrunk to the identity, and no yarn passes through another one. Two places approach each
other by at most the norm times their distance. Waves and strain are therefore scaled to ``STEEPEST`` and ``STRAIN``:
yarns that touch then overlap by less than half of their thickness, which contact forces can separate.

The splines follow their control points, and so they move like the yarns, up to the curvature of u over a segment.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from stitchmesh.compute.shared_work import compute_each
from stitchmesh.errors import SolverError, StitchMeshError
from stitchmesh.lattice import Lattice, lattice_frame
from stitchmesh.linking.certificate import refuse_pull_through
from stitchmesh.mesh import FloatArray
from stitchmesh.periodic.relaxation.prepared_swatch import PreparedSwatch
from stitchmesh.time_limit import seconds_left
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.relax import relax_partly
from stitchmesh.yarnrelax.relaxation_result import Relaxation, continued

WAVES = 2
"""Largest number of waves in a period of the cell, in each direction."""
STEEPEST = 0.25
"""Largest norm of the gradient of the waves."""
STRAIN = 0.1
"""Largest strain along the courses and along the wales, and largest change of the lean."""
Random = np.random.Generator


def perturb(yarns: YarnSet, random: Random, free: NDArray[np.bool_]) -> YarnSet:
    """Return yarns on a lattice after a random displacement; equal states of ``random`` give equal displacements.

    Args:
        yarns: the yarns, on their lattice.
        random: source of random numbers.
        free: whether the strain along the courses, the strain along the wales and the lean may change, shape (3,).
    """
    assert yarns.lattice is not None
    e1, e2, normal = lattice_frame(yarns.lattice.periods)
    first, second, lean = STRAIN * random.uniform(-1.0, 1.0, 3) * free
    strain = np.eye(3) + first * np.outer(e1, e1) + second * np.outer(e2, e2) + lean * np.outer(e2, e1)
    waved = yarns.points + waves(yarns, random) @ np.stack([e1, e2, normal])
    return replace(yarns, points=waved @ strain, lattice=Lattice(yarns.lattice.periods @ strain))


def waves(yarns: YarnSet, random: Random) -> FloatArray:
    """Return displacements of the control points along courses, across them and along the normal [cm], shape (N, 3)."""
    assert yarns.lattice is not None
    numbers = np.array([(m, n) for m in range(WAVES + 1) for n in range(-WAVES, WAVES + 1) if (m, n) > (0, 0)])
    size = random.normal(size=(len(numbers), 3)) + 1j * random.normal(size=(len(numbers), 3))
    size /= (numbers**2).sum(axis=1)[:, None]
    frame = lattice_frame(yarns.lattice.periods)[:2]
    # rows of ``dual`` take a place in the frame to its coordinates in periods
    dual = np.linalg.inv(yarns.lattice.periods @ frame.T).T
    angles = (2j * np.pi * (yarns.points @ frame.T @ dual.T) @ numbers.T).imag
    turns = np.cos(angles) + 1j * np.sin(angles)  # a tenth of the time of a complex exponential
    slopes = 2j * np.pi * np.einsum("pw,wk,wd->pdk", turns, size, numbers @ dual)
    displacement: FloatArray = (turns @ size).real * (STEEPEST / _steepest(slopes.real))
    return displacement


def _steepest(slopes: FloatArray) -> float:
    """Largest norm of gradients (N, 3, 2): the root of the larger eigenvalue of each J^T J, faster than by SVD."""
    first, second = slopes[:, :, 0], slopes[:, :, 1]
    squares, others = (first**2).sum(axis=1), (second**2).sum(axis=1)
    apart = np.hypot((squares - others) / 2.0, (first * second).sum(axis=1))
    return float(np.sqrt((squares + others) / 2.0 + apart).max())


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
