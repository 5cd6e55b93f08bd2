# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Draws the pictures of ``docs/`` that the program draws, and says which of them are out of date.

    python docs/site_build/pictures.py                          # lists the pictures and their state
    python docs/site_build/pictures.py draw                     # draws all that are out of date
    python docs/site_build/pictures.py draw 'pictures/*.jpg'    # draws these

``docs/site_build/pictures.json`` lists the pictures. An entry has ``files`` (a picture, or a pattern of names), the
``commands`` that draw them, ``from`` if a command writes another file that becomes the picture, its ``width`` [pixels]
if that is smaller, and ``drawn``, the mark of its last drawing: a checksum of the commands and of the code that draws.
Comments and docstrings do not count. A picture whose mark is no longer right fails the build of the site. A picture
without a mark was drawn before there was this list, and does not.
"""

from __future__ import annotations

import ast
import hashlib
import json
import shlex
import subprocess
import sys
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, replace
from fnmatch import fnmatch
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
LIST = Path("docs") / "site_build" / "pictures.json"
"""The list of pictures, in the repository."""
RENDERER = (
    "stitchmesh/render/*.py", "stitchmesh/render/draped/*.py", "stitchmesh/mesh/tube_mesh.py",
    "stitchmesh/mesh/palette.py", "stitchmesh/yarn/colours.py", "stitchmesh/yarn/polyline.py",
    "stitchmesh/yarn/tiling.py", "stitchmesh/yarn/yarn_look.py", "stitchmesh/yarn/yarn_strands.py",
)  # fmt: skip
"""The code that draws meshes and yarns."""
CHANGED = "changed since"
"""The state of a picture whose commands or renderer changed after it was drawn."""
JPEG_QUALITY = 86
REDRAW = "python docs/site_build/pictures.py draw"
"""The command that draws pictures again."""


@dataclass(frozen=True, kw_only=True)
class Entry:
    """Pictures that the same commands draw."""

    files: str
    """A picture of ``docs/``, or a pattern of names."""
    commands: tuple[str, ...] = ()
    """The commands that draw it; none if they are not known."""
    source: str = ""
    """The file that becomes the picture; empty if a command writes the picture itself."""
    width: int = 0
    """Width of the picture [pixels]; 0 for that of the file."""
    drawn: str = ""
    """Mark of the last drawing; empty if the picture is older than the list."""

    def state(self, code: str) -> str:
        """Return whether the pictures are up to date, and if not, why; ``code`` is the checksum of the renderer."""
        if not self.commands:
            return "no command is known"
        if not self.drawn:
            return "older than this list"
        return "up to date" if self.drawn == self.mark(code) else CHANGED

    def mark(self, code: str) -> str:
        """Return the checksum of the commands and of the code that draws, of which the checksum is given."""
        commands = json.dumps([self.commands, self.source, self.width])
        return hashlib.sha256((commands + code).encode()).hexdigest()[:16]


def code_mark(root: Path = ROOT) -> str:
    """Return the checksum of the code of the renderer, without comments and docstrings."""
    paths = sorted({path for pattern in RENDERER for path in root.glob(pattern)})
    content = "".join(f"{path.relative_to(root)}\n{_code(path.read_text(encoding='utf-8'))}\n" for path in paths)
    return hashlib.sha256(content.encode()).hexdigest()


def _code(text: str) -> str:
    """Return a module in a form that comments, docstrings and line breaks do not change."""
    tree = ast.parse(text)
    for node in ast.walk(tree):
        body = getattr(node, "body", None)
        if isinstance(body, list):
            node.body = [each for each in body if not _is_text(each)]  # type: ignore[attr-defined]
    return ast.dump(tree)


def _is_text(node: ast.stmt) -> bool:
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str)


def read_list(root: Path = ROOT) -> tuple[list[Entry], list[str]]:
    """Return the entries of the list, and the patterns of pictures that other programs draw: plots and pages."""
    content = json.loads((root / LIST).read_text(encoding="utf-8"))
    entries = [
        Entry(**{"source" if key == "from" else key: value for key, value in each.items() if key != "commands"},
              commands=tuple(each.get("commands", ())))
        for each in content["pictures"]
    ]  # fmt: skip
    return entries, content["others"]


def written_list(entries: Iterable[Entry], other: Sequence[str]) -> str:
    """Return the text of the list of pictures."""
    rows = []
    for entry in entries:
        named = {"from" if key == "source" else key: value for key, value in asdict(entry).items() if value}
        rows.append("    " + json.dumps(named))
    return '{\n  "pictures": [\n' + ",\n".join(rows) + '\n  ],\n  "others": ' + json.dumps(list(other)) + "\n}\n"


def check(root: Path = ROOT) -> None:
    """Refuse pictures that were drawn by the list and are no longer up to date.

    Raises:
        ValueError: there are some; the message says how to draw them again.
    """
    code = code_mark(root)
    changed = [entry.files for entry in read_list(root)[0] if entry.state(code) == CHANGED]
    if changed:
        raise ValueError(
            f"docs/{changed[0]}: the renderer or the command of this picture changed after it was drawn"
            f" ({len(changed)} such pictures); draw it again by `{REDRAW} {shlex.quote(changed[0])}`"
        )


def draw(entry: Entry, root: Path = ROOT, ran: set[str] | None = None) -> Entry:
    """Run the commands of an entry, and return it with its new mark.

    Args:
        entry: the entry.
        root: folder of the repository.
        ran: commands that have run for other pictures and need not run again; those of this entry are added.

    Raises:
        ValueError: the commands are not known, one of them failed, or they do not write the picture.
    """
    if not entry.commands:
        raise ValueError(f"docs/{entry.files}: no command is known that draws it; add it to {LIST}")
    programs = {"python": [sys.executable], "stitchmesh": [sys.executable, "-m", "stitchmesh"]}
    ran = set() if ran is None else ran
    for command in entry.commands:
        if command in ran:
            continue
        first, *words = shlex.split(command)
        done = subprocess.run([*programs.get(first, [first]), *words], cwd=root, check=False)
        if done.returncode:
            raise ValueError(f"docs/{entry.files}: `{command}` ended with status {done.returncode}")
        ran.add(command)
    if entry.source:
        from PIL import Image

        picture = Image.open(root / entry.source).convert("RGB")
        if entry.width:
            size = entry.width, round(picture.height * entry.width / picture.width)
            picture = picture.resize(size, Image.Resampling.LANCZOS)
        picture.save(root / "docs" / entry.files, quality=JPEG_QUALITY, optimize=True)
    if not list((root / "docs").glob(entry.files)):
        raise ValueError(f"docs/{entry.files}: the commands have not written it; see {LIST}")
    return replace(entry, drawn=entry.mark(code_mark(root)))


def main(words: Sequence[str], root: Path = ROOT) -> int:
    """List the pictures, or draw some, and return the exit status."""
    entries, other = read_list(root)
    code, ran = code_mark(root), set[str]()
    if not words:
        for entry in entries:
            print(f"{entry.state(code):<22}{entry.files}")
        return 0
    if words[0] != "draw":
        print(f"got {words[0]!r}; expected draw, or nothing")
        return 2
    for number, entry in enumerate(entries):
        asked = any(fnmatch(entry.files, word) for word in words[1:])
        if asked or (not words[1:] and entry.commands and entry.state(code) != "up to date"):
            try:
                entries[number] = draw(entry, root, ran)
            except ValueError as error:
                print(error)
                return 1
            # A run of hours keeps what it has drawn if it is ended.
            (root / LIST).write_text(written_list(entries, other), encoding="utf-8")
            print(f"drawn: docs/{entry.files}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
