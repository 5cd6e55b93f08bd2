# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The controls of the fields of a value, such as the settings of a page or a part of a scene.

Each field is declared once, as data. A panel makes a control for each field, shows the values of the fields, and hands
over the new value that the user wants. The value also decides which controls are shown.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, TypeAlias

from stitchmesh.app.controls.controls import Control, Controls
from stitchmesh.errors import StitchMeshError
from stitchmesh.settings import setting_named

OTHER = "another"
"""Word for a value that has no word in a choice, because it comes from elsewhere."""
Words: TypeAlias = Mapping[str, object]
"""Values of a choice, by the words that the user sees."""


@dataclass(frozen=True, eq=False)
class TickBox:
    """A box to tick beside a number; the number is hidden while the field has none."""

    label: str
    hint: str
    usual: Callable[[Any], float] = lambda value: 1.0
    """Returns the first number, from the value that holds the field."""
    ticked_without: bool = True
    """Whether the box is ticked while the field has no number, as a box for an automatic value is."""


@dataclass(frozen=True, eq=False)
class Number:
    """A number; it is whole if its step is whole."""

    least: float
    most: float
    step: float
    slider: bool = False
    """Whether the control is a slider."""
    without: Any = ...
    """The field's value without a number, such as None; by default the field always has a number."""
    box: TickBox | None = None
    """Decides whether the field has a number. Without a box, the smallest number stands for none."""

    def given(self, number: float) -> Any:
        """Return the value of the field after the user has set a number."""
        if self.without is not ... and self.box is None and number == self.least:
            return self.without
        return int(number) if isinstance(self.step, int) else float(number)

    def has_number(self, held: Any) -> bool:
        """Return whether this value of a field is a number."""
        return held is not None and (self.without is ... or held != self.without)


def always(value: Any) -> bool:
    """Return that the control of a field is shown for every value."""
    return True


@dataclass(frozen=True, eq=False)
class Field:
    """A field of a value and its control."""

    name: str
    """Name of the field; after a dot, the name of a field inside that field."""
    label: str
    hint: str
    form: Number | Words | Callable[[Any], Words] | None = None
    """A number, the words of a choice, or a function that returns the words for a value; None for a box to tick."""
    shown: Callable[[Any], bool] = always
    """Whether the control is shown for a value."""


def setting_field(
    kind: type[Any], name: str, label: str, form: Number | Words | Callable[[Any], Words] | None = None, *,
    at: str = "", shown: Callable[[Any], bool] = always,
) -> Field:  # fmt: skip
    """Return the field of a declared setting: the hint, the unit and the choices are those of the declaration.

    Args:
        kind: dataclass that declares the setting (``stitchmesh.settings``).
        name: name of the setting.
        label: what the page calls the setting, without the unit.
        form: as for ``Field``; by default the declared choices, or a box to tick. The bounds of a number may be
            narrower than the declared bounds: a slider covers the useful values.
        at: name of the field of the page's value, if it differs from the name of the setting.
        shown: as for ``Field``.
    """
    declared = setting_named(kind, name)
    hint = f"{declared.help[0].upper()}{declared.help[1:]}."
    if isinstance(form, Number):
        for bound in (form.least, form.most):
            declared.check(name, form.given(bound))
        if form.without is None and form.box is None:
            hint += f" The number {form.least:g} stands for none."
    if form is None and declared.choices:
        form = same_words(declared.choices)
    unit = f" [{declared.unit}]" if declared.unit else ""
    return Field(at or name, label + unit, hint, form, shown)


def same_words(names: Sequence[str]) -> dict[str, object]:
    """Return the words of a choice whose values are the words themselves."""
    return {name: name for name in names}


def field_of(value: Any, name: str) -> Any:
    """Return a field of a value."""
    for part in name.split("."):
        value = getattr(value, part)
    return value


def with_field(value: Any, name: str, held: Any) -> Any:
    """Return a value with another field."""
    first, _, rest = name.partition(".")
    return replace(value, **{first: with_field(getattr(value, first), rest, held) if rest else held})


class FieldPanel:
    """The controls of some fields, one below another; if the panel has a name, they have a group of their own.

    A refused change leaves the controls as they were. Without a value, the panel shows nothing.
    """

    def __init__(
        self, controls: Controls, fields: Sequence[Field], value: Callable[[], Any],
        changed: Callable[[Any, str], object], *, group: str = "", opened: bool = True,
    ) -> None:  # fmt: skip
        """Make the controls.

        Args:
            controls: the place of the controls.
            fields: the fields.
            value: returns the present value; None if there is none.
            changed: called with the value that the user wants, and the name of the changed field.
            group: name of the group; empty for none.
            opened: whether the group is open at first.
        """
        self._controls, self._value, self._changed = controls, value, changed
        self._made: dict[Field, Control] = {}
        self._boxes: dict[Field, Control] = {}
        self._group: Control | None = None
        place: AbstractContextManager[Control | None] = controls.group(group, opened) if group else nullcontext()
        with place as self._group:
            for field in fields:
                self._make(field, value())
        self.show()

    def show(self) -> None:
        """Show the present value."""
        value = self._value()
        shown = [] if value is None else [field for field in self._made if field.shown(value)]
        if self._group is not None:
            self._group.visible = bool(shown)
        for field, control in self._made.items():
            held = field_of(value, field.name) if field in shown else None
            # The controls get one value only, so that no frame of a page shows another.
            control.visible = field in shown and not _is_left_out(field.form, held)
            if field in self._boxes:
                self._boxes[field].visible = field in shown
            if field in shown:
                self._show_field(field, value, held)

    def set_disabled(self, disabled: bool) -> None:
        """Enable or disable the input of all controls."""
        for control in (*self._made.values(), *self._boxes.values()):
            control.disabled = disabled

    def _make(self, field: Field, value: Any) -> None:
        form = field.form
        held = None if value is None else field_of(value, field.name)
        take = partial(self._take, field)
        if form is None:
            self._made[field] = self._controls.toggle(field.label, field.hint, bool(held), take)
        elif isinstance(form, Number):
            self._make_number(field, form, value, held)
        else:
            words = _words(form, value, held)
            word = _word(words, held)
            self._made[field] = self._controls.choice(field.label, field.hint, tuple(words), word, take)

    def _make_number(self, field: Field, form: Number, value: Any, held: Any) -> None:
        """Make the control of a number, and the box that decides whether the field has a number."""
        box = form.box
        if box is not None:
            ticked = form.has_number(held) != box.ticked_without
            self._boxes[field] = self._controls.toggle(box.label, box.hint, ticked, partial(self._tick, field, box))
        number = held if value is not None and form.has_number(held) else form.least
        if box is not None and value is not None and not form.has_number(held):
            number = box.usual(value)
        make = self._controls.slider if form.slider else self._controls.number
        self._made[field] = make(
            field.label, field.hint, min(max(number, form.least), form.most), partial(self._take, field),
            least=form.least, most=form.most, step=form.step,
        )  # fmt: skip

    def _show_field(self, field: Field, value: Any, held: Any) -> None:
        control, form = self._made[field], field.form
        if form is None:
            control.value = bool(held)
        elif isinstance(form, Number):
            if field in self._boxes and form.box is not None:
                self._boxes[field].value = form.has_number(held) != form.box.ticked_without
            if form.has_number(held):
                control.value = held
            elif form.box is None:
                control.value = form.least
        else:
            words = _words(form, value, held)
            if tuple(control.options) != tuple(words):
                control.options = tuple(words)
            control.value = _word(words, held)

    def _tick(self, field: Field, box: TickBox, ticked: bool) -> None:
        """Give the field a number, or none."""
        form = field.form
        assert isinstance(form, Number)
        held = form.without if ticked == box.ticked_without else form.given(box.usual(self._value()))
        self._change(field, held)

    def _take(self, field: Field, given: Any) -> None:
        """Take the value that the user has set."""
        form, value = field.form, self._value()
        if isinstance(form, Number):
            given = form.given(given)
        elif form is not None:
            given = _words(form, value, field_of(value, field.name))[given]
        self._change(field, given)

    def _change(self, field: Field, held: Any) -> None:
        value = self._value()
        if field_of(value, field.name) == held:
            return
        try:
            self._changed(with_field(value, field.name, held), field.name)
        except StitchMeshError:
            self.show()
            raise
        if self._value() is not value:  # A worker thread may still be making the wanted value.
            self.show()


def _is_left_out(form: object, held: Any) -> bool:
    """Return whether a number is hidden, because its box says that there is none."""
    return isinstance(form, Number) and form.box is not None and not form.has_number(held)


def _words(form: Words | Callable[[Any], Words], value: Any, held: Any) -> Words:
    """Return the words of a choice, and one more word if the value has none."""
    if value is None:
        return {OTHER: None} if callable(form) else form
    words = form(value) if callable(form) else form
    if held in words.values():
        return words
    return {**words, held if isinstance(held, str) else OTHER: held}


def _word(words: Words, held: Any) -> str:
    """Return the word of a value, or the first word if there is none."""
    return next((word for word, value in words.items() if value == held), next(iter(words)))
