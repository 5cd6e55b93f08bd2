# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Relaxes the yarns of an edited fabric: from the relaxed yarns before the edit, or anew where that fails.

The following starts are tried in this order, until one leads to a state of rest:

1. the fabric as it was edited, from the relaxed yarns before the edit (``warm_start``);
2. the fabric with the stitches around the edit evened out, from the relaxed yarns before the edit;
3. the same fabric, from its generated yarns.

The second start is tried if the stitches are too crowded for yarns or if the first start fails. The third is tried if
the second fails, or at once if hardly any stitch is where it was.
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from stitchmesh.errors import SolverError, StitchMeshError, YarnError
from stitchmesh.io.history import HistoryEntry
from stitchmesh.mesh import Mesh, StitchMesh
from stitchmesh.meshrelax import relax_mesh_around_edit
from stitchmesh.pipeline.options import RelaxOptions
from stitchmesh.pipeline.yarn_relaxation import relax_with_options
from stitchmesh.progress import shown_stages
from stitchmesh.quality import DEFAULT_QUALITY, Quality
from stitchmesh.run import SHOWN, Run
from stitchmesh.yarn import YarnSet
from stitchmesh.yarngen import YarnFinish
from stitchmesh.yarngen.regenerate import WarmStart, warm_start
from stitchmesh.yarnrelax import Relaxation

logger = logging.getLogger(__name__)

ANEW = "relaxed all yarns anew"
"""The beginning of the note that says why all yarns were relaxed anew."""


@dataclass(frozen=True, eq=False)
class RelaxedAgain:
    """The results of ``relax_edited``."""

    fabric: StitchMesh
    """The edited fabric, in which the stitches around the edit were evened out if they were too crowded."""
    yarns: YarnSet
    """Its relaxed yarns."""
    report: dict[str, Any]
    """The report of ``relax_yarns``, with two more entries: ``warm``, the part of the control points that started from
    relaxed positions, and ``notes``, a line for each start that failed."""
    history: Sequence[HistoryEntry]
    """Assessments of the relaxation, in order."""


def relax_edited(
    relaxed: YarnSet, before: StitchMesh, after: StitchMesh, *, quality: str | Quality = DEFAULT_QUALITY,
    device: str | None = None, options: RelaxOptions | None = None, finish: YarnFinish | None = None,
    surface: Mesh | None = None, run: Run[YarnSet] = SHOWN,
) -> RelaxedAgain:  # fmt: skip
    """Relax the yarns of an edited fabric, from the relaxed yarns before the edit where that is possible.

    Args:
        relaxed: relaxed yarns of the fabric before the edit.
        before: the fabric before the edit.
        after: the edited fabric, whose shape the yarns keep.
        quality: the quality with which the relaxed yarns were generated.
        device: Warp's name of the device; None for the preferred device.
        options: options of the relaxation.
        finish: the finish with which the relaxed yarns were generated.
        surface: the mesh of the garment, on which crowded stitches are evened out; the surface of ``before`` if None.
        run: progress, states, checkpoints and control of the relaxation.

    Raises:
        ParameterError: the relaxed yarns were not generated from ``before`` with this quality and finish.
        YarnError: no yarns can be generated from the edited fabric, not even after its stitches were evened out.
        SolverError: the relaxation cannot continue, not even from the generated yarns.
    """
    with shown_stages(run.progress) as shown:
        edit = _Edit(
            relaxed, before, after, surface, {"quality": quality, "finish": finish or YarnFinish()},
            {"options": options or RelaxOptions(), "quality": quality, "device": device},
            replace(run, progress=shown),
        )  # fmt: skip
        fabric, warm, outcome = edit.at_rest()
    report = {**outcome.report, "warm": round(warm, 4), "notes": edit.notes}
    return RelaxedAgain(fabric, outcome.yarns, report, outcome.history)


@dataclass(frozen=True, eq=False)
class _Edit:
    """An edit with the arguments of its stages, and the lines that the report shall have as notes."""

    relaxed: YarnSet
    before: StitchMesh
    after: StitchMesh
    surface: Mesh | None
    generation: dict[str, Any]
    relaxation: dict[str, Any]
    run: Run[YarnSet]
    notes: list[str] = field(default_factory=list)

    def at_rest(self) -> tuple[StitchMesh, float, Relaxation]:
        """Return the fabric, the part of its yarns that started from relaxed positions, and its relaxed yarns."""
        fabric = self.after
        try:
            found = self.generated()
            if found.start is not None:
                return fabric, found.warm, self.from_start(fabric, found, load_steps=False)
        except (YarnError, SolverError) as error:
            self.note(f"evened out the stitches around the edit, because {_reason(error)}")
            fabric = relax_mesh_around_edit(self.before, self.after, surface=self.surface).fabric
            found = self.generated(fabric)
            try:
                if found.start is not None:
                    return fabric, found.warm, self.from_start(fabric, found, load_steps=True)
            except SolverError as second:
                self.note(f"{ANEW}, because the yarns cannot start where they were relaxed: {_reason(second)}")
        if found.start is None:
            self.note(f"{ANEW}, because hardly any stitch is where it was before the edit")
        return fabric, 0.0, relax_with_options(found.generated, fabric=fabric, run=self.run, **self.relaxation)

    def generated(self, evened: StitchMesh | None = None) -> WarmStart:
        """Generate the yarns of the edited fabric or of the evened one, and place them by the relaxed yarns."""
        return warm_start(self.relaxed, self.before, self.after, evened=evened, **self.generation)

    def from_start(self, fabric: StitchMesh, found: WarmStart, *, load_steps: bool) -> Relaxation:
        """Relax the yarns of a fabric from relaxed positions (``relax_with_options``)."""
        run = replace(self.run, start=found.start, load_steps=load_steps)
        return relax_with_options(found.generated, fabric=fabric, run=run, **self.relaxation)

    def note(self, line: str) -> None:
        """Keep a line for the report, and log it."""
        self.notes.append(line)
        logger.warning(line)


def _reason(error: StitchMeshError) -> str:
    """Return the message of an error without its remedy."""
    return str(error).split(";")[0]
