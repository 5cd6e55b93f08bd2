# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""All values that a project saves, as one value.

A change of a project makes a new state, so that a thread can write one state while the user makes the next.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from stitchmesh.app.project.division import Division
from stitchmesh.app.project.shaping import ShapedStitches
from stitchmesh.app.project.source import Source
from stitchmesh.editing.edit import Edit
from stitchmesh.editing.undo_history import UndoHistory, history_of_steps, steps_done
from stitchmesh.io.history import HistoryEntry
from stitchmesh.labeling.steps import LabelStep
from stitchmesh.mesh import StitchMesh
from stitchmesh.yarn import YarnSet
from stitchmesh.yarngen.recolouring import recoloured_yarns


@dataclass(frozen=True, eq=False, kw_only=True)
class Results:
    """The results of the stages after the last edit; each is None until its stage has run."""

    evened: StitchMesh | None = None
    """The fabric after mesh relaxation."""
    yarns: YarnSet | None = None
    """The generated yarns."""
    yarn_settings: Mapping[str, Any] | None = None
    """Settings with which the yarns were generated, in a form that JSON can hold."""
    relaxed: YarnSet | None = None
    """The relaxed yarns."""
    report: Mapping[str, Any] | None = None
    """Figures of the relaxation."""
    history: Sequence[HistoryEntry] | None = None
    """Assessments of the relaxation, in order."""


NO_RESULTS = Results()
NO_LABEL_STEPS: UndoHistory[LabelStep | None] = history_of_steps()
NO_EDITS: UndoHistory[Edit | None] = history_of_steps()
MOST_KEPT = 3
"""Number of earlier states that a project keeps; it is small, because each can hold large results."""


@dataclass(frozen=True, eq=False, kw_only=True)
class ProjectState:
    """A project between two changes."""

    name: str
    """Name of the project."""
    source: Source | None = None
    """The imported file; None until one is imported."""
    label_steps: UndoHistory[LabelStep | None] = NO_LABEL_STEPS
    """The steps of the labeling."""
    division: Division | None = None
    """The division of the labeled mesh; None before it is divided."""
    shaped: ShapedStitches | None = None
    """The stitches that were found on the mesh without labels; None if the stitches come from elsewhere."""
    edits: UndoHistory[Edit | None] = NO_EDITS
    """The edits of the stitches."""
    results: Results = NO_RESULTS
    """The results of the later stages."""
    kept: tuple[ProjectState, ...] = ()
    """The states before the last changes that dropped something, the newest first; undo and redo take results from
    them. They keep no states themselves."""
    settings: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    """Settings of each page, in a form that JSON can hold."""

    @property
    def made(self) -> tuple[str, ...]:
        """Names of the values that the stages after the labeling have made."""
        results = self.results
        parts = {
            "stitches": self.division or self.shaped,
            "edits": self.edits.present or self.edits.future or None,
            "evened stitches": results.evened,
            "yarns": results.yarns,
            "relaxed yarns": results.relaxed,
        }
        return tuple(name for name, value in parts.items() if value is not None)

    @property
    def stitches_from(self) -> tuple[object, ...]:
        """The values that determine the stitches before the edits; they are equal for states with the same stitches."""
        return steps_done(self.label_steps), self.division, None if self.shaped is None else id(self.shaped.fabric)


def with_label_steps(state: ProjectState, steps: UndoHistory[LabelStep | None]) -> ProjectState:
    """Return the state after a change of the labeling; stitches, edits and results are dropped.

    If the labeling is again the labeling of a kept state, its stitches, edits and results come back.
    """
    changed = replace(
        state, label_steps=steps, division=None, shaped=None, edits=NO_EDITS, results=NO_RESULTS,
        kept=_kept(state, bool(state.made)),
    )  # fmt: skip
    for kept in changed.kept:
        same = steps_done(kept.label_steps) == steps_done(steps)
        if same and (kept.division is not None or kept.shaped is not None):
            return replace(
                changed, division=kept.division, shaped=kept.shaped, edits=kept.edits, results=kept.results
            )  # fmt: skip
    return changed


def with_division(state: ProjectState, division: Division) -> ProjectState:
    """Return the state after a division of the labeled mesh; edits and results are dropped."""
    lost = _has_edits_or_results(state) or state.shaped is not None
    return _with_other_stitches(state, division, None, lost)


def with_shaped(state: ProjectState, shaped: ShapedStitches) -> ProjectState:
    """Return the state with stitches that were found on the mesh; edits and results are dropped."""
    lost = _has_edits_or_results(state) or state.division is not None
    return _with_other_stitches(state, None, shaped, lost)


def _with_other_stitches(
    state: ProjectState, division: Division | None, shaped: ShapedStitches | None, lost: bool
) -> ProjectState:
    """Return the state with other stitches; the present state is kept if the change drops something."""
    return replace(
        state, division=division, shaped=shaped, edits=NO_EDITS, results=NO_RESULTS, kept=_kept(state, lost)
    )


def with_edits(
    state: ProjectState, edits: UndoHistory[Edit | None], results: Results = NO_RESULTS
) -> ProjectState:
    """Return the state after a change of the edits, with the results that the change leaves; the others are dropped.

    If the stitches are again the stitches of a kept state, its results come back.
    """
    if results is not NO_RESULTS:
        return replace(state, edits=edits, results=results)
    kept = _kept(state, state.results is not NO_RESULTS)
    changed = replace(state, edits=edits, results=NO_RESULTS, kept=kept)
    wanted = state.stitches_from, steps_done(edits)
    same = [one for one in kept if (one.stitches_from, steps_done(one.edits)) == wanted]
    return replace(changed, results=same[0].results) if same else changed


def recoloured(results: Results, before: StitchMesh, after: StitchMesh) -> Results:
    """Return results with the colours of another fabric whose yarns have the same routes (``keeps_yarn_routes``)."""
    evened, yarns, relaxed = results.evened, results.yarns, results.relaxed
    return replace(
        results,
        evened=None if evened is None else replace(evened, yarn=after.yarn, palette=after.palette),
        yarns=None if yarns is None else recoloured_yarns(yarns, before, after),
        relaxed=None if relaxed is None else recoloured_yarns(relaxed, before, after),
    )


def _has_edits_or_results(state: ProjectState) -> bool:
    return state.edits.present is not None or state.results is not NO_RESULTS


def with_results(state: ProjectState, **values: Any) -> ProjectState:
    """Return the state with new results."""
    return replace(state, results=replace(state.results, **values))


def dropped(before: ProjectState, after: ProjectState) -> tuple[str, ...]:
    """Return the names of what a change has dropped."""
    return tuple(name for name in before.made if name not in after.made)


def _kept(state: ProjectState, lost: bool) -> tuple[ProjectState, ...]:
    """Return the states to keep at a change; the present state is among them if the change drops something."""
    return (replace(state, kept=()), *state.kept)[:MOST_KEPT] if lost else state.kept
