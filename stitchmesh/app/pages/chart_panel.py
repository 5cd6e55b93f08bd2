# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The patterns that pages offer, the library and the user's own, and the chart in which the user paints one.

The user's own patterns were opened from files, captured from fabrics, or designed on the page Swatch. The settings of
the project hold them as texts.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from stitchmesh.app.controls.chart_editor import ChartEditor
from stitchmesh.app.pages.swatch.state import swatch_patterns
from stitchmesh.errors import PatternError
from stitchmesh.patterns import Pattern, pattern_names
from stitchmesh.patterns.language.parse import parse_pattern
from stitchmesh.patterns.language.writing import format_pattern
from stitchmesh.periodic.resolve_pattern import Source, resolve_pattern
from stitchmesh.periodic.weave.library import weave_names

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


OWN = "own chart"
"""Entry of the list of patterns while the user paints the chart."""


class ChartPanel:
    """Library and chart."""

    def __init__(
        self, app: App, source: Source, text: str, changed: Callable[[Source], object], edited: Callable[[str], object]
    ) -> None:
        """Make the controls.

        Args:
            app: the application.
            source: the last valid pattern.
            text: the text of the chart, valid or not; if it is empty, the chart shows the pattern.
            changed: called with each new pattern.
            edited: called with the text of the chart after each change.
        """
        self._app, self._changed, self._edited = app, changed, edited
        self._own = OwnPatterns(app)
        self._build(source, text)

    def show(self, source: Source, text: str) -> None:
        """Show the chart of another variant, with its own steps."""
        self._app.left_controls.clear()
        self._build(source, text)

    def _build(self, source: Source, text: str) -> None:
        controls = self._app.left_controls
        hint = "A pattern of the library or of your own; Undo brings the present chart back"
        self._library = controls.choice("Start from", hint, self._names(), OWN, self._choose)
        self._editor = ChartEditor(controls, source, self._painted, download=self._app.download,
                                   edited=self._edited, text=text, opened=self._keep)  # fmt: skip

    def _names(self) -> tuple[str, ...]:
        return (OWN, *self._own.kept, *pattern_names(), *weave_names())

    def _choose(self, name: str) -> None:
        if name != OWN:
            self._editor.show(self._own.kept.get(name) or resolve_pattern(name))
            self._library.value = name

    def _keep(self, source: Source) -> None:
        if isinstance(source, Pattern):
            self._own.keep(source)
            self._library.options = self._names()

    def _painted(self, source: Source) -> None:
        self._library.value = OWN
        self._changed(source)
