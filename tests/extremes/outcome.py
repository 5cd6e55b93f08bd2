# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How an extreme case may end: valid, at rest or not at rest, refused in one line, or FAILED, which is a fault."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from benchmarks.table import Rows
from stitchmesh.errors import StitchMeshError

VALID, AT_REST, NOT_AT_REST, REFUSED, FAILED = "valid", "at rest", "not at rest", "refused", "FAILED"


@dataclass(frozen=True)
class Outcome:
    """The end of a case."""

    kind: str
    words: str = ""
    """What is wrong, a warning, or the line of an error."""
    report: dict[str, Any] = field(default_factory=dict)
    """Figures of the run; empty where there is no result."""
    seconds: float = 0.0


def ended(run: Callable[[], Outcome]) -> Outcome:
    """Return how a run ends: an error of StitchMesh in one line is a refusal, every other exception a fault."""
    began = time.perf_counter()
    try:
        found = run()
    except StitchMeshError as error:
        words = str(error)
        found = Outcome(FAILED if "\n" in words or "nan" in words.lower().split() else REFUSED, words)
    except Exception as error:
        found = Outcome(FAILED, f"{type(error).__name__}: {error}")
    return replace(found, seconds=time.perf_counter() - began)


def table(titles: Sequence[str], cases: Iterable[tuple[Outcome, Sequence[object]]]) -> Rows:
    """Yield the row of each case, and return 1 if a case failed."""
    yield titles
    failed = 0
    for found, cells in cases:
        failed += found.kind == FAILED
        yield cells
    return int(failed > 0)
