# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Relaxation of yarns that start closer together than the contact samples of a quality can separate.

Few samples on a long segment leave a wide bound on the distance of two yarns, so that a relaxation cannot start where
yarns nearly touch axis to axis, as in a bobble at quality ``draft``. Then the relaxation starts again, first with twice
as many contact samples, and if that is not sufficient, with thinner yarn, which is relaxed before the yarn takes its
own radius. In both cases the linking of the yarns is certified as in any relaxation.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from stitchmesh.errors import SolverError
from stitchmesh.io.history import HistoryEntry
from stitchmesh.quality import Quality
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.observer import Progress
from stitchmesh.yarnrelax.relaxation_result import Relaxation

logger = logging.getLogger(__name__)

MORE_SAMPLES = 2
"""Factor of the contact samples."""
THIN = 0.6
"""Factor of the radius of thinner yarn."""


def relax_from_crowded_start(
    relax: Callable[..., Relaxation], yarns: YarnSet, *, quality: Quality, progress: Progress | None = None,
    **arguments: Any,
) -> Relaxation:  # fmt: skip
    """Relax yarns as ``relax_yarns`` does, also from a start at which they are too close to each other.

    Args:
        relax: ``relax_yarns``, or a function with the same arguments.
        yarns: the yarns.
        quality: the quality; its contact samples are doubled if the yarns start too close to each other.
        progress: as for ``relax_yarns``.
        **arguments: the other arguments of ``relax_yarns``.

    Raises:
        StitchMeshError: as for ``relax_yarns``.
    """
    assessed: list[int] = []

    def note(entry: HistoryEntry) -> None:
        assessed.append(entry["iteration"])
        if progress is not None:
            progress(entry)

    finer = replace(quality, contact_samples=MORE_SAMPLES * quality.contact_samples)
    for attempt in (quality, finer):
        try:
            return relax(yarns, quality=attempt, progress=note, **arguments)
        except SolverError as error:
            if assessed:
                raise
            remedy = f"{finer.contact_samples} contact samples" if attempt is quality else f"yarn {THIN} times as thick"
            logger.warning(f"{str(error).split(';')[0]}: started again with {remedy}")
    thin = replace(yarns, radius=THIN * yarns.radius)
    own = {"on_state": None, "checkpoint": None, "resume": None}
    eased = relax(thin, quality=finer, progress=note, **(arguments | own)).yarns
    start = {"start": replace(yarns, points=eased.points)}
    return relax(yarns, quality=finer, progress=note, **(arguments | start))
