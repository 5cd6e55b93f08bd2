# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Many swatches, as in a sweep over patterns, materials and options.

Each swatch is made in a thread of its own by the same functions as one alone. All threads wait at their relaxations and
examinations, which then run for all of them together (``compute.work_together``), in batches of cells
(``yarnrelax.together.relax_together``).
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field, replace
from functools import partial
from typing import Any, Literal

from stitchmesh.compute.work_together import done_together
from stitchmesh.errors import StitchMeshError
from stitchmesh.patterns import Pattern
from stitchmesh.periodic.relaxation.prepared_swatch import prepare_swatch
from stitchmesh.periodic.swatch import Swatch, relax_shaken
from stitchmesh.periodic.weave.weave import Weave
from stitchmesh.progress import Progress, shown_progress
from stitchmesh.quality import DEFAULT_QUALITY, Quality
from stitchmesh.yarnrelax import RelaxCell, YarnMaterial
from stitchmesh.yarnrelax.together.relax_together import ways_together

SwatchProgress = Callable[[int, int], None]
"""Called with the number of finished swatches, and with the number of all swatches."""


@dataclass(frozen=True, eq=False)
class SwatchRequest:
    """A swatch to be made: the arguments of ``swatch``, without device, budget and progress."""

    pattern: str | Pattern | Weave
    """A pattern or a weave, the name of one in the library, or the path of a file."""
    _: KW_ONLY
    material: YarnMaterial | None = None
    """Material of the yarn; by default the material ``stitchmesh``, scaled to the radius of the yarn."""
    quality: str | Quality = DEFAULT_QUALITY
    """A preset or a ``Quality``."""
    relax_cell: bool | RelaxCell = False
    """Whether the width and height of the repeat are relaxed, or the degrees of freedom of a cell."""
    shaken: int = 0
    """Number of shaken starts that relax too, for the spread of the size."""
    options: Mapping[str, Any] = field(default_factory=dict)
    """Fields of ``SwatchOptions``; they are checked when the swatch is made."""


def relax_swatches(
    requests: Sequence[SwatchRequest],
    *,
    device: str | None = None,
    progress: SwatchProgress | Literal[False] | None = None,
) -> list[Swatch | StitchMeshError]:
    """Make swatches together, each as ``swatch`` makes it.

    On a GPU a launch costs more than the work of a small cell, so hundreds of swatches take little longer than one.
    Each has the state of ``swatch`` within the tolerance, but with other rounding errors: cells of a batch share
    candidate lists and Newton steps. The bits of a result depend on all requests of the call and on the device; the
    same call gives the same bits. In the reports, ``seconds`` is the time from the begin of a swatch to its end, and
    ``solver_seconds`` counts the batches in which it took part.

    Args:
        requests: the swatches.
        device: device of the kernels, for example ``cpu`` or ``cuda:0``; by default the first GPU, or the CPU if there
            is no GPU.
        progress: called when a swatch is done; by default a line shows the progress on a terminal or in a notebook, and
            False shows nothing.

    Returns:
        The swatches in the order of the requests; in place of one that cannot be made, the error that ``swatch``
        raises.
    """
    with shown_progress(progress, _report_swatches) as report:
        computations = [partial(_make, request, device) for request in requests]

        def on_done(done: int) -> None:
            if report is not None:
                report(done, len(requests))

        return done_together(computations, ways_together(), on_done)


def _report_swatches(progress: Progress) -> SwatchProgress:
    """Return a function that reports the number of swatches as the progress of a stage."""
    return lambda done, count: progress("swatches", done / count, f"{done} of {count}")


def _make(request: SwatchRequest, device: str | None) -> Swatch:
    """Make a swatch; its report gives the time, which includes work for other swatches meanwhile."""
    began = time.perf_counter()
    prepared = prepare_swatch(
        request.pattern, material=request.material, quality=request.quality, device=device,
        **{"relax_cell": request.relax_cell, **request.options},
    )  # fmt: skip
    made = relax_shaken(prepared, request.shaken)
    return replace(made, report=made.report | {"seconds": time.perf_counter() - began})
