# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Repeats in a row of words and in a list of rows, as knitting patterns write them: ``k3, [k2tog, yo] 4 times``."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from itertools import groupby

LONGEST = 48
"""Largest length of a repeated block."""
COUNTED = frozenset({"k", "p", "co", "dt", "bo"})
"""Words whose repeats are counted by a number, as in ``k3``; other words are repeated in brackets."""

Block = tuple[int, int, int]
"""Start, length and number of occurrences of a block."""


def repeats(items: Sequence[Hashable]) -> list[Block]:
    """Divide a sequence into blocks, each of which occurs once or several times in succession.

    The search goes from left to right. At each place it takes the block whose repeats shorten the sequence most, and
    the shortest of equally good blocks.
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


def fold_words(words: Sequence[str]) -> str:
    """Return the words of a row as one line with repeats."""
    tokens = [_token(word, len(list(run))) for word, run in groupby(words)]
    parts = []
    for start, length, times in repeats(tokens):
        block = ", ".join(tokens[start : start + length])
        parts.append(block if times == 1 else f"[{block}] {times} times")
    return ", ".join(parts)


def _times(items: Sequence[Hashable], place: int, length: int) -> int:
    """Number of successive occurrences of the block at a place."""
    times, following = 1, place + length
    while items[following : following + length] == items[place : place + length]:
        times += 1
        following += length
    return times


def _token(word: str, count: int) -> str:
    """A word that occurs ``count`` times in succession; the word may begin with a colour, as in ``A: k``."""
    if word.rpartition(": ")[2] in COUNTED:
        return f"{word}{count}"
    return word if count == 1 else f"[{word}] {count} times"
