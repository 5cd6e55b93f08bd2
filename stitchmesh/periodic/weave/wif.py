# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Weaves as drafts of looms, in the Weaving Information File format (WIF 1.1, 1997): sections of lines ``key=value``.

``THREADING`` gives the shafts of each warp from the left, ``TREADLING`` the treadles of each weft from the bottom, and
``TIEUP`` the shafts of each treadle; ``LIFTPLAN`` gives the shafts of each weft instead of the last two. A warp lies
over a weft if the weft lifts one of its shafts; it lies under it if the loom has a falling shed. The sections ``COLOR
TABLE``, ``WARP COLORS`` and ``WEFT COLORS`` give the colours. Thickness, spacing and notes are not read. The weave is
the smallest repeat of the draft.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import PatternError
from stitchmesh.periodic.weave.text import MOST_CROSSINGS
from stitchmesh.periodic.weave.weave import Thread, Weave

SUFFIX = ".wif"
WHOLE = re.compile(r"\d{1,6}", re.ASCII)

Section = dict[str, str]
"""Values of a section by their keys, in small letters."""


def parse_wif(text: str, name: str = "weave") -> Weave:
    """Read the weave of a draft.

    Args:
        text: the content of the file.
        name: the name of the text in messages, and of the weave if the text has no title.

    Raises:
        PatternError: a section is missing or malformed, the draft is too large, or the fabric falls apart.
    """
    sections = _sections(text)
    try:
        ends, picks = (_count(sections, kind) for kind in ("warp", "weft"))
        if ends * picks > MOST_CROSSINGS:
            raise PatternError(f"got {picks} wefts and {ends} warps; expected at most {MOST_CROSSINGS} crossings")
        over = ~_lifted(sections, ends, picks)
        if sections.get("weaving", {}).get("rising shed", "true").lower() in ("false", "0", "no", "off"):
            over = ~over
        warps, wefts, palette = _colours(sections, ends, picks)
        width, height = _period(over.T, warps), _period(over, wefts)
        title = (sections.get("text", {}).get("title") or Path(name).stem).replace('"', "'")
        matrix = tuple(map(tuple, over[:height, :width][::-1].astype(int).tolist()))
        rows, columns = (tuple(map(_thread, colours)) for colours in (wefts[:height][::-1], warps[:width]))
        return Weave(matrix, rows, columns, name=title, palette=palette)
    except PatternError as error:
        raise PatternError(f"{name}: {error}") from None


def _sections(text: str) -> dict[str, Section]:
    """Return the sections by their names, in small letters."""
    found: dict[str, Section] = {}
    here: Section = {}
    for line in text.splitlines():
        words = line.partition(";")[0].strip()
        if words.startswith("[") and words.endswith("]"):
            here = found.setdefault(words[1:-1].strip().lower(), {})
        elif "=" in words:
            key, _, value = words.partition("=")
            here[key.strip().lower()] = value.strip()
    return found


def _whole(text: str, where: str) -> list[int]:
    """Return the whole numbers of a list with commas; 0 stands for none."""
    parts = [part.strip() for part in text.split(",") if part.strip()]
    bad = next((part for part in parts if not WHOLE.fullmatch(part)), None)
    if bad is not None:
        raise PatternError(f"[{where}]: got {bad[:20]!r}; expected whole numbers")
    return [number for number in map(int, parts) if number]


def _count(sections: dict[str, Section], kind: str) -> int:
    """Return the number of warps or wefts."""
    numbers = _whole(sections.get(kind, {}).get("threads", ""), kind.upper())
    if len(numbers) != 1:
        raise PatternError(f"[{kind.upper()}]: has no number of threads; expected Threads=8")
    return numbers[0]


def _rows(sections: dict[str, Section], name: str, count: int) -> list[frozenset[int]]:
    """Return the numbers of the keys 1 to ``count`` of a section."""
    where = name.upper()
    if name not in sections:
        raise PatternError(f"has no section [{where}]; expected a draft with threading and treadling or a lift plan")
    return [frozenset(_whole(sections[name].get(str(key), ""), where)) for key in range(1, count + 1)]


def _lifted(sections: dict[str, Section], ends: int, picks: int) -> NDArray[np.bool_]:
    """Whether each weft lifts each warp, shape (picks, ends)."""
    shafts = _rows(sections, "threading", ends)
    if "liftplan" in sections:
        lifts = _rows(sections, "liftplan", picks)
    else:
        treadles, tied = _rows(sections, "treadling", picks), sections.get("tieup", {})
        used = {number for row in treadles for number in row}
        own = {number: frozenset(_whole(tied.get(str(number), ""), "TIEUP")) for number in used}
        lifts = [frozenset[int]().union(*(own[number] for number in row)) for row in treadles]
    rows = {lift: [not held.isdisjoint(lift) for held in shafts] for lift in set(lifts)}
    return np.array([rows[lift] for lift in lifts], dtype=bool)


def _colours(
    sections: dict[str, Section], ends: int, picks: int
) -> tuple[list[int], list[int], tuple[tuple[int, int, int], ...]]:
    """Return the colour number of each warp and of each weft, and the colours; all numbers are 0 without colours."""
    table = sections.get("color table", {})
    used: dict[str, int] = {}
    numbers = []
    for kind, count in (("warp", ends), ("weft", picks)):
        common = sections.get(kind, {}).get("color", "")
        own = sections.get(f"{kind} colors", {})
        keys = [(own.get(str(key)) or common).split(",")[0].strip() for key in range(1, count + 1)]
        numbers.append([used.setdefault(key, len(used)) if key in table else -1 for key in keys])
    if not used or -1 in numbers[0] + numbers[1]:
        return [0] * ends, [0] * picks, ()
    return numbers[0], numbers[1], tuple(_colour(table[key], sections) for key in used)


def _colour(text: str, sections: dict[str, Section]) -> tuple[int, int, int]:
    """Return a colour of the table scaled to 0 ... 255 from the range of the table."""
    limits = sections.get("color palette", {}).get("range", "0,255").split(",")
    parts = [part.strip() for part in [*text.split(",")[:3], *limits]]
    if len(parts) != 5 or not all(WHOLE.fullmatch(part) for part in parts) or int(parts[3]) >= int(parts[4]):
        found = f"got the colour {text[:20]!r} in the range {','.join(limits)[:20]!r}"
        raise PatternError(f"[COLOR TABLE]: {found}; expected three whole numbers in a range such as 0,255")
    *values, low, high = map(int, parts)
    red, green, blue = (min(max(round(255 * (value - low) / (high - low)), 0), 255) for value in values)
    return red, green, blue


def _thread(colour: int) -> Thread:
    return Thread(colour=colour)


def _period(rows: NDArray[np.bool_], colours: Sequence[int]) -> int:
    """Return the smallest number of rows whose repetition gives all rows and their colours."""
    together = np.column_stack([rows, colours])
    count = len(together)
    periods = (number for number in range(1, count + 1) if count % number == 0)
    return next(one for one in periods if np.array_equal(together[one:], together[: count - one]))
