# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Keys of job files that have other names now: a job about a mesh has the keys of a recipe.

Files with the former keys keep working. The former keys stood in tables with the names of public functions.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from stitchmesh.errors import ParameterError
from stitchmesh.io.checked import unknown_key
from stitchmesh.jobs.sweep.axis import with_option

_SIZE = {"stitch_width": "stitch_width", "stitch_height": "stitches.course_height", "increase": "stitches.increase"}
_OF_ROWS = ("up", "multiple", "short_rows", "marks", "most_shaping", "shaping")
_OF_PHYSICS = ("gravity", "friction", "twist", "body", "body_unit", "body_up")
_OF_FINISH = ("bind_off", "cast_on", "longest_float")
_OF_YARN = ("yarn_radius", "drawn_radius", "mass_per_length")
FORMER_KEYS: dict[str, str] = {
    "turn_inside_out": "label.turn_inside_out", "make_spiral": "spiral", "apply_pattern": "patterns",
    "apply_edit": "edits", "relax_mesh": "mesh_relaxation", "apply_rest_lengths": "rest_lengths",
}  # fmt: skip
"""Present names of keys at the top of a file."""
FORMER_TABLES: dict[str, dict[str, str]] = {
    "label": {"borders": "label.start_borders", "seeds": "label.start_edges"},
    "tessellate": _SIZE | {"counts": "stitches.counts", "marked": "stitches.marked"},
    "auto_stitches": _SIZE | {name: f"rows.{name}" for name in _OF_ROWS},
    "generate_yarns": {name: name for name in _OF_YARN} | {name: f"finish.{name}" for name in _OF_FINISH},
    "relax_yarns": {
        "material": "material.name", "stiffness": "material.stiffness", "solver": "solver.method",
        "max_iterations": "solver.max_iterations", "checkpoint_every": "checkpoint_every",
        **{name: f"physics.{name}" for name in _OF_PHYSICS},
    },
    "swatch": {"checkpoint_every": "checkpoint_every"},
}  # fmt: skip
"""Present names of keys in tables; the first and the last one are also tables of present files."""
PRESENT_TABLES = ("label", "swatch")


def with_present_keys(table: Mapping[str, Any]) -> dict[str, Any]:
    """Return the table of a job file in which former keys have their present names.

    Raises:
        ParameterError: as for ``renamed_keys``.
    """
    present = renamed_keys(table)
    return with_option(present, ("rows", "auto"), True) if "auto_stitches" in table else present


def renamed_keys(table: Mapping[str, Any]) -> dict[str, Any]:
    """Return a table of options in which former keys have their present names, with any values.

    Raises:
        ParameterError: a former table has an unknown key, or a setting is given under both names.
    """
    former = {key: value for key, value in table.items() if key in FORMER_KEYS or key in FORMER_TABLES}
    present: dict[str, Any] = {key: value for key, value in table.items() if key not in former}
    present |= {name: {} for name in PRESENT_TABLES if name in former}
    moved = [(key, FORMER_KEYS[key], value) for key, value in former.items() if key in FORMER_KEYS]
    for name, keys in FORMER_TABLES.items():
        inner = former.get(name, {})
        if not isinstance(inner, Mapping):
            raise ParameterError(f"{name} is {inner!r}; expected a table")
        for key, value in inner.items():
            if key in keys:
                moved.append((f"{name}.{key}", keys[key], value))
            elif name in PRESENT_TABLES:
                present = with_option(present, (name, key), value)
            else:
                raise ParameterError(unknown_key(name, key, list(keys)))
    for old, new, value in moved:
        path = tuple(new.split("."))
        if _holds(present, path):
            raise ParameterError(f"{old}: is the former name of {new}, which is given too; leave one of the two out")
        present = with_option(present, path, value)
    return present


def _holds(table: Mapping[str, Any], path: tuple[str, ...]) -> bool:
    first, *rest = path
    if first not in table:
        return False
    inner = table[first]
    return not rest or (isinstance(inner, Mapping) and _holds(inner, tuple(rest)))
