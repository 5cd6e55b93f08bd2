# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The user's own patterns in a project: opened from files, captured from fabrics, or designed on the page Swatch.

Pages list them beside the patterns of the library. The settings of the project hold them as texts.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from stitchmesh.app.pages.swatch.state import swatch_patterns
from stitchmesh.errors import PatternError
from stitchmesh.patterns import Pattern
from stitchmesh.patterns.language.parse import parse_pattern
from stitchmesh.patterns.language.writing import format_pattern

if TYPE_CHECKING:
    from stitchmesh.app.application import App

PLACE, KEY = "Own patterns", "texts"
"""Where the project keeps the patterns."""


class OwnPatterns:
    """The patterns of the user, by the names under which pages list them."""

    def __init__(self, app: App) -> None:
        """Keep the application, whose project holds the patterns."""
        self._app = app
        self.on_change: Callable[[], object] = lambda: None
        """Called when a pattern has been added."""

    @property
    def kept(self) -> dict[str, Pattern]:
        """The patterns that were opened or captured, the newest first."""
        patterns = [pattern for pattern in map(_read, self._texts()) if pattern is not None]
        numbered = list(enumerate(patterns, start=1))
        return {f"own {number}: {pattern.name or 'chart'}": pattern for number, pattern in reversed(numbered)}

    @property
    def all(self) -> dict[str, Pattern]:
        """The kept patterns, then the patterns of the page Swatch."""
        return {**self.kept, **swatch_patterns(self._settings("Swatch"))}

    def keep(self, pattern: Pattern) -> None:
        """Add a pattern, unless it is there already."""
        text, texts = format_pattern(pattern), self._texts()
        if text not in texts:
            self._app.project.set_settings(PLACE, {KEY: [*texts, text][-40:]})  # the oldest are dropped first
            self.on_change()

    def _texts(self) -> list[str]:
        found = self._settings(PLACE).get(KEY, [])
        return [str(text) for text in found] if isinstance(found, list) else []

    def _settings(self, place: str) -> Mapping[str, Any]:
        return self._app.project.settings(place)


def _read(text: str) -> Pattern | None:
    """Return the pattern of a text; None if the file of the project is damaged."""
    try:
        return parse_pattern(text)
    except PatternError:
        return None
