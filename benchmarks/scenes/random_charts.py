# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Random charts of knit and purl stitches and of cables, always the same ones, for measurements beyond the library.

Four families in turn: welts (whole rows), blocks, diagonals, ropes on purl stitches. ``random_chart(n)`` is chart n,
of at most 160 stitches.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

import stitchmesh as sm

Random = np.random.Generator


def random_chart(number: int) -> sm.Pattern:
    """The chart of a number."""
    return sm.parse_pattern(chart_text(number))


def chart_text(number: int) -> str:
    """The same as text."""
    families: list[tuple[str, Callable[[Random], list[str]]]] = [
        ("welt", welt), ("blocks", blocks), ("diagonal", diagonal), ("rope", rope)
    ]  # fmt: skip
    name, lines = families[number % len(families)]
    return "\n".join([f'pattern "{name} {number}"', *lines(np.random.default_rng(number))])


def runs(random: Random, most: int) -> str:
    """Two runs, or ``most``, of up to four knit and purl stitches, or of such rows, in turn."""
    lengths = random.integers(1, 5, size=random.choice([2, most]))
    return "".join("KP"[k % 2] * int(length) for k, length in enumerate(lengths))


def welt(random: Random) -> list[str]:
    """Whole rows of knit and of purl stitches; an odd number of rows is knitted twice."""
    rows = runs(random, 4)
    return ["chart leaf:", *(rows if len(rows) % 2 == 0 else 2 * rows)]


def blocks(random: Random) -> list[str]:
    """Blocks of knit and of purl stitches in turn."""
    row, high = runs(random, 4), int(random.integers(1, 6))
    other = row.translate(str.maketrans("KP", "PK"))
    return ["chart leaf:", *[row] * high, *[other] * high]


def diagonal(random: Random) -> list[str]:
    """Stripes that lean by a stitch in each row; an odd number of rows is knitted twice."""
    row, way = runs(random, 2), int(random.choice([-1, 1]))
    lines = [row[k:] + row[:k] for k in (way * np.arange(len(row)) % len(row)).tolist()]
    return ["chart leaf:", *(lines if len(lines) % 2 == 0 else 2 * lines)]


def rope(random: Random) -> list[str]:
    """A rope of two strands between purl stitches."""
    strand, beside, rows = int(random.integers(1, 4)), int(random.integers(1, 4)), 2 * int(random.integers(2, 7))
    cross = f"c{2 * strand}{random.choice(['f', 'b'])}"
    purl, plain = f"p{beside}", ", ".join(str(row) for row in range(3, rows, 2))
    wrong = ", ".join(str(row) for row in range(2, rows + 1, 2))
    return [f"row 1 RS: {purl} {cross} {purl}", f"row{'s' if rows > 4 else ''} {plain} RS: {purl} k{2 * strand} {purl}",
            f"rows {wrong} WS: k{beside} p{2 * strand} k{beside}"]  # fmt: skip
