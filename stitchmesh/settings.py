# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Settings: what a user may choose, declared once, as a field of a frozen dataclass.

    course_height: float | None = setting(None, "course spacing", unit="cm", unset="0.77 stitch widths")

The field holds the type, the default, the unit, the bounds and the help text. Recipes, jobs and sweeps use the names
of such fields as their keys. ``stitchmesh.cli.setting_flags`` makes the flags of the command line from them, and a test
compares the tables of the documentation with them. ``check_settings`` checks the bounds of all settings of a dataclass.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import Field, dataclass, field, fields, is_dataclass
from typing import Any

from stitchmesh.errors import ParameterError, check_positive

SETTING = "setting"
"""Key of the declaration in the metadata of a field."""


@dataclass(frozen=True, kw_only=True)
class SettingDeclaration:
    """The declaration of one setting, apart from its name, its type and its default."""

    help: str
    """What the setting does, without a capital letter and without a full stop."""
    unit: str = ""
    """Unit of a number, such as ``cm``."""
    unset: str | None = None
    """What holds where the setting is None or empty."""
    example: object = None
    """A value for the line of a new job file, where the default is None."""
    positive: bool = False
    """Whether the value is a positive number (``check_positive``)."""
    least: float | None = None
    """Smallest value."""
    most: float | None = None
    """Largest value."""
    expected: str = ""
    """What the bounds allow, in words, for the message."""
    choices: tuple[str, ...] = ()
    """The texts that the value may be."""
    flag: str | None = ""
    """Name of the option, if it differs from the name of the field; None for a setting without an option of its own."""
    former_flag: str | None = None
    """Former name of the option, which is still accepted."""
    form: str | None = None
    """Placeholder of the value in the help; it also says how the words of the option become a value."""

    def check(self, name: str, value: Any) -> None:
        """Check a value.

        Args:
            name: name of the setting, for the message.
            value: the value; None and empty values are always accepted.

        Raises:
            ParameterError: the value is out of bounds, or is none of the choices.
        """
        if value is None:
            return
        if self.positive:
            check_positive(name, value, self.unit)
        if self.choices and value not in self.choices:
            raise ParameterError(f"{name}: got {value!r}; expected one of {', '.join(self.choices)}")
        bounded = self.least is not None or self.most is not None
        least = -math.inf if self.least is None else self.least
        most = math.inf if self.most is None else self.most
        if bounded and not (least <= value <= most and abs(value) < math.inf):
            expected = self.expected or f"{least:g} to {most:g}"
            unit = self.unit and f" {self.unit}"
            raise ParameterError(f"{name}: got {value}{unit}; expected {expected}")


def setting(default: Any, help: str, **declared: Any) -> Any:
    """Return a field of a frozen dataclass that is a setting.

    Args:
        default: default of the field.
        help: what the setting does.
        **declared: further fields of ``SettingDeclaration``.
    """
    return field(default=default, metadata={SETTING: SettingDeclaration(help=help, **declared)})


def declared_in(kind: type[Any], name: str) -> Any:
    """Return a field with the declaration and the default of a setting of another dataclass."""
    part = kind.__dataclass_fields__[name]
    return field(default=part.default, metadata=part.metadata)


def declared_setting(part: Field[Any]) -> SettingDeclaration | None:
    """Return the declaration of a field; None if the field is no setting."""
    return part.metadata.get(SETTING)


def setting_named(kind: type[Any], name: str) -> SettingDeclaration:
    """Return the declaration of one setting of a dataclass."""
    declared: SettingDeclaration = kind.__dataclass_fields__[name].metadata[SETTING]
    return declared


POSITIVE: dict[str, Any] = {"least": 1e-300, "most": 1e300, "expected": "a positive number of at most 1e+300"}
"""Bounds of a setting that is any positive number; whole numbers in a file may have any number of digits."""
NOT_NEGATIVE: dict[str, Any] = {"least": 0.0, "expected": "a number of at least 0"}
"""Bounds of a setting that is a number of at least 0."""


def settings_of(value: Any) -> Iterator[tuple[str, Field[Any], Any]]:
    """Yield the path of keys, the field and the value of each setting of a dataclass and of the sections in it.

    Args:
        value: an instance, whose sections are instances too.
    """
    for part in fields(value):
        found = getattr(value, part.name)
        if declared_setting(part) is not None:
            yield part.name, part, found
        elif is_dataclass(found):
            for path, inner, inner_found in settings_of(found):
                yield f"{part.name}.{path}", inner, inner_found


def changed_settings(value: Any) -> list[str]:
    """Return the paths of the settings whose values are not the defaults."""
    return [path for path, part, found in settings_of(value) if found != part.default]


def setting_comments(value: Any) -> dict[str, str]:
    """Return the comment of each setting, by its path of keys, for a file that is written for users."""
    comments = {}
    for path, part, _found in settings_of(value):
        declared: SettingDeclaration = part.metadata[SETTING]
        comments[path] = f"{declared.help} [{declared.unit}]" if declared.unit else declared.help
    return comments


def check_settings(value: Any, table: str = "") -> None:
    """Check the bounds of all settings of a dataclass; ``__post_init__`` calls it.

    Args:
        value: the dataclass.
        table: name of the table of the file that holds the settings, for the message; with ``""``, a setting is named
            in words.

    Raises:
        ParameterError: a value is out of bounds, or is none of the choices.
    """
    for part in fields(value):
        declared = declared_setting(part)
        if declared is not None:
            name = f"{table}.{part.name}" if table else part.name.replace("_", " ")
            declared.check(name, getattr(value, part.name))
