# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Hostile words for every option of every command, made from the dataclasses of the commands, and their runs.

Each run is a child process of its own, with limits on its address space and on its processor time: the children of one
clean process (``Runner``), because a process with threads cannot be forked safely.
"""

from __future__ import annotations

import ctypes
import importlib
import json
import os
import pkgutil
import resource
import subprocess
import sys
import threading
import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, is_dataclass
from pathlib import Path
from types import NoneType
from typing import Annotated, Any, get_args, get_origin, get_type_hints

from tyro.conf import UseAppendAction

import stitchmesh
from stitchmesh.app import run as app_run
from stitchmesh.cli import progress as cli_progress
from stitchmesh.cli.main import COMMANDS, main
from tests.cli.every_command import WORDS
from tests.gallery import ROOT

NUMBERS = ("0", "-1", "nan", "inf", "1e9", "1000000000", "1e-300", "1e300", "1e400", "1" + "0" * 400)
"""Numbers at which a computation may break; one that is whole in every way of writing a count."""
TEXTS = ("", "nan", "x" * 300, "a/" * 2500 + "b", "a\nb", "a\0b", "[" * 1000, "\udcff")
"""Texts and names of files at which a command may break."""
QUICK = {"quality": "draft", "device": "cpu", "max_iterations": "2"}
"""Options with which a command is quick, where it has them."""
FORMS = {
    "V,W": "{},0", "V,W=COUNT": "0,1={}", "V,W=LABEL": "{},0=course", "KEY=F": "k={}", "NAME=VALUE": "k_len={}",
    "PANEL=U,V": "0={},1", "N=COLOUR": "{}=red", "A[,B]": "{}", "AXIS|X,Y,Z": "{},0,1", "CM CM": "{} free",
    "FROM:TO": "0:{}", "TIME": "{}s", "ERROR": "{}%", "STITCHES[xROWS]": "{0}x{0}", "PLACE": "point {} 0 0",
    "VIEW": "{},0", "CM [CM]": "{}", "PIXELS [PIXELS]": "{}", "MU[,MU]": "{}", "K[,ANGLE]": "{}",
    "SELECTION": "row {}",
}  # fmt: skip
"""Texts that hold a number, by the placeholder of the option in the help."""


@dataclass(frozen=True)
class Option:
    """An option of a command."""

    name: str
    metavar: str
    numbers: int
    """How many numbers it takes; 0 for a text."""

    def words(self, value: str) -> list[list[str]]:
        """Return the ways to give the option with a value."""
        flag = "--" + self.name.replace("_", "-")
        text = FORMS.get(self.metavar, "{}").format(value)
        if self.numbers <= 1:
            return [[f"{flag}={text}"]] if self.metavar != "CM CM" else [[flag, *text.split()]]
        values = [["1"] * place + [value] + ["1"] * (self.numbers - place - 1) for place in range(self.numbers)]
        return [[flag, *each] for each in values]


def options_of(group: Any) -> Iterator[Option]:
    """Yield the options of a command or of a group of options, without flags."""
    for name, hint in get_type_hints(group, include_extras=True).items():
        inner, *notes = get_args(hint) if get_origin(hint) is Annotated else (hint,)
        if is_dataclass(inner):
            yield from options_of(inner)
        elif inner is not bool:
            metavars = [note.metavar for note in notes if getattr(note, "metavar", None)]
            yield Option(name, metavars[0] if metavars else "", _numbers_of(inner, notes))


def _numbers_of(declared: Any, notes: Sequence[object]) -> int:
    parts = [part for part in get_args(declared) if part is not NoneType]
    if NoneType in get_args(declared):
        return _numbers_of(parts[0], notes) if len(parts) == 1 else 0
    if get_origin(declared) is tuple:
        if UseAppendAction in notes or Ellipsis in parts:
            return int(parts[0] in (int, float))
        return len(parts) if all(part in (int, float) for part in parts) else 0
    return int(declared in (int, float))


def cases(name: str, values: Sequence[str], *, texts: Sequence[str] = ()) -> Iterator[list[str]]:
    """Yield the words of a command with one hostile option, for each option and value.

    Args:
        name: name of the command.
        values: numbers, which are also put into the places of numbers in texts.
        texts: texts, for options that take any.
    """
    own = list(options_of(COMMANDS[name]))
    for base in WORDS[name]:
        for option in own:
            beside = quick_words(own, option.name)
            yield from (
                [name, *base, *beside, *words]
                for value in (*values, *(() if option.numbers else texts))
                for words in option.words(value)
            )


def without_hostile_words(name: str) -> Iterator[list[str]]:
    """Yield the words with which a command does its work, quickly."""
    quick = quick_words(list(options_of(COMMANDS[name])), "")
    yield from ([name, *base, *quick] for base in WORDS[name])


def with_path(name: str, hostile: Callable[[str], Iterator[str]]) -> Iterator[list[str]]:
    """Yield the words of a command with a hostile path in the place of each of its paths."""
    for place, word in enumerate(words := next(without_hostile_words(name))):
        if ("." in word and "=" not in word) or word in ("out", "job", "frames"):
            yield from ([*words[:place], path, *words[place + 1 :]] for path in hostile(word))


def hostile_paths(path: str) -> Iterator[str]:
    """Yield paths with the suffix of a path that the system refuses to an owner without rights of root."""
    suffix = Path(path).suffix
    yield from (f"closed/{path}", f"read-only/{path}", f"read-only/deep/{path}", f"tube.obj/x{suffix}")
    yield from ("x" * 300 + suffix, "x/" * 2500 + f"x{suffix}", f"circle{suffix}", f"/proc/x{suffix}")
    yield from (f"a\0b{suffix}", f"a\nb{suffix}", f"\udcff{suffix}", f"\ud800{suffix}", "", ".", "/dev/full")
    yield from ("yarns.h5", "tube.obj")  # of mode 0


def quick_words(own: Sequence[Option], without: str) -> list[str]:
    """Return the words with which a command is quick, without the option that is varied."""
    names = {option.name for option in own} - {without}
    return [word for name, value in QUICK.items() if name in names
            for word in (f"--{name.replace('_', '-')}", value)]  # fmt: skip


@dataclass(frozen=True)
class Ended:
    """How a run ended."""

    status: int | None
    """Exit status; None after a signal."""
    signal: int
    output: str
    errors: str


class Runner:
    """A process that has imported the program, and runs each command in a child of its own, with limits."""

    def __init__(self) -> None:
        environment = {**os.environ, "STITCHMESH_THREADS": "1"}
        self._process = subprocess.Popen(
            [sys.executable, "-m", "tests.cli.hostile"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
            cwd=ROOT, env=environment,
        )  # fmt: skip

    def run(
        self, words: Sequence[str], folder: Path, *, memory: float = 4e9, seconds: int = 60, unprivileged: bool = False,
        read_only: bool = False,
    ) -> Ended:
        """Run a command in a folder.

        Args:
            words: the words of the command.
            folder: present folder of the child; its standard output and errors go to files beside it.
            memory: additional address space [bytes].
            seconds: processor time [s].
            unprivileged: whether the child may only what the modes of files permit to their owner.
            read_only: whether the folder is on a file system that is mounted read-only, which only root can ask for.
        """
        assert self._process.stdin is not None and self._process.stdout is not None
        asked = [list(words), os.fspath(folder), memory, seconds, unprivileged, read_only]
        self._process.stdin.write(json.dumps(asked) + "\n")
        self._process.stdin.flush()
        status, number = json.loads(self._process.stdout.readline())
        output, errors = (folder.with_suffix(suffix).read_text(errors="replace") for suffix in (".out", ".err"))
        return Ended(status, number, output, errors)

    def close(self) -> None:
        """End the process."""
        self._process.communicate()


def serve() -> None:
    """Run the commands that standard input asks for, and answer on standard output."""
    for module in pkgutil.walk_packages(stitchmesh.__path__, "stitchmesh."):
        if not module.name.endswith("__main__"):
            importlib.import_module(module.name)
    app_run._asked_to_end = _ends_at_once
    cli_progress.LINE_SECONDS = float("inf")  # lines that depend on the clock
    for line in sys.stdin:
        child = os.fork()
        if child == 0:
            _limited(*json.loads(line))
        _child, status = os.waitpid(child, 0)
        ended = os.WEXITSTATUS(status) if os.WIFEXITED(status) else None
        print(json.dumps([ended, os.WTERMSIG(status) if os.WIFSIGNALED(status) else 0]), flush=True)


@contextmanager
def _ends_at_once() -> Iterator[threading.Event]:
    """Stand for ``_asked_to_end`` of the application: the wish to end is there before the server waits for it."""
    end = threading.Event()
    end.set()
    yield end


def _limited(
    words: list[str], folder: str, memory: float, seconds: int, unprivileged: bool, read_only: bool
) -> None:  # fmt: skip
    status = 99
    try:
        if read_only:
            _mount_read_only(folder)
        os.chdir(folder)
        os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
        for suffix, number in ((".out", 1), (".err", 2)):
            os.dup2(os.open(Path(folder).with_suffix(suffix), os.O_WRONLY | os.O_CREAT | os.O_TRUNC), number)
        sys.stdout, sys.stderr = os.fdopen(1, "w"), os.fdopen(2, "w", errors="backslashreplace")
        pages = int(Path("/proc/self/statm").read_text().split()[0])
        most = pages * os.sysconf("SC_PAGE_SIZE") + int(memory)
        resource.setrlimit(resource.RLIMIT_AS, (most, most))
        used = int(sum(os.times()[:2])) + 1
        resource.setrlimit(resource.RLIMIT_CPU, (used + seconds, used + seconds + 1))
        if unprivileged:
            _drop_capabilities()
        try:
            status = main(words)
        except SystemExit as stop:
            status = int(stop.code or 0)
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(status)


def _drop_capabilities() -> None:
    """Give up the right of root to read and write everything; a file of mode 0 is then closed to its owner too."""
    header, none = (ctypes.c_uint32 * 2)(0x20080522, 0), (ctypes.c_uint32 * 6)()
    if ctypes.CDLL(None, use_errno=True).capset(header, none):
        raise OSError(ctypes.get_errno(), "capset")


def _mount_read_only(folder: str) -> None:
    """Mount a folder on itself, read-only, for this process alone (unshare and mount of Linux)."""
    new_mounts, private, bind, read_only = 0x20000, 0x44000, 0x1000, 0x1021
    library, path = ctypes.CDLL(None, use_errno=True), os.fsencode(folder)
    if (
        library.unshare(new_mounts) or library.mount(b"none", b"/", None, private, None)
        or library.mount(path, path, None, bind, None) or library.mount(b"none", path, None, read_only, None)
    ):  # fmt: skip
        raise OSError(ctypes.get_errno(), "mount")


if __name__ == "__main__":
    serve()
