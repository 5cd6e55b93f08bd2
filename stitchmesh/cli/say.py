# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""All output of the command line is printed here.

Names of files, and texts in files, may hold control characters, for example one that clears the terminal. Names that
are not UTF-8 also give characters that no text can hold.
"""

from __future__ import annotations

import unicodedata
from typing import TextIO

from stitchmesh.errors import REPLACEMENT

KEPT = "\n\t"
"""Characters that are no letters, and are printed."""


def say(text: str, *, file: TextIO | None = None, end: str = "\n", flush: bool = False) -> None:
    """Print a text, on standard output if no file is given."""
    print(printable(text), file=file, end=end, flush=flush)


def printable(text: str) -> str:
    """Return a text with a mark in the place of control characters, and of those that turn the order of letters.

    These are the categories C (other), Zl and Zp (separators of lines and paragraphs) of Unicode.
    """
    if text.isprintable():
        return text
    return "".join(REPLACEMENT if _commands(character) else character for character in text)


def _commands(character: str) -> bool:
    category = unicodedata.category(character)
    return character not in KEPT and (category[0] == "C" or category in ("Zl", "Zp"))
