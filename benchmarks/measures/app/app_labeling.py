# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Time of the server for each action on the pages Label and Divide, and the bytes that the scene is given.

The pages run without a browser on tubes of 20,000 and 65,000 faces. A garment that is modelled for knitting has some
hundred faces; its actions take a few milliseconds. The bytes are those of the arrays of the drawings that an action
changes, before compression.
"""

from __future__ import annotations

import statistics
import tempfile
import time
from collections.abc import Callable
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.table import Rows
from tests.app.pages.headless import Headless, headless
from tests.gallery import tube

SIZES = (18, 141, 255)
"""Numbers of faces around and along the tubes."""
RUNS = 5
"""Number of times that each action is done."""


def arrays_of(value: object) -> dict[int, int]:
    """The size of each array in a drawing, by its identity [bytes]."""
    if isinstance(value, np.ndarray):
        kept = 1 if value.dtype == np.uint8 else 4  # Positions and triangles are sent with four bytes each.
        return {id(value): value.size * kept}
    if is_dataclass(value):
        parts = [arrays_of(getattr(value, field.name)) for field in fields(value)]
        return {key: size for part in parts for key, size in part.items()}
    return {}


def measure(page: Headless, action: Callable[[], Any]) -> tuple[float, int]:
    """The time of an action [ms], and the bytes of the arrays that are new after it."""
    before = [arrays_of(drawing) for drawing in page.scene.drawings.values()]
    held = dict(page.scene.drawings)  # The old arrays are kept, so that new ones have other identities.
    began = time.perf_counter()
    action()
    spent = time.perf_counter() - began
    known = {key for part in before for key in part}
    now = [arrays_of(drawing) for drawing in page.scene.drawings.values()]
    del held
    return 1e3 * spent, sum(size for part in now for key, size in part.items() if key not in known)


def actions(page: Headless) -> list[tuple[str, Callable[[], Any]]]:
    """What is done on the pages, in order."""
    press, set_value = page.controls.press, page.controls.set
    return [
        ("open Label", lambda: page.app.open_page("Label")),
        ("one row more", lambda: press("Next row")),
        ("label all", lambda: press("Label all")),
        ("flip a row by a click", lambda: page.click_face(100)),
        ("undo the flip", lambda: press("Undo")),
        ("open Divide", lambda: page.app.open_page("Divide")),
        ("another stitch width", lambda: set_value("Stitch width [cm]", 0.9)),
        ("choose an edge by a click", lambda: page.click_side(100)),
        ("a number on the edge", lambda: set_value("Number", 3)),
    ]


def run(size: int) -> dict[str, tuple[float, int]]:
    """Do everything once on a tube."""
    mesh = tube(size, size, radius=0.2 * size, height=1.2)
    with tempfile.TemporaryDirectory() as folder, headless(Path(folder), mesh, "Project") as page:
        return {name: measure(page, action) for name, action in actions(page)}


def app_labeling() -> Rows:
    """Yield one table: milliseconds, median, and kilobytes."""
    results = []
    for size in SIZES:
        runs = [run(size) for _ in range(RUNS)]
        results.append({name: (statistics.median(one[name][0] for one in runs), runs[0][name][1]) for name in runs[0]})
    yield "action", *(f"{size * size:,} faces: {unit}" for size in SIZES for unit in ("ms", "kB"))
    for name in results[0]:
        yield name, *(
            cell for one in results for cell in (f"{one[name][0]:.0f}", f"{one[name][1] / 1e3:,.0f}")
        )
