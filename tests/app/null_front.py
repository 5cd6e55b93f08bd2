# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A front without a browser: a test builds a page on it, presses and reads its controls, and looks at its drawings."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

from stitchmesh.app.controls.controls import Bounds, do_nothing
from stitchmesh.app.event_queue import EventQueue
from stitchmesh.app.front import Listener, NoticeKind
from stitchmesh.app.scene.drawing import Drawing, shows_nothing
from stitchmesh.app.scene.scene import CameraView, ViewName
from stitchmesh.errors import DisplayError, ParameterError
from stitchmesh.markup import Markup, checked
from stitchmesh.mesh import FloatArray


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
        self.removed = True


class NullControls:
    """``Controls`` without a panel."""

    def __init__(self) -> None:
        self._made: list[NullControl] = []

    @property
    def made(self) -> list[NullControl]:
        """The present controls, in order."""
        return [control for control in self._made if not control.removed]

    def find(self, label: str) -> NullControl:
        """Return the control with a label; a hidden or disabled one is refused."""
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
        """Give a control another value, as a user does; a value beyond its bounds is refused."""
        control = self.find(label)
        if control.bounds is not None:
            control.bounds.check(value)
        control.value = value
        control.changed(value)

    def act(self, action: str, value: str = "") -> None:
        """Click the HTML element that has this action and this value."""
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
        return self._add("button", label, hint, changed=run)

    def toggle(self, label: str, hint: str, value: bool, changed: Callable[..., object] = do_nothing) -> NullControl:
        return self._add("toggle", label, hint, value=value, changed=changed)

    def number(
        self, label: str, hint: str, value: float, changed: Callable[..., object] = do_nothing, *,
        least: float, most: float, step: float,
    ) -> NullControl:  # fmt: skip
        return self._add("number", label, hint, value=value, changed=changed, bounds=Bounds(label, least, most))

    slider = number

    def choice(
        self, label: str, hint: str, options: Sequence[str], value: str, changed: Callable[..., object] = do_nothing
    ) -> NullControl:
        return self._add("choice", label, hint, value=value, changed=changed, options=tuple(options))

    def buttons(self, label: str, hint: str, options: Sequence[str], pressed: Callable[..., object]) -> NullControl:
        return self._add("buttons", label, hint, changed=pressed, options=tuple(options))

    def text(
        self, label: str, hint: str, value: str, changed: Callable[..., object] = do_nothing, *, lines: int = 1
    ) -> NullControl:
        return self._add("text", label, hint, value=value, changed=changed)

    def colour(self, label: str, hint: str, value: str, changed: Callable[..., object] = do_nothing) -> NullControl:
        return self._add("colour", label, hint, value=value, changed=changed)

    def html(self, content: Markup, action: Callable[[str, str], object] | None = None) -> NullControl:
        return self._add("html", content=content, changed=action or do_nothing)

    def plot(self, figure: Any = None, aspect: float = 1.6) -> NullControl:
        return self._add("plot", figure=figure)

    def upload(
        self, label: str, hint: str, suffixes: Sequence[str], received: Callable[[str, bytes], object]
    ) -> NullControl:
        return self._add("upload", label, hint, changed=received, options=tuple(suffixes))

    def progress_bar(self) -> NullControl:
        return self._add("progress", value=0.0)

    @contextmanager
    def group(self, label: str, opened: bool = True) -> Iterator[NullControl]:
        yield self._add("group", label)

    def key(self, label: str, hint: str, hotkey: str, modifier: str | None, run: Callable[[], object]) -> NullControl:
        return self._add("key", label, hint, changed=run)

    def clear(self) -> None:
        self._made.clear()

    def _add(self, kind: str, label: str = "", hint: str = "", **fields: Any) -> NullControl:
        control = NullControl(kind, label, hint, **fields)
        self._made.append(control)
        return control


class NullScene:
    """A ``DrawingScene`` without a screen, which keeps its drawings."""

    def __init__(self) -> None:
        self.drawings: dict[str, Drawing] = {}
        """The present drawings, by name."""
        self.shown: tuple[FloatArray, FloatArray, ViewName] | None = None
        """The box and the view of the last ``look_at``."""
        self.views: list[CameraView] = []
        """The cameras that ``cameras`` returns."""

    def show(self, name: str, drawing: Drawing | None) -> None:
        if drawing is None or shows_nothing(drawing):
            self.remove(name)
        else:
            self.drawings[name] = drawing

    def remove(self, name: str) -> None:
        self.drawings.pop(name, None)

    def clear(self) -> None:
        self.drawings.clear()

    def look_at(self, low: FloatArray, high: FloatArray, view: ViewName | None = None) -> None:
        self.shown = low, high, view or "front"

    def cameras(self) -> list[CameraView]:
        return self.views

    def screenshot(self, width: int, height: int) -> bytes:
        raise DisplayError(f"screenshot: no browser draws {width} x {height} pixels; open the page first")


@dataclass(eq=False)
class NullFront:
    """A ``Front`` that remembers what it was told."""

    queue: EventQueue = field(default_factory=EventQueue)
    scene: NullScene = field(default_factory=NullScene)
    navigation: NullControls = field(default_factory=NullControls)
    controls: NullControls = field(default_factory=NullControls)
    left_controls: NullControls = field(default_factory=NullControls)
    notices: list[tuple[str, str, NoticeKind]] = field(default_factory=list)
    downloads: list[tuple[str, bytes]] = field(default_factory=list)
    listener: Listener | None = None
    dark: bool = False
    acting_client: int | None = None

    def listen(self, listener: Listener) -> None:
        self.listener = listener

    def notice(self, title: str, text: str, kind: NoticeKind) -> None:
        self.notices.append((title, text, kind))

    def download(self, name: str, content: bytes, client: int | None = None) -> None:
        self.downloads.append((name, content))

    def set_dark(self, dark: bool) -> None:
        self.dark = dark

    def name_left_panel(self, title: str, width: int) -> None:
        """Do nothing."""

    def close(self) -> None:
        """Do nothing."""
