# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How a yarn looks, as data: its plies and their twist, its fibres and hair, its colours, and its unevenness.

All lengths of a look are over the apparent diameter of the yarn, so that a look fits yarns of any thickness. The lay is
the length in which the plies turn once: fibres on the outside of a single yarn lean by atan(pi / lay), which is 35
degrees for a lay of 4.5. The length of all hair over the length of the yarn is ``hair_length`` times ``hair_density``;
instruments of spinning mills state the same number as the hairiness H.

``PRESETS`` holds the looks by name. Numbers that their sources do not measure are chosen by eye.
"""

from __future__ import annotations

import difflib
import math
from dataclasses import dataclass, fields
from typing import Any, Literal

from stitchmesh.errors import ParameterError
from stitchmesh.mesh.palette import parse_colour

AS_PRESET: Any = None
"""Default of a field of a look: the value of the preset."""
DEFAULT_LOOK = "wool"
"""The look of yarns of which nothing else is known."""
MOST_PLIES, MOST_FIBRES, MOST_HAIRS = 8, 5000, 50.0
"""Largest number of plies, of fibres in a cross-section, and of hairs in a length of one diameter."""
LONGEST = 1e4
"""Largest length over the apparent diameter."""
OWN = "own"
"""Word for the colour that the yarn has without its look."""


@dataclass(frozen=True)
class YarnLook:
    """The look of a yarn: a preset, of which any field can be changed, for example ``YarnLook("wool", plies=4)``.

    Raises:
        ParameterError: there is no preset of that name, a number is out of bounds, or a text is no colour.
    """

    name: str = DEFAULT_LOOK
    """Name of the preset; fields that are not given have its values."""
    plies: int = AS_PRESET
    """Number of strands that are twisted about one another."""
    twist: Literal["S", "Z"] = AS_PRESET
    """Direction of the twist: Z rises to the right, as in most knitting yarns, and S to the left."""
    lay: float = AS_PRESET
    """Length in which the plies turn once."""
    body: float = AS_PRESET
    """Diameter of the twisted strands together, at most 1; around a smaller body only hair fills the yarn."""
    fullness: float = AS_PRESET
    """Diameter of a ply over that of circles that touch one another in the body: soft plies are pressed together."""
    fibres: int = AS_PRESET
    """Number of fibres in a cross-section; 0 for a smooth surface."""
    migration: float = AS_PRESET
    """How far a fibre wanders between the middle and the surface of its ply, from 0 to 1."""
    hair_length: float = AS_PRESET
    """Mean length of fibres that stand off."""
    hair_density: float = AS_PRESET
    """Number of fibres that stand off in a length of one diameter."""
    marl: tuple[str, ...] = AS_PRESET
    """Colours of the plies in turn, each ``own`` or a colour (``parse_colour``); all their own without any."""
    heather: float = AS_PRESET
    """Difference of shade between fibres: the standard deviation of the logarithm of their brightness, up to 1."""
    variegation: tuple[str, ...] = AS_PRESET
    """Colours along the yarn, each ``own`` or a colour, which follow one another again and again."""
    colour_length: float = AS_PRESET
    """Length in which the colours of ``variegation`` come once."""
    unevenness: float = AS_PRESET
    """Standard deviation of the thickness along the yarn over its mean, up to 0.3."""
    neps: float = AS_PRESET
    """Number of flecks of other fibres in a length of one diameter, up to 1."""
    nep_colours: tuple[str, ...] = AS_PRESET
    """Colours of the flecks."""
    sheen: float = AS_PRESET
    """How much the yarn shines, from 0 (matt) to 1."""
    source: str = AS_PRESET
    """What the values rest on."""

    def __post_init__(self) -> None:
        if self.name not in PRESETS:
            near = difflib.get_close_matches(str(self.name).lower(), PRESETS, n=1, cutoff=0.5)
            raise ParameterError(f"look: got {self.name!r}; expected {near[0] if near else ', '.join(PRESETS)}")
        preset = PLAIN | PRESETS[self.name]
        for part in fields(self)[1:]:
            if getattr(self, part.name) is AS_PRESET:
                object.__setattr__(self, part.name, preset[part.name])
        for name in ("marl", "variegation", "nep_colours"):
            object.__setattr__(self, name, tuple(getattr(self, name)))
        self._check()

    def _check(self) -> None:
        if self.twist not in ("S", "Z"):
            raise ParameterError(f"look: twist is {self.twist!r}; expected S or Z")
        for name, (least, most) in BOUNDS.items():
            value = getattr(self, name)
            whole = name in ("plies", "fibres")
            if not isinstance(value, int if whole else int | float) or not least <= value <= most:
                found = f"look: {name} is {value}; expected {'a whole number' if whole else 'a number'}"
                raise ParameterError(f"{found} from {least:g} to {most:g}")
        for name in ("marl", "variegation", "nep_colours"):
            for text in getattr(self, name):
                if text != OWN:
                    try:
                        parse_colour(text)
                    except ParameterError as error:
                        raise ParameterError(f"look: {name}: {error}; or {OWN}") from None
        if self.neps > 0.0 and not self.nep_colours:
            raise ParameterError("look: got neps without nep_colours; give a colour for them, or neps = 0")

    @property
    def lean(self) -> float:
        """Angle between the outside of a ply and the axis of the yarn [degrees]."""
        return math.degrees(math.atan(math.pi * self.body / self.lay))


BOUNDS: dict[str, tuple[float, float]] = {
    "plies": (1, MOST_PLIES), "lay": (1.0, LONGEST), "body": (0.1, 1.0), "fullness": (1.0, 1.5),
    "fibres": (0, MOST_FIBRES), "migration": (0.0, 1.0), "hair_length": (0.0, 50.0), "hair_density": (0.0, MOST_HAIRS),
    "heather": (0.0, 1.0), "colour_length": (1.0, LONGEST), "unevenness": (0.0, 0.3), "neps": (0.0, 1.0),
    "sheen": (0.0, 1.0),
}  # fmt: skip
"""Least and most of each number of a look."""

PLAIN: dict[str, Any] = {
    "plies": 1, "twist": "Z", "lay": 4.5, "body": 1.0, "fullness": 1.12, "fibres": 0, "migration": 0.0,
    "hair_length": 0.0, "hair_density": 0.0, "marl": (), "heather": 0.0, "variegation": (), "colour_length": 150.0,
    "unevenness": 0.0, "neps": 0.0, "nep_colours": (), "sheen": 0.1, "source": "",
}  # fmt: skip
"""Values of a smooth tube, which hold where a preset states no others."""

PRESETS: dict[str, dict[str, Any]] = {
    "wool": {
        "plies": 3, "fibres": 700, "migration": 0.5, "hair_length": 1.0, "hair_density": 5.0, "heather": 0.12,
        "unevenness": 0.07,
        "source": "fibres of 25 um in a yarn of 440 tex (the yarn dk) make 690 in a cross-section; a hairiness of 5 "
        "and a mass that varies by 14 %, which is a thickness that varies by 7 %, are usual for worsted spinning; lay, "
        "shade and sheen by eye",
    },
    "cotton": {
        "plies": 4, "lay": 3.4, "fullness": 1.05, "fibres": 1200, "migration": 0.3, "hair_length": 0.4,
        "hair_density": 4.0, "heather": 0.05, "unevenness": 0.05, "sheen": 0.25,
        "source": "fibres of 12 um (1.7 dtex) in a yarn of 200 tex make 1,200; plied and singed knitting cotton: firm "
        "twist, a hairiness below 2 against 4 to 8 of ring-spun singles, and a thickness that four plies make more "
        "even; lay, shade and sheen by eye",
    },
    "mohair": {
        "plies": 2, "lay": 5.0, "body": 0.55, "fibres": 250, "migration": 0.4, "hair_length": 3.0,
        "hair_density": 7.0, "heather": 0.15, "unevenness": 0.10, "sheen": 0.45,
        "source": "kid mohair of 25 um on a binder, brushed: a thin body in a halo of long fibres; all but the "
        "diameter of the fibres by eye",
    },
    "silk": {
        "plies": 2, "lay": 4.0, "fullness": 1.18, "fibres": 900, "migration": 0.1, "hair_length": 0.3,
        "hair_density": 0.3, "heather": 0.03, "unevenness": 0.02, "sheen": 0.9,
        "source": "reeled filaments of 13 um without ends that stand off, which lie side by side and shine along their "
        "length; numbers by eye",
    },
    "acrylic": {
        "plies": 4, "lay": 5.5, "fullness": 1.2, "fibres": 450, "migration": 0.4, "hair_length": 0.7,
        "hair_density": 4.0, "heather": 0.04, "unevenness": 0.03, "sheen": 0.4,
        "source": "bulked fibres of 3.3 dtex in a yarn of 150 tex make 450; soft twist, an even thickness and a slight "
        "shine; lay, hair, shade and sheen by eye",
    },
    "tweed": {
        "plies": 2, "lay": 5.5, "fibres": 700, "migration": 0.6, "hair_length": 0.9, "hair_density": 5.0,
        "heather": 0.28, "unevenness": 0.13, "neps": 0.16, "nep_colours": ("cream", "mustard", "rust", "charcoal"),
        "source": "woollen spinning of fibres that lie crosswise: a mass that varies by 20 to 30 %, and flecks of "
        "dyed wool every six diameters; twist, shade and flecks by eye",
    },
    "monofilament": {
        "sheen": 1.0,
        "source": "one round and smooth filament, as in the yarns nylon-monofilament and polyester-monofilament",
    },
}  # fmt: skip
"""Values of each look that differ from ``PLAIN``, by its name."""


def look_names() -> tuple[str, ...]:
    """Return the names of the looks."""
    return tuple(PRESETS)
