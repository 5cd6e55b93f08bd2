# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The one place in which text becomes HTML.

Names in files, and messages about them, may hold HTML that would run as a script in the page. Controls of the
application therefore show only ``Markup``. It is made only from templates of the program, and each text that is put
into a template is escaped.
"""

from __future__ import annotations

from collections.abc import Iterable
from html import escape


class Markup(str):
    """HTML that is safe to show; ``Markup()`` is empty.

    The sum of two values is ``Markup`` too. All other results, such as an f-string, are plain text again.
    """

    def __add__(self, other: Markup) -> Markup:  # type: ignore[override]
        """Return this HTML with other HTML after it.

        Raises:
            TypeError: the other value is a plain text.
        """
        return Markup(str.__add__(self, checked(other)))


def markup(template: str, *parts: object) -> Markup:
    """Return HTML from a template of the program, with one of the parts in the place of each ``{}``.

    A part that is ``Markup`` is put in unchanged. All others are put in as escaped texts, which are safe within the
    quotes of an attribute too. A template without parts is taken unchanged, with its braces.
    """
    escaped = [part if isinstance(part, Markup) else escape(_text(part)) for part in parts]
    return Markup(template.format(*escaped) if parts else template)


def _text(part: object) -> str:
    """Return a part as a text that UTF-8 can hold, because the name of a file may hold what UTF-8 cannot."""
    return str(part).encode("utf-8", "replace").decode("utf-8")


def joined(parts: Iterable[Markup]) -> Markup:
    """Return pieces one after another.

    Raises:
        TypeError: one of them is a plain text.
    """
    return Markup("".join(map(checked, parts)))


def checked(content: str) -> Markup:
    """Return HTML that is to be shown.

    Raises:
        TypeError: it is a plain text.
    """
    if not isinstance(content, Markup):
        raise TypeError(f"got the plain text {content[:40]!r} where HTML is shown; expected what `markup` returns")
    return content


def css_text(text: str) -> Markup:
    """Return a text for a string of a style sheet; all characters but ASCII letters and digits become their numbers."""
    return Markup("".join(sign if sign.isascii() and sign.isalnum() else f"\\{ord(sign):x} " for sign in text))
