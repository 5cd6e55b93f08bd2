# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Flags of the command line from declared settings (``stitchmesh.settings``).

A command holds a dataclass of settings as a field, and has a flag for each of them. The flag has the name of the
setting, or the name that the declaration gives. A setting that is true by default has the flag ``--no-NAME``. A setting
whose value is a tuple of any length may be given several times.
"""

from __future__ import annotations

from dataclasses import MISSING, fields
from typing import Annotated, Any, get_args, get_origin, get_type_hints

from tyro.conf import UseAppendAction, arg
from tyro.constructors import StructConstructorSpec, StructFieldSpec, StructTypeInfo

from stitchmesh.cli.words import DirectionWord, NumberOrPair, OneOrTwoSizes, Pair, PanelPair, panel_direction, parsed_by
from stitchmesh.errors import FileError, ParameterError
from stitchmesh.settings import SettingDeclaration, declared_setting, setting_named
from stitchmesh.shaping.marks import TimeMark
from stitchmesh.shaping.options import ShapingOptions
from stitchmesh.shaping.panels.options import PanelDirection

METAVARS = {int: "N", float: "X", str: "NAME"}
"""Placeholder of a value whose declaration has no form and no unit, by its type."""


def _read_marks(path: str) -> tuple[TimeMark, ...]:
    """Read the marks of a JSON file.

    Raises:
        FileError: the file cannot be read, or has a key or a value that no mark has.
    """
    from stitchmesh.io.checked import check_table, read_json

    try:
        return check_table({"marks": read_json(path)}, ShapingOptions).marks
    except ParameterError as error:
        raise FileError(f"{path}: {error}") from error


FORMS: dict[str, Any] = {
    "V,W": Pair,
    "AXIS|X,Y,Z": DirectionWord,
    "MU[,MU]": NumberOrPair,
    "K[,ANGLE]": NumberOrPair,
    "PANEL,PANEL": PanelPair,
    "CM [CM]": OneOrTwoSizes,
}
"""How one word becomes a value, by the form of a declaration; the words of all others follow from the type."""
TYPES: dict[Any, Any] = {
    PanelDirection: Annotated[PanelDirection, parsed_by(panel_direction, "PANEL=U,V")],
    tuple[TimeMark, ...]: Annotated[tuple[TimeMark, ...], parsed_by(_read_marks, "FILE")],
}
"""How one word becomes a value, by the type."""


def flag_of(kind: type[Any], name: str) -> object:
    """Return the annotation of an option of a command that is one setting of a dataclass, under the field's name."""
    return _entry(setting_named(kind, name), get_type_hints(kind)[name])


def settings_group(info: StructTypeInfo) -> StructConstructorSpec | None:
    """Return the flags of a dataclass of settings, as a rule for tyro; None for other types."""
    kind: Any = info.type
    if not hasattr(kind, "__dataclass_fields__") or not any(map(declared_setting, fields(kind))):
        return None
    hints, flags = get_type_hints(kind), []
    for part in fields(kind):
        default = part.default_factory() if part.default_factory is not MISSING else part.default
        if isinstance(info.default, kind):
            default = getattr(info.default, part.name)
        declared, hint = declared_setting(part), hints[part.name]
        if declared is None:
            flags.append(StructFieldSpec(part.name, hint, default))
        elif declared.flag is not None:
            named = arg(name=declared.flag) if declared.flag else arg()
            entry = _entry(declared, hint, negated=default is True)
            flag: Any = Annotated[_parsed(hint, declared), entry, named]
            flags.append(StructFieldSpec(part.name, flag, default))
    return StructConstructorSpec(instantiate=kind, fields=tuple(flags))


def _entry(declared: SettingDeclaration, hint: Any, *, negated: bool = False) -> object:
    """Return how an option stands in the help; ``negated`` for a flag that switches a setting off."""
    aliases = None if declared.former_flag is None else [declared.former_flag]
    if hint is bool:
        return arg(help=f"do not {declared.help}" if negated else declared.help, help_behavior_hint="", aliases=aliases)
    text = f"{declared.help} [{declared.unit}]" if declared.unit else declared.help
    hint_of_default = None if declared.unset is None else f"(default: {declared.unset})"
    return arg(metavar=_metavar(declared, hint), help=text, help_behavior_hint=hint_of_default, aliases=aliases)


def _metavar(declared: SettingDeclaration, hint: Any) -> str:
    kinds = [kind for kind in (hint, *get_args(hint)) if kind in METAVARS]
    return declared.form or declared.unit.upper() or (METAVARS[kinds[0]] if kinds else "NAME")


def _parsed(hint: Any, declared: SettingDeclaration) -> Any:
    """Return the type of an option, with the rule by which its words become a value."""
    if hint in TYPES:
        return TYPES[hint]
    if get_origin(hint) is tuple and Ellipsis in get_args(hint):
        inner = get_args(hint)[0]
        one = TYPES.get(inner) or FORMS.get(declared.form or "") or inner
        return UseAppendAction[tuple[one, ...]]  # type: ignore[valid-type]
    return FORMS.get(declared.form or "", hint)
