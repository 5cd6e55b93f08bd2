# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Controls without a panel: a test builds a page with them, and presses and reads them without a browser."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

from stitchmesh.app.controls.controls import Bounds, do_nothing
from stitchmesh.errors import ParameterError
from stitchmesh.markup import Markup, checked


@dataclass(eq=False)
class NullControl:
    """A control with its present values."""

    kind: str
    label: str
    hint: str = ""
    value: Any = None
    changed: Callable[..., object] = field(default=do_nothing)
    content: Markup = field(default_factory=Markup)
    figure: Any = None
    visible: bool = True
    disabled: bool = False
    options: tuple[str, ...] = ()
    bounds: Bounds | None = None
    removed: bool = False

    def __setattr__(self, name: str, value: Any) -> None:
        """Set a property; content must not be a plain text, as in a browser."""
        object.__setattr__(self, name, checked(value) if name == "content" else value)

    def remove(self) -> None:
        """Mark the control as removed."""
        self.removed = True


class NullControls:
    """``Controls`` without a panel."""

    def __init__(self) -> None:
        """Start empty."""
        self._made: list[NullControl] = []

    @property
    def made(self) -> list[NullControl]:
        """The present controls, in order."""
        return [control for control in self._made if not control.removed]

    def find(self, label: str) -> NullControl:
        """Return the control with a label.

        Raises:
            ParameterError: no control has the label, or it is hidden or disabled.
        """
        for control in self.made:
            if control.label == label:
                if control.visible and not control.disabled:
                    return control
                raise ParameterError(f"control {label!r}: is {'disabled' if control.visible else 'hidden'}")
        labels = [control.label for control in self.made if control.label]
        near = difflib.get_close_matches(label, labels, n=1) or [", ".join(labels)]
        raise ParameterError(f"control {label!r}: does not exist; expected {near[0]}")

    def press(self, label: str, option: str | None = None) -> None:
        """Press a button, one option of a row of buttons, or a key."""
        control = self.find(label)
        control.changed(*(() if option is None else (option,)))

    def set(self, label: str, value: object) -> None:
        """Give a control another value, as a user does.

        Raises:
            ParameterError: the control does not take the value.
        """
        control = self.find(label)
        if control.bounds is not None:
            control.bounds.check(value)
        control.value = value
        control.changed(value)

    def act(self, action: str, value: str = "") -> None:
        """Click the HTML element that has this action.

        Raises:
            ParameterError: no element on the panel has the action and the value.
        """
        for control in self.made:
            if f'data-action="{action}"' in control.content and f'data-value="{value}"' in control.content:
                control.changed(action, value)
                return
        raise ParameterError(f"action {action!r}: no element has it with the value {value!r}")

    def send(self, label: str, name: str, content: bytes) -> None:
        """Upload a file."""
        self.find(label).changed(name, content)

    def text_shown(self) -> str:
        """Return all HTML that is visible."""
        return "\n".join(control.content for control in self.made if control.visible and control.content)

    def button(self, label: str, hint: str, run: Callable[[], object], *, main: bool = False) -> NullControl:
        """Add a button."""
        return self._add("button", label, hint, changed=run)

    def toggle(self, label: str, hint: str, value: bool, changed: Callable[[bool], object] = do_nothing) -> NullControl:
        """Add a box to tick."""
        return self._add("toggle", label, hint, value=value, changed=changed)

    def number(
        self, label: str, hint: str, value: float, changed: Callable[[float], object] = do_nothing, *,
        least: float, most: float, step: float,
    ) -> NullControl:  # fmt: skip
        """Add a number."""
        return self._add("number", label, hint, value=value, changed=changed, bounds=Bounds(label, least, most))

    def slider(
        self, label: str, hint: str, value: float, changed: Callable[[float], object], *,
        least: float, most: float, step: float,
    ) -> NullControl:  # fmt: skip
        """Add a slider."""
        return self._add("slider", label, hint, value=value, changed=changed, bounds=Bounds(label, least, most))

    def choice(
        self, label: str, hint: str, options: Sequence[str], value: str, changed: Callable[[str], object] = do_nothing
    ) -> NullControl:
        """Add a list of options."""
        return self._add("choice", label, hint, value=value, changed=changed, options=tuple(options))

    def buttons(self, label: str, hint: str, options: Sequence[str], pressed: Callable[[str], object]) -> NullControl:
        """Add buttons in one row."""
        return self._add("buttons", label, hint, changed=pressed, options=tuple(options))

    def text(
        self, label: str, hint: str, value: str, changed: Callable[[str], object] = do_nothing, *, lines: int = 1
    ) -> NullControl:
        """Add a text."""
        return self._add("text", label, hint, value=value, changed=changed)

    def colour(self, label: str, hint: str, value: str, changed: Callable[[str], object] = do_nothing) -> NullControl:
        """Add a colour."""
        return self._add("colour", label, hint, value=value, changed=changed)

    def html(self, content: Markup, action: Callable[[str, str], object] | None = None) -> NullControl:
        """Add a piece of HTML."""
        return self._add("html", content=content, changed=action or do_nothing)

    def plot(self, figure: Any = None, aspect: float = 1.6) -> NullControl:
        """Add a plot."""
        return self._add("plot", figure=figure)

    def upload(
        self, label: str, hint: str, suffixes: Sequence[str], received: Callable[[str, bytes], object]
    ) -> NullControl:
        """Add a button that takes a file."""
        return self._add("upload", label, hint, changed=received, options=tuple(suffixes))

    def progress_bar(self) -> NullControl:
        """Add a bar."""
        return self._add("progress", value=0.0)

    @contextmanager
    def group(self, label: str, opened: bool = True) -> Iterator[NullControl]:
        """Add a group."""
        yield self._add("group", label)

    def key(self, label: str, hint: str, hotkey: str, modifier: str | None, run: Callable[[], object]) -> NullControl:
        """Add a command that a key calls."""
        return self._add("key", label, hint, changed=run)

    def clear(self) -> None:
        """Remove all controls."""
        self._made.clear()

    def _add(self, kind: str, label: str = "", hint: str = "", **fields: Any) -> NullControl:
        control = NullControl(kind, label, hint, **fields)
        self._made.append(control)
        return control
