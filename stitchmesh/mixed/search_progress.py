# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Progress within one of several searches for an equilibrium."""

from __future__ import annotations

from stitchmesh.mixed.dynamics.equilibrium import AfterIteration
from stitchmesh.progress import Progress, relaxing_progress


def search_progress(
    stage: str, found: int, count: int, progress: Progress, *, tolerance: float, most_iterations: int
) -> AfterIteration:
    """Return a function that reports the iterations of a search.

    Args:
        stage: name of the stage.
        found: number of equilibria before this one.
        count: number of all equilibria.
        progress: called with the completed part of all searches and a line of text.
        tolerance: unbalanced force at which the search ends [dyn].
        most_iterations: largest number of its iterations.
    """

    def of_all(stage: str, done: float, note: str) -> None:
        progress(stage, min((found + done) / count, 1.0), note)

    return relaxing_progress(stage, tolerance, of_all, max_iterations=most_iterations)
