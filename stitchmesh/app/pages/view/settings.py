# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What the user has chosen on the page, as the project keeps it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from stitchmesh.app.pages.view.viewed import Thing
from stitchmesh.mesh import StitchMesh
from stitchmesh.mixed.drape import Draped
from stitchmesh.yarn import YarnSet

YARN_COLOURS = {
    "Colours of the yarns": "yarn", "Rows": "row", "Stitch types": "stitch", "Strain of the yarn": "strain",
    "Stretch of the stitches": "stretch", "Contact force": "contact", "Distance between yarns": "distance",
    "Distance from a body": "body-distance", "One colour": "",
}  # fmt: skip
"""Colours of yarns in the words of the page, and the words of ``colour_yarns``."""
FACE_COLOURS = {
    "Stitch types": "stitch", "Rows": "row", "Colours of the yarns": "yarn", "Stretch of the stitches": "stretch",
    "One colour": "",
}  # fmt: skip
"""Colours of faces in the words of the page, and the words of ``colour_faces``."""
DRAPED_COLOURS = {
    "Colours of the yarns": "yarn", "Alpha": "alpha", "Tension of the cloth": "cloth-tension",
    "Tension of the yarns": "yarn-tension", "One colour": "",
}  # fmt: skip
"""Colours of a run of mixed yarns and triangles in the words of the page, and the words of ``DrapedView``."""
ONE_COLOUR = "#c9b89a"
"""The one colour at first."""
DEFAULTS = {
    "show": "", "path": "", "yarn colour": "Rows", "face colour": "Stitch types",
    "run colour": "Colours of the yarns", "one colour": ONE_COLOUR,
}  # fmt: skip
"""Settings of the page at first: what is shown, the path of what was opened, and the colours."""


def checked_settings(settings: Mapping[str, Any]) -> dict[str, str]:
    """Return settings in which colours that the page does not know are those at first."""
    known = {"yarn colour": YARN_COLOURS, "face colour": FACE_COLOURS, "run colour": DRAPED_COLOURS}
    return {
        name: value if isinstance(value, str) and value in known.get(name, (value,)) else DEFAULTS[name]
        for name, value in settings.items()
        if name in DEFAULTS
    }


def colour_word(settings: Mapping[str, str], thing: Thing | None) -> str:
    """Return what decides the colours of a thing, as a word of the library, or one colour."""
    if isinstance(thing, YarnSet):
        return YARN_COLOURS[settings["yarn colour"]] or settings["one colour"]
    if isinstance(thing, Draped):
        return DRAPED_COLOURS[settings["run colour"]] or settings["one colour"]
    if isinstance(thing, StitchMesh):
        return FACE_COLOURS[settings["face colour"]] or settings["one colour"]
    return settings["one colour"]
