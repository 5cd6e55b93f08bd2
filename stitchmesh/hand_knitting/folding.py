# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Repeats in a row of words, and in a list of rows, as patterns write them: ``k3, [k2tog, yo] 4 times, k1``."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from itertools import groupby

LONGEST = 48
"""Words in the longest repeat that is looked for."""
COUNTED = frozenset({"k", "p", "co", "dt", "bo"})
"""Words that a number follows: ``k3``; others are repeated in brackets."""

Block = tuple[int, int, int]
"""Where a block starts, how long it is, and how often it comes."""


def repeats(items: Sequence[Hashable]) -> list[Block]:
    """Cut a sequence into blocks that come once or several times running.

    From the left, each time the block whose repeats leave the most unsaid; the shortest of equals.
    """
    blocks: list[Block] = []
    place = 0
    while place < len(items):
        best = (0, 1, 1)
        for length in range(1, min(LONGEST, (len(items) - place) // 2) + 1):
            times = _times(items, place, length)
            saved = (times - 1) * length
            if saved > best[0]:
                best = (saved, length, times)
        blocks.append((place, best[1], best[2]))
        place += best[1] * best[2]
    return blocks


def folded(words: Sequence[str]) -> str:
    """One line for the words of a row."""
    tokens = [_token(word, len(list(run))) for word, run in groupby(words)]
    parts = []
    for start, length, times in repeats(tokens):
        block = ", ".join(tokens[start : start + length])
        parts.append(block if times == 1 else f"[{block}] {times} times")
    return ", ".join(parts)


def _times(items: Sequence[Hashable], place: int, length: int) -> int:
    """How often the block at this place comes running."""
    times, following = 1, place + length
    while items[following : following + length] == items[place : place + length]:
        times += 1
        following += length
    return times


def _token(word: str, count: int) -> str:
    """A word that comes several times; a colour may stand before it."""
    if word.rpartition(": ")[2] in COUNTED:
        return f"{word}{count}"
    return word if count == 1 else f"[{word}] {count} times"
