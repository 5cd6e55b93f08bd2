# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Controls in the browsers, made by viser."""

from __future__ import annotations

import asyncio
import itertools
from collections.abc import Callable, Coroutine, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from typing import TYPE_CHECKING, Any

import viser

from stitchmesh.app.browser.bridge import Bridge
from stitchmesh.app.controls.controls import Bounds, do_nothing
from stitchmesh.app.controls.value_guard import ValueGuard
from stitchmesh.app.event_queue import EventQueue
from stitchmesh.app.page_messages import NO_FILE
from stitchmesh.markup import Markup, checked, markup
from stitchmesh.mesh.palette import colour_text, parse_colour

if TYPE_CHECKING:
    import plotly.graph_objects as go

BLUE = (31, 86, 115)
"""Colour of the button that users press next, and of the marks of controls."""
GREY = (92, 99, 106)
"""Colour of the other buttons, on which white letters are readable."""
HTML_STYLE = "margin:0 .75em .5em;color:var(--mantine-color-text)"
"""Margins and colour of a piece of HTML; the other controls have the same."""
MODIFIERS = {None: None, "ctrl": "cmd/ctrl", "shift": "shift", "ctrl+shift": "cmd/ctrl+shift"}
"""Viser's names of the modifier keys."""


class ViserControl:
    """A control of viser; a property that already has the new value sends nothing."""

    content: Markup = Markup()

    def __init__(self, handle: Any, forget: Callable[[], None] = lambda: None) -> None:
        """Wrap a handle of viser; ``forget`` is called when the control is removed."""
        self.handle, self._forget = handle, forget

    @property
    def value(self) -> Any:
        """Value of an input."""
        return self.handle.value

    @value.setter
    def value(self, value: Any) -> None:
        self._set("value", value)

    @property
    def label(self) -> str:
        """Label."""
        return str(self.handle.label)

    @label.setter
    def label(self, label: str) -> None:
        self._set("label", label)

    @property
    def options(self) -> Any:
        """The options of a list."""
        return self.handle.options

    @options.setter
    def options(self, options: Any) -> None:
        self._set("options", tuple(options))

    @property
    def figure(self) -> Any:
        """Figure of a plot."""
        return self.handle.figure

    @figure.setter
    def figure(self, figure: Any) -> None:
        if figure is not None:
            self.handle.figure = styled(figure)
        self.visible = figure is not None

    @property
    def visible(self) -> bool:
        """Whether the control is shown."""
        return bool(self.handle.visible)

    @visible.setter
    def visible(self, visible: bool) -> None:
        self._set("visible", visible)

    @property
    def disabled(self) -> bool:
        """Whether the control takes no input."""
        return bool(self.handle.disabled)

    @disabled.setter
    def disabled(self, disabled: bool) -> None:
        self._set("disabled", disabled)

    def remove(self) -> None:
        """Take the control out of the panel; nothing happens if its whole group is gone."""
        self._forget()
        if not self.removed:
            self.handle.remove()

    @property
    def removed(self) -> bool:
        """Whether the control is gone; viser then refuses to set anything."""
        return bool(getattr(self.handle._impl, "removed", False))

    def _set(self, name: str, value: Any) -> None:
        if not self.removed and getattr(self.handle, name) != value:
            setattr(self.handle, name, value)


class ColourControl(ViserControl):
    """A colour: three numbers for viser, and ``#rrggbb`` for pages."""

    @property
    def value(self) -> str:
        """The colour, ``#rrggbb``."""
        return colour_text(self.handle.value)

    @value.setter
    def value(self, value: str) -> None:
        self._set("value", tuple(parse_colour(value).tolist()))


class HtmlControl(ViserControl):
    """A piece of HTML, inside an element by which the bridge knows it."""

    def __init__(self, handle: Any, identity: str, forget: Callable[[], None]) -> None:
        """Wrap a handle; messages arrive under the name ``identity``."""
        super().__init__(handle, forget)
        self._identity, self._content = identity, Markup()

    @property
    def content(self) -> Markup:
        """The HTML, without the element around it."""
        return self._content

    @content.setter
    def content(self, content: Markup) -> None:
        self._content = checked(content)
        frame = '<div data-stitchmesh="{}" style="{}">{}</div>'
        self._set("content", str(markup(frame, self._identity, HTML_STYLE, content)))


class ViserControls:
    """``Controls`` in a container of viser."""

    _numbers = itertools.count()

    def __init__(
        self, server: viser.ViserServer, bridge: Bridge, queue: EventQueue, guard: ValueGuard, *,
        container: Callable[[], AbstractContextManager[Any]] = nullcontext,
        on_change: Callable[[int], None] = lambda _: None,
    ) -> None:  # fmt: skip
        """Make controls.

        Args:
            server: the server.
            bridge: the bridge, for hints and actions.
            queue: the queue in which all functions are called.
            guard: the guard that refuses numbers beyond their bounds.
            container: makes the context in which viser places controls.
            on_change: called with the number of controls, after controls were made or removed.
        """
        self._server, self._bridge, self._queue, self._guard = server, bridge, queue, guard
        self._container, self._on_change = container, on_change
        self._made: list[ViserControl] = []
        self._groups: list[Any] = []

    def button(self, label: str, hint: str, run: Callable[[], object], *, main: bool = False) -> ViserControl:
        """Add a button."""
        with self._place():
            handle = self._server.gui.add_button(label, hint=hint, color=BLUE if main else GREY)
        handle.on_click(self._in_order(run))
        self._bridge.set_hint(handle._impl.uuid, hint)
        return self._keep(handle)

    def toggle(
        self, label: str, hint: str, value: bool, changed: Callable[[bool], object] = do_nothing
    ) -> ViserControl:
        """Add a box to tick."""
        with self._place():
            return self._input(self._server.gui.add_checkbox(label, value, hint=hint), changed)

    def number(
        self, label: str, hint: str, value: float, changed: Callable[[float], object] = do_nothing, *,
        least: float, most: float, step: float,
    ) -> ViserControl:  # fmt: skip
        """Add a number."""
        with self._place():
            handle: Any = self._server.gui.add_number(label, value, min=least, max=most, step=step, hint=hint)
        return self._bounded(handle, Bounds(label, least, most), changed)

    def slider(
        self, label: str, hint: str, value: float, changed: Callable[[float], object], *,
        least: float, most: float, step: float,
    ) -> ViserControl:  # fmt: skip
        """Add a slider."""
        with self._place():
            handle = self._server.gui.add_slider(label, min=least, max=most, step=step, initial_value=value, hint=hint)
        return self._bounded(handle, Bounds(label, least, most), changed)

    def choice(
        self, label: str, hint: str, options: Sequence[str], value: str, changed: Callable[[str], object] = do_nothing
    ) -> ViserControl:
        """Add a list of options."""
        with self._place():
            handle = self._server.gui.add_dropdown(label, tuple(options), initial_value=value, hint=hint)
        return self._input(handle, changed)

    def buttons(self, label: str, hint: str, options: Sequence[str], pressed: Callable[[str], object]) -> ViserControl:
        """Add buttons in one row."""
        with self._place():
            handle = self._server.gui.add_button_group(label, tuple(options), hint=hint)
        handle.on_click(self._in_order(pressed, lambda event: (event.target.value,)))
        return self._keep(handle)

    def text(
        self, label: str, hint: str, value: str, changed: Callable[[str], object] = do_nothing, *, lines: int = 1
    ) -> ViserControl:
        """Add a text."""
        with self._place():
            handle = self._server.gui.add_text(label, value, multiline=lines > 1, hint=hint)
        return self._input(handle, changed)

    def colour(self, label: str, hint: str, value: str, changed: Callable[[str], object] = do_nothing) -> ViserControl:
        """Add a colour."""
        with self._place():
            handle = self._server.gui.add_rgb(label, tuple(parse_colour(value).tolist()), hint=hint)
        return self._input(handle, lambda given: changed(colour_text(given)), ColourControl)

    def html(self, content: Markup, action: Callable[[str, str], object] | None = None) -> ViserControl:
        """Add a piece of HTML."""
        identity = f"html{next(self._numbers)}"
        with self._place():
            control = HtmlControl(self._server.gui.add_html(""), identity, lambda: self._bridge.forget(identity))
        control.content = content
        if action is not None:
            # a browser may send a message just before it learns that the user has left the page
            given = lambda *words: None if control.removed else action(*words)  # noqa: E731
            self._bridge.receive(identity, lambda message, client: self._act(given, message, client))
        return self._keep_control(control)

    def plot(self, figure: go.Figure | None = None, aspect: float = 1.6) -> ViserControl:
        """Add a plot."""
        import plotly.graph_objects as go

        with self._place():
            shown = styled(figure or go.Figure())
            handle = self._server.gui.add_plotly(shown, aspect=1.0 / aspect, visible=figure is not None)
        return self._keep(handle)

    def upload(
        self, label: str, hint: str, suffixes: Sequence[str], received: Callable[[str, bytes], object]
    ) -> ViserControl:
        """Add a button that takes a file."""
        with self._place():
            handle = self._server.gui.add_upload_button(label, hint=hint, mime_type=",".join(suffixes), color=GREY)

        async def post(event: viser.GuiEvent) -> None:
            file = event.target.value
            await asyncio.sleep(0.25)  # The browser ends its notice of the upload while its button remains.
            self._post(event, take, file.name, file.content)

        def take(name: str, content: bytes) -> None:
            handle._impl.value = NO_FILE
            received(name, content)

        handle.on_upload(post)
        self._bridge.set_hint(handle._impl.uuid, hint)
        return self._keep(handle)

    def progress_bar(self) -> ViserControl:
        """Add a bar."""
        with self._place():
            return self._keep(self._server.gui.add_progress_bar(0.0))

    @contextmanager
    def group(self, label: str, opened: bool = True) -> Iterator[ViserControl]:
        """Add a group."""
        with self._place():
            handle = self._server.gui.add_folder(label, expand_by_default=opened)
        control = self._keep(handle)
        self._groups.append(handle)
        try:
            yield control
        finally:
            self._groups.remove(handle)

    def key(self, label: str, hint: str, hotkey: str, modifier: str | None, run: Callable[[], object]) -> ViserControl:
        """Add a command that a key calls."""
        held: Any = MODIFIERS[modifier]
        key: Any = hotkey
        handle = self._server.gui.add_command(label, description=hint, hotkey=key, modifier=held)
        handle.on_trigger(self._in_order(run))
        control = ViserControl(handle)
        self._made.append(control)
        return control

    def clear(self) -> None:
        """Remove all controls and keys."""
        made, self._made = self._made, []
        for control in reversed(made):
            control.remove()
        self._on_change(0)

    def _place(self) -> AbstractContextManager[Any]:
        """Return the context in which the next control is placed."""
        return self._groups[-1] if self._groups else self._container()

    def _bounded(self, handle: Any, bounds: Bounds, changed: Callable[[float], object]) -> ViserControl:
        """Set up an input of numbers, which takes no number beyond the bounds."""
        identity = handle._impl.uuid
        self._guard.bound(identity, bounds)
        return self._input(handle, changed, forget=lambda: self._guard.forget(identity))

    def _input(
        self, handle: Any, changed: Callable[[Any], object], kind: type[ViserControl] = ViserControl,
        forget: Callable[[], None] = lambda: None,
    ) -> ViserControl:  # fmt: skip
        """Set up an input, and post its new values; a stream of values never fills the queue."""

        async def post(event: viser.GuiEvent) -> None:
            if event.client_id is not None:  # The page sets values itself, too.
                self._queue.post_newest(handle._impl.uuid, changed, event.target.value)

        handle.on_update(post)
        return self._keep_control(kind(handle, forget))

    def _act(self, action: Callable[[str, str], object], message: dict[str, Any], client: int | None) -> None:
        self._queue.post(self._call_for, client, action, str(message.get("action", "")), str(message.get("value", "")))

    def _in_order(
        self, function: Callable[..., object], arguments: Callable[[Any], tuple[object, ...]] = lambda _: ()
    ) -> Callable[[Any], Coroutine[Any, Any, None]]:
        """Return a function for events of viser; it calls ``function`` with the arguments from the event.

        The function is asynchronous, because viser awaits such functions in the order of the messages, and runs others
        in many threads.
        """

        async def post(event: Any) -> None:
            self._post(event, function, *arguments(event))

        return post

    def _post(self, event: Any, function: Callable[..., object], *arguments: object) -> None:
        """Post a call for the event of a browser."""
        self._queue.post(self._call_for, event.client_id, function, *arguments)

    def _call_for(self, client: int | None, function: Callable[..., object], *arguments: object) -> None:
        """Call a function; its downloads go to the browser that asked for the call."""
        self._bridge.acting_client = client
        try:
            function(*arguments)
        finally:
            self._bridge.acting_client = None

    def _keep(self, handle: Any) -> ViserControl:
        return self._keep_control(ViserControl(handle))

    def _keep_control(self, control: ViserControl) -> ViserControl:
        self._made.append(control)
        if not self._groups:
            self._on_change(len(self._made))
        return control


def styled(figure: go.Figure) -> go.Figure:
    """Return a figure with small margins and letters, and a background that suits light and dark panels."""
    figure.update_xaxes(automargin=False)
    figure.update_yaxes(automargin=False)
    return figure.update_layout(
        margin={"l": 52, "r": 12, "t": 30, "b": 42}, font={"size": 11}, title_font_size=13, template="plotly_white",
        modebar={"orientation": "v", "remove": ["lasso", "select", "zoom", "pan", "zoomIn", "zoomOut", "autoScale"]},
    )  # fmt: skip
