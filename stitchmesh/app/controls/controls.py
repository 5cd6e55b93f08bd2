# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The controls of a panel, as pages use them.

Every function that a control calls runs in the event thread. Every control has a hint of one line, which a browser
shows under the pointer and reads out.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

from stitchmesh.errors import ParameterError
from stitchmesh.markup import Markup

if TYPE_CHECKING:
    import plotly.graph_objects as go

ROUNDING = 1e-7
"""Distance by which a value may exceed its bounds, because a browser rounds a slider's ends to seven decimals."""


@dataclass(frozen=True)
class Bounds:
    """The values that an input takes."""

    label: str
    """Label of the input."""
    least: float
    most: float

    def check(self, given: object) -> None:
        """Refuse a value that is no number (also nan), or lies beyond the bounds.

        Raises:
            ParameterError: the value is refused.
        """
        is_number = isinstance(given, int | float) and not isinstance(given, bool)
        if is_number and self.least - ROUNDING <= given <= self.most + ROUNDING:  # type: ignore[operator]
            return
        shown = f"{given:g}" if is_number else repr(given)[:40]
        raise ParameterError(f"{self.label}: got {shown}; expected {self.least:g} to {self.most:g}")


def do_nothing(*_: object) -> None:
    """Do nothing. This is the function of an input whose value a page reads only when it needs it."""


class Control(Protocol):
    """A control in a panel. Setting a property changes the display, and calls no function of the page."""

    value: Any
    """Value of an input; percentage of a progress bar."""
    label: str
    content: Markup
    """The content of a piece of HTML."""
    figure: Any
    """Figure of a plot."""
    options: Any
    """The options of a list; its value is one of them."""
    visible: bool
    disabled: bool

    def remove(self) -> None:
        """Take the control out of the panel."""


class Controls(Protocol):
    """Makes controls, one below another. All methods belong to the event thread."""

    def button(self, label: str, hint: str, run: Callable[[], object], *, main: bool = False) -> Control:
        """Add a button; ``main`` marks the button that users press next."""

    def toggle(self, label: str, hint: str, value: bool, changed: Callable[[bool], object] = do_nothing) -> Control:
        """Add a box to tick."""

    def number(
        self, label: str, hint: str, value: float, changed: Callable[[float], object] = do_nothing, *,
        least: float, most: float, step: float,
    ) -> Control:  # fmt: skip
        """Add a number; it is whole if the value and the step are whole.

        A notice refuses a value that is no number, or beyond the bounds, and the last good value is shown again.
        """

    def slider(
        self, label: str, hint: str, value: float, changed: Callable[[float], object], *,
        least: float, most: float, step: float,
    ) -> Control:  # fmt: skip
        """Add a slider; it refuses the same values as a number."""

    def choice(
        self, label: str, hint: str, options: Sequence[str], value: str, changed: Callable[[str], object] = do_nothing
    ) -> Control:
        """Add a list of options; the user chooses one."""

    def buttons(self, label: str, hint: str, options: Sequence[str], pressed: Callable[[str], object]) -> Control:
        """Add buttons in one row."""

    def text(
        self, label: str, hint: str, value: str, changed: Callable[[str], object] = do_nothing, *, lines: int = 1
    ) -> Control:
        """Add a text; ``changed`` is called while the user types."""

    def colour(self, label: str, hint: str, value: str, changed: Callable[[str], object] = do_nothing) -> Control:
        """Add a colour, ``#rrggbb``."""

    def html(self, content: Markup, action: Callable[[str, str], object] | None = None) -> Control:
        """Add a piece of HTML; texts enter it through ``markup`` only.

        An element with ``data-action`` and ``data-value`` calls the action with both when it is clicked. Elements
        must be readable by keyboard and screen reader: buttons, with an ``aria-label`` if they hold a picture only.
        """

    def plot(self, figure: go.Figure | None = None, aspect: float = 1.6) -> Control:
        """Add a plot; without a figure it stays hidden. ``aspect`` is its width over its height."""

    def upload(
        self, label: str, hint: str, suffixes: Sequence[str], received: Callable[[str, bytes], object]
    ) -> Control:
        """Add a button that takes a file; ``received`` is called with the name of the file and its content."""

    def progress_bar(self) -> Control:
        """Add a bar whose value is a percentage."""

    def group(self, label: str, opened: bool = True) -> AbstractContextManager[Control]:
        """Add a group; controls that are made within the context stand in it."""

    def key(self, label: str, hint: str, hotkey: str, modifier: str | None, run: Callable[[], object]) -> Control:
        """Add a command for a key: a capital letter, with ``ctrl``, ``shift``, ``ctrl+shift`` or None."""

    def clear(self) -> None:
        """Remove all controls and keys."""
