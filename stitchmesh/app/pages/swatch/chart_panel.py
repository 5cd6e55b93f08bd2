# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The left panel: the library of patterns, and the chart in which the user paints a pattern."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from stitchmesh.app.controls.chart_editor import ChartEditor
from stitchmesh.app.pages.own_patterns import OwnPatterns
from stitchmesh.patterns import Pattern, pattern_names
from stitchmesh.periodic.resolve_pattern import Source, resolve_pattern
from stitchmesh.periodic.weave.library import weave_names

if TYPE_CHECKING:
    from stitchmesh.app.application import App

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
