# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A swatch book: patterns of the library at rest in one yarn, as HTML that opens from a folder without a server.

The swatches are the jobs of a sweep in the folder ``swatches`` of the book, so a book that was stopped continues, and
many workers or a GPU share the work. Each pattern then gets its pictures, its files and its leaf (``leaf``).
"""

from __future__ import annotations

import logging
import re
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.resources import files
from os import PathLike
from pathlib import Path
from typing import Any, Literal

from stitchmesh.errors import ParameterError
from stitchmesh.io.atomic import write_text
from stitchmesh.io.outputs import claim_folder, guarded_outputs, plan_outputs
from stitchmesh.io.path_kind import whole_path
from stitchmesh.io.yarns import read_yarns
from stitchmesh.jobs.book.leaf import FOLDERS, LEAVES, PICTURES, WOVEN, Leaf, leaf_of, script_of
from stitchmesh.jobs.job_status import Listener, StopRequest
from stitchmesh.jobs.sweep.result_table import read_table
from stitchmesh.jobs.sweep.row import ERROR, YARNS
from stitchmesh.jobs.sweep.run_sweep import run_sweep
from stitchmesh.jobs.sweep.sweep import Kept, StretchMeasure, Sweep
from stitchmesh.markup import Markup, joined, markup
from stitchmesh.patterns.library import FAMILIES, pattern_names, unknown_name
from stitchmesh.periodic.resolve_pattern import resolve_pattern
from stitchmesh.periodic.swatch_options import KnitState
from stitchmesh.periodic.weave.library import weave_names
from stitchmesh.progress import Progress, shown_stages
from stitchmesh.yarn.yarn_presets import Yarn

PAGE, SWATCHES = "index.html", "swatches"
"""The page that people open, and the folder of the sweep."""
REFERENCE = "stockinette"
"""The knit beside which the widths of all knits stand."""
STRAINS, STEPS = (0.0, 0.2), 3
"""First and last strain of the stretch tests, and the number of strains."""

logger = logging.getLogger(__name__)


@dataclass(frozen=True, kw_only=True)
class SwatchBook:
    """What a swatch book shows.

    Raises:
        ParameterError: the library has no pattern or weave of a name, a name stands twice, or the yarn is unknown.
    """

    patterns: tuple[str, ...] = ()
    """Names of knits and weaves of the library; all of them without names."""
    yarn: str = "dk"
    """Name of the yarn."""
    relaxation: KnitState = "dry"
    """State in which the knits come to rest: as from the needles by default."""
    quality: str = "draft"
    """Preset of accuracy."""
    device: str | None = None
    """Device of the kernels; the first GPU, or the CPU if there is no GPU."""
    stretched: bool = True
    """Whether each pattern is drawn along its courses and its wales, which takes most of the time."""

    def __post_init__(self) -> None:
        Yarn.named(self.yarn)
        known = (*pattern_names(), *weave_names())
        for number, name in enumerate(self.patterns):
            if name != Path(name).stem:  # A leaf of this name would lie outside of its folder.
                raise ParameterError(f"book: got the path {name!r}; expected a name that `stitchmesh patterns` lists")
            if name not in known:
                raise unknown_name("book: pattern", name, known, "patterns and weaves")
            if name in self.patterns[:number]:
                raise ParameterError(f"book: pattern {name!r}: is given twice; name each pattern once")

    @property
    def names(self) -> tuple[str, ...]:
        """The patterns that the book shows, knits first."""
        return self.patterns or (*pattern_names(), *weave_names())

    def sweep(self) -> Sweep:
        """Return the sweep that makes the swatches."""
        yarn, weaves = Yarn.named(self.yarn), set(weave_names())
        own = {"relax_cell": True, "material": self.yarn, "yarn_radius": yarn.core_radius}
        knit = own | {"loop_length": yarn.loop_length, "relaxation": self.relaxation}
        rows = [{"swatch": {"pattern": name} | (own if name in weaves else knit)} for name in self.names]
        tests = [StretchMeasure(direction=along, strains=STRAINS, steps=STEPS) for along in ("course", "wale")]
        job = {"quality": self.quality} | ({} if self.device is None else {"device": self.device})
        return Sweep(
            job=job, rows=tuple(rows),
            kept=Kept(write_yarns=True, picture=None, stretch=tuple(tests) if self.stretched else ()),
        )  # fmt: skip


def write_book(
    book: SwatchBook, folder: str | PathLike[str], *, workers: int | None = None, stop: StopRequest | None = None,
    listener: Listener = lambda _: None, overwrite: bool = False, progress: Progress | Literal[False] | None = None,
) -> Path:  # fmt: skip
    """Relax the patterns of a book, and write its page.

    Swatches that an earlier call has relaxed are not relaxed again.

    Args:
        book: what the book shows.
        folder: folder of the book; ``index.html`` in it is the page that people open.
        workers: number of processes, as for ``run_sweep``.
        stop: the request to stop, which a signal handler or another thread may make.
        listener: called with each report of the progress of the swatches.
        overwrite: whether the book may replace files in the folder that StitchMesh did not write, or that were changed
            later.
        progress: called with the stage ``book`` and the completed part while pictures and files are written; by default
            a line shows it on a terminal or in a notebook, and False shows nothing.

    Returns:
        The path of the page.

    Raises:
        DisplayError: this machine cannot draw pictures.
        FileError: another run works in the folder, or files cannot be written or may not be replaced.
        ParameterError: the number of workers is not possible, no pattern can be made, or a package is missing.
        JobStopped: the work was stopped; the same call continues it.
    """
    target = whole_path(folder)
    with guarded_outputs(overwrite=overwrite):
        plan_outputs([target / PAGE], folder=target)
        claim_folder(target, (*FOLDERS, SWATCHES))
        run_sweep(book.sweep(), target / SWATCHES, workers=workers, stop=stop, listener=listener, overwrite=overwrite)
        with shown_stages(progress) as shown:
            leaves = _write_leaves(target, shown)
        write_text(target / PAGE, _page(book, leaves))
    return target / PAGE


def _write_leaves(target: Path, shown: Progress) -> list[Leaf]:
    """Write the leaf of each pattern whose swatch could be made."""
    columns = read_table(target / SWATCHES)
    rows = [dict(zip(columns, values, strict=True)) for values in zip(*columns.values(), strict=True)]
    reference = next(
        (row["wale_spacing"] for row in rows if row["swatch.pattern"] == REFERENCE and row[ERROR] is None), None
    )
    leaves = list[Leaf]()
    for number, row in enumerate(rows):
        name = row["swatch.pattern"]
        shown("book", number / len(rows), f"{name}, {number + 1} of {len(rows)}")
        if row[ERROR] is not None:
            logger.warning("%s: is not in the book: %s", name, row[ERROR])
            continue
        source = resolve_pattern(name)
        yarns = read_yarns(target / SWATCHES / row[YARNS])
        woven = name in weave_names()
        leaf = leaf_of(name, source, yarns, row, None if woven else reference, target)
        write_text(target / LEAVES / f"{name}.js", script_of(leaf))
        leaves.append(leaf)
    if not leaves:
        raise ParameterError(f"book: none of {len(rows)} patterns could be made; the first error is: {rows[0][ERROR]}")
    return leaves


def _page(book: SwatchBook, leaves: Sequence[Leaf]) -> str:
    """Return the HTML of the page."""
    families = [name for name in (*FAMILIES, WOVEN) if any(leaf.family == name for leaf in leaves)]
    state = f"{len(leaves)} patterns in the yarn {book.yarn}, knits {book.relaxation}, at {book.quality}."
    parts: dict[str, Any] = {
        "state": markup("{}", state),
        "families": joined(markup("<option>{}</option>", name) for name in families),
        "cards": joined(map(_card, leaves)),
    }
    template = files(__package__).joinpath("book.html").read_text(encoding="utf-8")
    return re.sub(r"\{\{(\w+)\}\}", lambda place: parts[place[1]], template)


def _card(leaf: Leaf) -> Markup:
    """Return the entry of a pattern in the list."""
    return markup(
        '<li data-name="{}" data-family="{}"><a href="#{}"><img src="{}/{}-small.jpg" alt="{}, relaxed, right side" '
        'loading="lazy" width="160" height="160"><b>{}</b><span>{}</span></a></li>\n',
        leaf.name, leaf.family, leaf.name, PICTURES, leaf.name, leaf.title, leaf.title, leaf.gauge,
    )  # fmt: skip
