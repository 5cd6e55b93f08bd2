# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The relaxation of yarns with its options, with and without limits on the time and on the error."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from stitchmesh.budget.budget import Budget
from stitchmesh.budget.plan import limit_of, make_plan
from stitchmesh.budget.tables import BudgetScene
from stitchmesh.mesh import StitchMesh
from stitchmesh.pipeline.dressed import dressed
from stitchmesh.pipeline.options import RelaxOptions
from stitchmesh.quality import DEFAULT_QUALITY, Quality
from stitchmesh.run import QUIET, Run
from stitchmesh.time_limit import limited_to
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.rest_length import apply_rest_lengths
from stitchmesh.yarnrelax import Relaxation, relax_yarns
from stitchmesh.yarnrelax.energies.body import Body

POINTS_OF_STITCH = 20
"""Control points of a plain stitch, from which the number of stitches of yarns without stitches is estimated."""


def relax_with_options(
    yarns: YarnSet, options: RelaxOptions, *, quality: str | Quality, device: str | None = None,
    fabric: StitchMesh | None = None, run: Run[YarnSet] = QUIET,
) -> Relaxation:  # fmt: skip
    """Change the rest lengths of yarns, put them on the bodies among the terms, and relax them.

    If yarns of a known fabric are in a body, they are moved out of it first (``dressed``). The relaxation then keeps
    the borders and the shape after this move, and the report has an entry ``dressed``.

    Args:
        yarns: the yarns.
        options: options of the relaxation.
        quality: name of a preset, or a ``Quality``.
        device: Warp's name of the device; None for the preferred device.
        fabric: the fabric from which the yarns were made, if it is known.
        run: where to start, progress, states, checkpoints and control.

    Raises:
        StitchMeshError: the rest lengths cannot be applied (``apply_rest_lengths``), or as for ``relax_yarns``.
    """
    yarns, moved = apply_rest_lengths(yarns, options.rest_lengths, fabric=fabric), {}
    bodies = [term for term in options.terms if isinstance(term, Body)]
    if fabric is not None and bodies:
        worn = dressed(yarns, fabric, bodies, device=device)
        yarns, fabric = worn.yarns, worn.fabric
        moved = {"dressed": {"depth_cm": worn.depth, "farthest_cm": worn.farthest}} if worn.depth else {}
    relaxed = relax_yarns(
        yarns,
        material=options.yarn_material(yarns),
        quality=quality,
        device=device,
        keep_shape=fabric if options.keep_shape else None,
        terms=options.terms,
        run=run,
    )
    carried = {"made_of": yarns.made_of.name} if options.material is None and yarns.made_of is not None else {}
    return replace(relaxed, report=relaxed.report | carried | moved)


def relax_within_budget(
    budget: Budget, yarns: YarnSet, options: RelaxOptions, *, quality: str | Quality = DEFAULT_QUALITY,
    device: str | None = None, **arguments: Any,
) -> Relaxation:  # fmt: skip
    """Relax yarns as ``relax_with_options`` does, within limits on the time and on the error.

    Measured tables choose the quality, unless it differs from the default; the yarns keep their sampling.

    Args:
        budget: the limits.
        yarns: the yarns.
        options: options of the relaxation.
        quality: name of a preset, or a ``Quality``.
        device: Warp's name of the device; None for the preferred device.
        **arguments: the other arguments of ``relax_with_options``.

    Raises:
        StitchMeshError: a quality is given beside an error, the time is over, or as for ``relax_with_options``.
    """
    stitches = max(round(len(yarns.points) / POINTS_OF_STITCH), 1)
    with limited_to(limit_of(budget)):
        scene = BudgetScene(kind="garment" if yarns.lattice is None else "given cell", stitches=stitches)
        plan = make_plan(budget, scene, quality, device)
        relaxed = relax_with_options(yarns, options, quality=plan.quality, device=device, **arguments)
    return replace(relaxed, report=relaxed.report | {"budget": plan.report()})
