# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The yarns of a scene: a weave or a knit, its densities, and the material of its yarns."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import ParameterError
from stitchmesh.hand_knitting.words import stitch_name
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.layout.crossing_yarns import CrossingYarns
from stitchmesh.mixed.layout.knit import lay_knit
from stitchmesh.mixed.layout.weave import lay_weave
from stitchmesh.settings import POSITIVE, check_settings, setting

Matrix = NDArray[np.int64]
STITCHES = "stitches"
"""Name of the knit whose loops are the stitches of the cloth."""
DEFAULT_DENSITY = 5.0
"""Default number of yarns, wales or courses per cm."""


@dataclass(frozen=True, kw_only=True)
class YarnsSection:
    """Yarns that are laid out on the panels: ``weave`` or ``knit``.

    Raises:
        ParameterError: both or neither are given, or a density is not positive.
    """

    weave: str | tuple[str, ...] | None = setting(
        None, "weave: plain, basket-NxN, twill-AxB, a name or a file of the library, or rows from the top such as "
        '["10", "01"], with 1 where the weft lies above', unset="none",
    )  # fmt: skip
    model: Literal["crossings", "splines"] = setting(
        "crossings", "how yarns are simulated: crossings (nodes where yarns cross), or splines (B-splines in contact, "
        'whose loops stand out of the cloth; for static scenes with knit = "stitches")',
    )  # fmt: skip
    knit: str | tuple[str, ...] | None = setting(
        None, 'knit: name or file of a pattern of knit and purl stitches, rows from the top such as ["kp"], or '
        "stitches for the stitches of the cloth", unset="none",
    )  # fmt: skip
    divisions: int = setting(1, "for stitches: number of loops along each side of a stitch of the cloth", **POSITIVE)
    ends: float = setting(DEFAULT_DENSITY, "warps for each cm", **POSITIVE)
    picks: float = setting(DEFAULT_DENSITY, "wefts for each cm", **POSITIVE)
    wales: float = setting(DEFAULT_DENSITY, "wales for each cm", **POSITIVE)
    courses: float = setting(DEFAULT_DENSITY, "courses for each cm", **POSITIVE)
    density: float = setting(
        1.0, "number of finer yarns in the place of each yarn, so that the cloth stays as heavy and as stiff; not for "
        "stitches, which have divisions", **POSITIVE,
    )  # fmt: skip
    loop_length: float | None = setting(
        None, "for splines: length of yarn in each plain stitch", unit="cm", unset="as the loops are drawn", **POSITIVE
    )
    material: str | None = setting(
        None, "material of the yarns, in material_file or among the named materials", unset="gong-1"
    )
    warp_material: str | None = setting(None, "material of the warps", unset="that of the wefts")
    material_file: str | None = setting(None, "file of materials (.toml)", unset="the named materials")
    radius: float | None = setting(
        None, "radius of the yarns", unit="cm", unset="that of the material, or an eighth of a stitch for splines",
        **POSITIVE,
    )  # fmt: skip

    def __post_init__(self) -> None:
        if (self.weave is None) == (self.knit is None):
            found = "neither" if self.weave is None else "both"
            raise ParameterError(f"yarns: got {found} of weave and knit; expected one of them")
        self._check_model()
        check_settings(self, "yarns")

    def _check_model(self) -> None:
        """Check that the keys fit the yarn model."""
        if self.model == "crossings":
            if self.loop_length is not None:
                raise ParameterError("yarns.loop_length: got one with crossings; expected model = 'splines' beside it")
            return
        if self.knit != STITCHES:
            raise ParameterError("yarns.model: got 'splines' without stitches; expected knit = 'stitches' beside it")
        for name in ("material_file", "warp_material"):
            if getattr(self, name) is not None:
                raise ParameterError(f"yarns.{name}: got one with B-splines; expected the name of a material alone")
        if self.divisions != 1:
            raise ParameterError(f"yarns.divisions: got {self.divisions} with B-splines; expected 1")

    def crossings_on(self, cloth: Cloth) -> float:
        """Return the approximate number of crossings of the yarns on a cloth; each loop of a knit has four."""
        if self.weave is not None:
            return float(cloth.rest_area.sum()) * self.ends * self.picks * self.density**2
        return 4.0 * float(cloth.rest_area.sum()) * self.wales * self.courses * self.density**2

    def layout(self, cloth: Cloth) -> CrossingYarns:
        """Lay the yarns out on a cloth.

        Raises:
            ParameterError: the weave or the pattern is unknown, or no panel holds a crossing.
            PatternError: a file does not describe a pattern.
        """
        n = self.density
        if self.weave is not None:
            return lay_weave(cloth, weave_matrix(self.weave), ends=n * self.ends, picks=n * self.picks)
        assert self.knit is not None  # the constructor has checked it
        chart = knit_chart(self.knit)
        return lay_knit(cloth, chart, wale_spacing=1.0 / (n * self.wales), course_spacing=1.0 / (n * self.courses))


def weave_matrix(weave: str | tuple[str, ...]) -> Matrix:
    """Return the matrix of a weave: 1 where the weft of a row passes over the warp of a column.

    Names: ``plain``, ``basket-NxN`` (groups of N yarns), ``twill-AxB`` (over A and under B, one yarn further in each
    row), and names in the library of weaves, such as ``satin-2x3``.

    Raises:
        ParameterError: the name is unknown, rows are of different lengths or contain other characters, or the weave has
            several layers or yarns of different sizes.
        FileError: a file cannot be read.
        PatternError: a file does not describe a weave.
    """
    if not isinstance(weave, str):
        return _rows("yarns.weave", weave, "01")
    found = re.fullmatch(r"(basket|twill)-([1-9])x([1-9])", "basket-1x1" if weave == "plain" else weave)
    if found is None:
        return _written_weave(weave)
    kind, over, repeat = found[1], int(found[2]), int(found[2]) + int(found[3])
    i, j = np.arange(repeat)[:, None], np.arange(repeat)[None, :]
    if kind == "twill":
        return np.asarray((j - i) % repeat < over, dtype=np.int64)
    if repeat != 2 * over:
        raise ParameterError(f"yarns.weave: got {weave!r}; expected two equal numbers, such as 'basket-2x2'")
    return np.asarray((i // over + j // over) % 2 == 0, dtype=np.int64)


def _written_weave(name: str) -> Matrix:
    """The matrix of a weave of the library, or of a file."""
    from stitchmesh.periodic.weave.library import read_weave
    from stitchmesh.periodic.weave.weave import Thread

    weave = read_weave(name)
    if weave.layer_count > 1:
        found = f"{name!r} has {weave.layer_count} layers"
        raise ParameterError(f"yarns.weave: {found}; expected one, in which two yarns cross at each crossing")
    if any(replace(thread, colour=0) != Thread() for thread in (*weave.wefts, *weave.warps)):
        raise ParameterError(f"yarns.weave: {name!r} has yarns of different sizes; expected equal ones")
    return np.array(weave.matrix, dtype=np.int64)


def knit_chart(knit: str | tuple[str, ...]) -> Matrix:
    """Return the chart of a knit: 1 for a knit stitch and 0 for a purl stitch, the last row knitted first.

    Raises:
        ParameterError: the pattern is unknown or has other stitches, or rows are of different lengths.
        FileError: a file cannot be read.
        PatternError: a file does not describe a pattern.
    """
    if not isinstance(knit, str):
        return _rows("yarns.knit", tuple(row.lower() for row in knit), "pk")
    from stitchmesh.patterns import read_pattern
    from stitchmesh.patterns.pattern import Loop

    pattern = read_pattern(knit)
    rows = [[cell.stitch for cell in row.sections[1]] for row in reversed(pattern.rows)]
    found = {stitch for row in rows for stitch in row} - {Stitch.KNIT, Stitch.PURL}
    if found:
        name = sorted(map(stitch_name, found))[0]
        raise ParameterError(f"yarns.knit: {knit!r} has {name} stitches; expected knit and purl stitches alone")
    if any(loop != Loop() for row in pattern.rows for loop in row.loops):
        raise ParameterError(f"yarns.knit: {knit!r} has cables or twists; expected knit and purl stitches alone")
    if len({len(row) for row in rows}) != 1:
        raise ParameterError(f"yarns.knit: {knit!r} has rows of different lengths; expected equal ones")
    return np.array([[int(stitch == Stitch.KNIT) for stitch in row] for row in rows])


def _rows(name: str, rows: tuple[str, ...], letters: str) -> Matrix:
    """The matrix of rows of two letters; the second letter stands for 1."""
    wrong = [row for row in rows if not row or set(row) - set(letters)]
    if wrong or not rows:
        found = repr(wrong[0]) if wrong else "no row"
        raise ParameterError(f"{name}: got {found}; expected rows of {letters[0]} and {letters[1]}")
    if len({len(row) for row in rows}) > 1:
        raise ParameterError(f"{name}: got rows of {len(rows[0])} and other numbers of letters; expected equal ones")
    return np.array([[letters.index(letter) for letter in row] for row in rows])


def is_file(name: str) -> bool:
    """Return whether a text names a file rather than an entry of a library."""
    return bool(Path(name).suffix) or Path(name).name != name
