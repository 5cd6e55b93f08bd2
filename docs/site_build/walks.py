# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Writes the walks of the pages: the files that a reader opens to follow a computation.

    python docs/site_build/walks.py

A walk is run: each call of a function of the package is noted, and each kernel that is launched, with the functions
that the kernel calls. Functions that run while a module is imported do not count. Each walk runs on the CPU in a
process of its own, because a value that was kept from an earlier run would hide the calls that made it.

Most walks are on ``docs/architecture.md``. A walk may end before its computation does, and may have parts.
"""

from __future__ import annotations

import inspect
import json
import re
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from functools import cache
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "architecture.md"
"""The page of most walks."""
PACKAGE = ROOT / "stitchmesh"
FAST: dict[str, Any] = {"quality": "draft", "device": "cpu"}


def knit_a_hat() -> None:
    """From a polygon mesh to ``yarns.h5``."""
    import stitchmesh as sm

    with tempfile.TemporaryDirectory() as folder:
        hat = sm.read_mesh(ROOT / "assets" / "meshes" / "hat.obj")
        sm.knit(hat, stitch_width=4.0, folder=folder, run=sm.Run(progress=False), **FAST)


def relax_yarns() -> None:
    """A relaxation of plain yarns, which have no lattice, no further terms and no constraints."""
    import stitchmesh as sm

    mesh = sm.label(sm.read_mesh(ROOT / "assets" / "meshes" / "swatch.obj"))
    fabric = sm.tessellate(mesh, stitch_width=2.5)
    sm.relax_yarns(sm.generate_yarns(fabric), run=sm.Run(progress=False), **FAST)


def make_a_swatch() -> None:
    """From a pattern to a swatch that is let go off the needles."""
    import stitchmesh as sm

    sm.swatch("stockinette", relax_cell=True, progress=False, **FAST)


def drape_a_scene() -> None:
    """From a scene to cloth and yarns at rest."""
    import stitchmesh as sm

    sm.drape(ROOT / "examples" / "mixed" / "puckering.toml", run=sm.Run(progress=False))


@dataclass(frozen=True)
class Walk:
    """A computation, and the function inside it from which a reader starts."""

    run: Callable[[], None]
    """The computation."""
    within: str | None = None
    """Qualified name of the function whose first call is followed; None for all of the computation."""
    until: str | None = None
    """Qualified name of the function at whose first return the walk ends; None for the end of the computation."""
    parts: dict[str, str] = field(default_factory=dict)
    """For each part of the walk, the qualified name of the function with whose first call the part begins."""
    page: Path = PAGE
    """The page on which the walk is written."""


WALKS = {
    "a mesh to yarns.h5": Walk(knit_a_hat),
    "one iteration": Walk(relax_yarns, within="YarnSimulation.iterate"),
    "one interval": Walk(relax_yarns, within="RelaxationLoop.advance"),
    "a pattern to a swatch": Walk(make_a_swatch),
    "a scene to drape": Walk(drape_a_scene),
    "a scene to its first force": Walk(
        drape_a_scene,
        until="SystemNewton.set_downhill_force",
        parts={
            "Reading the scene": "drape",
            "Making cloth, yarns and region": "prepare",
            "Making the system": "begin_simulation",
            "The first force": "EquilibriumSearch.run",
        },
        page=ROOT / "docs" / "mixed-solver.md",
    ),
}

Functions = dict[str, dict[str, int]]
"""For each file, in the order in which they first run, the lines of each function that runs."""


@dataclass(frozen=True)
class Walked:
    """What a walk has found."""

    functions: Functions
    """The functions that run."""
    begins: dict[str, int]
    """For each part, the number of files that have run before it begins."""


class Footsteps:
    """The functions that run, and those of the kernels that are launched."""

    def __init__(self, walk: Walk) -> None:
        """Note all functions of a walk."""
        self.functions: Functions = {}
        self.begins: dict[str, int] = {}
        self._walk, self._within = walk, walk.within
        self._part_of = {function: part for part, function in walk.parts.items()}
        self._last: FrameType | None = None
        self._inside: FrameType | None = None
        self._noted: set[CodeType] = set()

    def note(self, frame: FrameType, event: str, _argument: object) -> None:
        """Note a call; the function of a profile."""
        code = frame.f_code
        if event == "return" and frame in (self._inside, self._last):
            sys.setprofile(None)
        if event != "call":
            return
        if self._within is not None and self._inside is None:
            if code.co_qualname != self._within:
                return
            self._inside = frame
        if code.co_qualname == self._walk.until and self._last is None:
            self._last = frame
        part = self._part_of.get(code.co_qualname) if _is_function(code) else None
        if part is not None:
            self.begins.setdefault(part, len(self.functions))
        if code.co_name == "launch":
            self._note_kernels(frame)
        if code not in self._noted and _is_function(code) and not _is_importing(frame):
            self._noted.add(code)
            self._add(code)

    def _note_kernels(self, frame: FrameType) -> None:
        """Note the kernels of a launch: of ``wp.launch``, of one that was prepared, or of a table of prepared ones."""
        launcher = frame.f_locals.get("self")
        launches = [frame.f_locals, *map(vars, getattr(launcher, "_launches", ())), getattr(launcher, "__dict__", {})]
        for launch in launches:
            kernel = launch.get("kernel")
            if kernel is not None and hasattr(kernel, "func"):
                self._add_with_callees(kernel.func)

    def _add_with_callees(self, function: Any) -> None:
        code = function.__code__
        if code in self._noted or not _is_function(code):
            return
        self._noted.add(code)
        self._add(code)
        known = {**function.__globals__, **inspect.getclosurevars(function).nonlocals}
        for name in (*code.co_names, *code.co_freevars):
            callee = known.get(name)
            if type(callee).__name__ == "Function":
                self._add_with_callees(callee.func)

    def _add(self, code: CodeType) -> None:
        last = max(line for *_, line in code.co_lines() if line is not None)
        of_file = self.functions.setdefault(str(Path(code.co_filename).relative_to(PACKAGE)), {})
        of_file[code.co_qualname] = last - code.co_firstlineno + 1


def _is_function(code: CodeType) -> bool:
    """Whether code is a function of the package, and not the body of a module or of a class."""
    return code.co_filename.startswith(f"{PACKAGE}/") and bool(code.co_flags & inspect.CO_OPTIMIZED)


def _is_importing(frame: FrameType) -> bool:
    """Whether a call is made by a module while it is imported."""
    caller = frame.f_back
    while caller is not None:
        if caller.f_code.co_name == "<module>" and caller.f_code.co_filename.startswith(f"{PACKAGE}/"):
            return True
        caller = caller.f_back
    return False


@cache
def walked(name: str) -> Walked:
    """Run a walk in a process of its own.

    Args:
        name: a key of ``WALKS``.
    """
    command = [sys.executable, __file__, name]
    done = subprocess.run(command, check=True, cwd=ROOT, stdout=subprocess.PIPE, text=True)
    return Walked(**json.loads(done.stdout.splitlines()[-1]))


def walk_text(found: Walked) -> str:
    """The number of files and lines of a walk, and a table of its files, or one for each of its parts."""
    functions = found.functions
    lines = sum(len((PACKAGE / file).read_text(encoding="utf-8").splitlines()) for file in functions)
    run = sum(sum(of_file.values()) for of_file in functions.values())
    summary = f"{len(functions)} files with {lines:,} lines; the functions that run have {run:,} lines."
    files, starts = list(functions), [*found.begins.values(), len(functions)]
    if not found.begins:
        return f"{summary}\n\n{_table(files)}"
    text = summary
    for part, start, end in zip(found.begins, starts[:-1], starts[1:], strict=True):
        text += f"\n\n{part}: {end - start} files.\n\n{_table(files[start:end])}"
    return text


def _table(files: list[str]) -> str:
    """A table of files by their folders."""
    of_folder: dict[str, list[str]] = {}
    for file in files:
        folder, _, name = file.partition("/")
        of_folder.setdefault(folder if name else "", []).append(name or folder)
    rows = [
        f"| {f'`{folder}`' if folder else ''} | {', '.join(f'`{name}`' for name in names)} |"
        for folder, names in of_folder.items()
    ]
    return "\n".join(["| folder | files, in the order in which they first run |", "|---|---|", *rows])


def page_with_walks(page: str, walks: dict[str, Walked]) -> str:
    """The text of the page with walks written anew between their two comments.

    Raises:
        ValueError: the page has no such comments.
    """
    for name, found in walks.items():
        begin, end = f"<!-- walk: {name} -->\n", "<!-- end of walk -->"
        text = f"{begin}\n{walk_text(found)}\n\n{end}"
        pattern = re.escape(begin) + ".*?" + re.escape(end)
        page, count = re.subn(pattern, lambda _, text=text: text, page, flags=re.DOTALL)
        if count != 1:
            raise ValueError(f"page of walks: got {count} walks named {name!r}; expected 1")
    return page


def walk_here(name: str) -> None:
    """Run a walk in this process, and print its functions as JSON."""
    walk = WALKS[name]
    footsteps = Footsteps(walk)
    sys.setprofile(footsteps.note)
    walk.run()
    sys.setprofile(None)
    print(json.dumps(asdict(Walked(footsteps.functions, footsteps.begins))))


if __name__ == "__main__":
    if len(sys.argv) > 1:
        walk_here(sys.argv[1])
    else:
        for page in {walk.page for walk in WALKS.values()}:
            of_page = {name: walked(name) for name, walk in WALKS.items() if walk.page == page}
            page.write_text(page_with_walks(page.read_text(), of_page))
