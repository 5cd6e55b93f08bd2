# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Sizes that come true: all knits of the library, in one yarn, are asked for more and for fewer stitches.

Each knit is relaxed at the usual loop length of the yarn first, and then asked by ``sm.swatch_to`` for the stitches of
that swatch times each factor. The table says how many swatches each search relaxed, and how far the stitches are off.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from functools import partial

import numpy as np

import stitchmesh as sm
from benchmarks.table import Rows, note
from stitchmesh.compute.work_together import done_together
from stitchmesh.errors import StitchMeshError
from stitchmesh.patterns.library import pattern_names
from stitchmesh.periodic.resolve_pattern import resolve_pattern, stitches_of
from stitchmesh.periodic.swatch_options import KnitState
from stitchmesh.periodic.swatch_to import TRUE
from stitchmesh.yarnrelax.together.relax_together import ways_together

TOGETHER = 11
"""Number of knits whose swatches relax together; small knits come first, and their rows are printed first."""


def swatch_sizes(
    patterns: tuple[str, ...] = (), factors: tuple[float, ...] = (0.9, 1.1), yarn: str = "dk",
    state: KnitState = "dry", quality: str = "draft", device: str = "cpu",
) -> Rows:  # fmt: skip
    """Ask knits for numbers of stitches.

    Args:
        patterns: names of knits; all knits of the library without names.
        factors: the stitches that are asked for, over the stitches at the usual loop length.
        yarn: name of the yarn.
        state: state in which the knits come to rest.
        quality: preset.
        device: device of the kernels.
    """
    names = sorted(patterns or pattern_names(), key=lambda name: stitches_of(resolve_pattern(name)))
    chosen, errors, counts = sm.Yarn.named(yarn), [], []
    began = time.perf_counter()
    yield "pattern", "factor", "stitches in 10 cm", "swatches", "error", "loop length, diameters"
    for first in range(0, len(names), TOGETHER):
        asked = _asked(names[first : first + TOGETHER], factors, chosen, state, quality, device)
        found = done_together(
            [
                partial(
                    sm.swatch_to, name, gauge=stitches, yarn=yarn, quality=quality, device=device, progress=False,
                    relaxation=state,
                )
                for name, _factor, stitches in asked
            ],
            ways_together(),
        )  # fmt: skip
        for (name, factor, stitches), made in zip(asked, found, strict=True):
            if isinstance(made, StitchMeshError):
                yield name, factor, f"{stitches:.2f}", "-", str(made), "-"
                errors.append(np.inf)
                continue
            errors.append(abs(made.errors["stitches"]))
            counts.append(made.relaxations)
            diameters = made.loop_length / (2.0 * made.yarn_radius)
            yield name, factor, f"{stitches:.2f}", made.relaxations, f"{100 * errors[-1]:.2f} %", f"{diameters:.2f}"
        note(f"{min(first + TOGETHER, len(names))} of {len(names)} knits after {time.perf_counter() - began:.0f} s")
    yield ""
    yield (
        f"{100 * np.mean(np.array(errors) <= TRUE):.1f} % of {len(errors)} searches in {len(names)} knits met the "
        f"stitches within {100 * TRUE:g} %, with {np.mean(counts):.2f} swatches on average."
    )


def _asked(
    names: Sequence[str], factors: Sequence[float], yarn: sm.Yarn, state: KnitState, quality: str, device: str
) -> list[tuple[str, float, float]]:
    """Relax knits at the usual loop length, and return what each is asked for: name, factor, stitches in 10 cm."""
    options = {"loop_length": yarn.loop_length, "yarn_radius": yarn.core_radius, "relaxation": state}
    material = sm.YarnMaterial.of_yarn(yarn)
    usual = sm.relax_swatches(
        [
            sm.SwatchRequest(name, material=material, quality=quality, relax_cell=True, options=options)
            for name in names
        ],
        device=device, progress=False,
    )  # fmt: skip
    asked = []
    for name, made in zip(names, usual, strict=True):
        if isinstance(made, StitchMeshError):
            note(f"{name}: {made}")
        else:
            asked += [(name, factor, made.report["gauge"]["stitches"] * factor) for factor in factors]
    return asked
