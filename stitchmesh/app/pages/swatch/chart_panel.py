# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The panel on the left: where the pattern comes from, and the chart in which it is painted."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import PurePath
from typing import TYPE_CHECKING

from stitchmesh.errors import FileError
from stitchmesh.io.atomic import write_bytes
from stitchmesh.patterns import pattern_names
from stitchmesh.periodic.resolve_pattern import Source, resolve_pattern
from stitchmesh.periodic.weave.library import weave_names

if TYPE_CHECKING:
    from stitchmesh.app.application import App

OWN = "own chart"
"""Entry of the list of patterns while the pattern is none of the library."""
SUFFIXES = (".txt", ".weave", ".png", ".bmp", ".gif")
"""Suffixes of files that hold a pattern."""
LARGEST_FILE = 5_000_000
"""Largest size of a file that is read [bytes]."""
FOLDER = "uploads"
"""Folder of the project that keeps uploaded files."""


class ChartPanel:
    """Library, upload and chart."""

    def __init__(self, app: App, source: Source, changed: Callable[[Source], object]) -> None:
        """Make the controls; ``changed`` is called with each new pattern."""
        self._app, self._changed = app, changed
        controls = app.left_controls
        names = (OWN, *pattern_names(), *weave_names())
        self._library = controls.choice("Start from", "A pattern of the library; its chart replaces the present one",
                                        names, OWN, self._choose)  # fmt: skip
        controls.upload("Open a chart", "A text or a picture of a chart, of a knit or a weave", SUFFIXES, self._receive)
        self._editor = TextChart(controls, source, self._painted)

    def show(self, source: Source) -> None:
        """Show another pattern, for example that of the other variant."""
        self._library.value = OWN
        self._editor.show(source)

    def _choose(self, name: str) -> None:
        """Take a pattern of the library."""
        if name == OWN:
            return
        source = resolve_pattern(name)
        self._editor.show(source)
        self._changed(source)

    def _painted(self, source: Source) -> None:
        self._library.value = OWN
        self._changed(source)

    def _receive(self, name: str, content: bytes) -> None:
        """Read an uploaded chart, and take it.

        Raises:
            FileError: the file is too large, or it cannot be read.
            PatternError: the file does not describe a pattern.
        """
        if len(content) > LARGEST_FILE:
            size = f"{len(content) / 1e6:.1f} MB"
            raise FileError(f"{name}: has {size}; expected a chart of at most {LARGEST_FILE / 1e6:g} MB")
        path = self._app.project.folder / FOLDER / PurePath(name.replace("\\", "/")).name
        write_bytes(path, content)
        source = resolve_pattern(path)
        self._library.value = OWN
        self._editor.show(source)
        self._changed(source)


class TextChart:
    def __init__(self, controls, source, changed):
        self._changed = changed
        self._text = controls.text("Chart as text", "The pattern", "", self._typed, lines=12)
        self.show(source)

    def show(self, source):
        from stitchmesh.patterns import Pattern, format_pattern
        from stitchmesh.periodic.weave.text import format_weave
        self._text.value = format_pattern(source) if isinstance(source, Pattern) else format_weave(source)

    def _typed(self, text):
        from stitchmesh.patterns import parse_pattern
        from stitchmesh.periodic.weave.text import parse_weave
        try:
            source = parse_pattern(text)
        except Exception:
            source = parse_weave(text)
        self._changed(source)
