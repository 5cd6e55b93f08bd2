# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The program: it parses the command line, runs the command, and returns the exit status."""

from __future__ import annotations

import io
import logging
import os
import sys
import tempfile
import traceback
from collections.abc import Sequence
from contextlib import nullcontext, suppress

from stitchmesh import __version__
from stitchmesh.cli.arguments import BAD_INPUT, Command, parse
from stitchmesh.cli.budget_options import mark_start
from stitchmesh.cli.commands.animate import AnimateCommand
from stitchmesh.cli.commands.application import AppCommand, ViewCommand
from stitchmesh.cli.commands.blender_addon import BlenderAddonCommand
from stitchmesh.cli.commands.drape import DrapeCommand
from stitchmesh.cli.commands.edit import EditCommand
from stitchmesh.cli.commands.fabric_parts import CaptureCommand, PatternCommand, SelectCommand
from stitchmesh.cli.commands.files import CheckCommand, ConvertCommand, InfoCommand
from stitchmesh.cli.commands.fit import FitCommand
from stitchmesh.cli.commands.follow import FollowCommand
from stitchmesh.cli.commands.grade import GradeCommand
from stitchmesh.cli.commands.instructions import InstructionsCommand
from stitchmesh.cli.commands.jobs import BatchCommand, BookCommand, JobCommand, RunCommand, StatusCommand
from stitchmesh.cli.commands.knit import KnitCommand
from stitchmesh.cli.commands.label import LabelCommand
from stitchmesh.cli.commands.library import ExamplesCommand, PatternsCommand
from stitchmesh.cli.commands.measure import MeasureCommand
from stitchmesh.cli.commands.outline import OutlineCommand
from stitchmesh.cli.commands.relax import RelaxCommand, RelaxEditedCommand
from stitchmesh.cli.commands.render import RenderCommand
from stitchmesh.cli.commands.squeeze import SqueezeCommand
from stitchmesh.cli.commands.stages import RelaxMeshCommand, TessellateCommand, YarnsCommand
from stitchmesh.cli.commands.stretch import StretchCommand
from stitchmesh.cli.commands.swatch import SwatchCommand
from stitchmesh.cli.commands.warm_up import WarmUpCommand
from stitchmesh.cli.commands.yarn import YarnCommand
from stitchmesh.cli.say import say
from stitchmesh.cli.stop_signal import INTERRUPTED, interrupt_noted
from stitchmesh.compute.threads import set_threads
from stitchmesh.errors import ParameterError, StitchMeshError, is_interrupt
from stitchmesh.io.disk_refusal import FULL, refusal
from stitchmesh.io.outputs import guarded_outputs

FAULT = 70
"""Exit status after a fault of the program, ``EX_SOFTWARE`` of ``sysexits.h``."""
INTERRUPTION = "interrupted; files that have been written are complete"
"""Line after an interrupt."""
VERBOSE = "--verbose"
"""Word that every command takes: messages about details are printed too."""
DESCRIPTION = (
    "From a polygon mesh to knitted, relaxed yarns. `stitchmesh --version` prints the version, and a command with "
    f"`{VERBOSE}` also says details, such as the error of a conversion."
)
COMMANDS: dict[str, type[Command]] = {
    "knit": KnitCommand,
    "label": LabelCommand,
    "tessellate": TessellateCommand,
    "pattern": PatternCommand,
    "capture": CaptureCommand,
    "edit": EditCommand,
    "relax-mesh": RelaxMeshCommand,
    "yarns": YarnsCommand,
    "relax": RelaxCommand,
    "relax-edited": RelaxEditedCommand,
    "outline": OutlineCommand,
    "swatch": SwatchCommand,
    "stretch": StretchCommand,
    "squeeze": SqueezeCommand,
    "fit": FitCommand,
    "drape": DrapeCommand,
    "follow": FollowCommand,
    "animate": AnimateCommand,
    "run": RunCommand,
    "job": JobCommand,
    "status": StatusCommand,
    "batch": BatchCommand,
    "book": BookCommand,
    "info": InfoCommand,
    "select": SelectCommand,
    "check": CheckCommand,
    "patterns": PatternsCommand,
    "yarn": YarnCommand,
    "examples": ExamplesCommand,
    "instructions": InstructionsCommand,
    "grade": GradeCommand,
    "convert": ConvertCommand,
    "render": RenderCommand,
    "view": ViewCommand,
    "app": AppCommand,
    "blender-addon": BlenderAddonCommand,
    "measure": MeasureCommand,
    "warm-up": WarmUpCommand,
}
"""The commands by their names, in the order in which the help lists them."""


class ProgramFault(StitchMeshError):
    """The program itself is at fault, not its input."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command, and return the exit status.

    Args:
        argv: the words after the name of the program; the words of the process if it is None.
    """
    mark_start(fresh=argv is None)
    words = list(sys.argv[1:] if argv is None else argv)
    if words == ["--version"]:
        say(f"stitchmesh {__version__}")
        return 0
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="replace")  # A terminal may support ASCII only.
    verbose = VERBOSE in words
    words = [word for word in words if word != VERBOSE]
    level = logging.DEBUG if verbose else logging.INFO
    logging.basicConfig(format="%(message)s", level=level, handlers=[_StandardErrorHandler(verbose)])
    try:
        _check_words(words)
        command = parse(COMMANDS, words, program="stitchmesh", description=DESCRIPTION)
        set_threads(getattr(command, "threads", None))
        guard = guarded_outputs(overwrite=getattr(command, "overwrite", False)) if _writes(command) else nullcontext()
        with interrupt_noted() as interrupted, guard:
            status = command.run()
        sys.stdout.flush()
        if interrupted():
            raise KeyboardInterrupt
    except StitchMeshError as error:
        _say(f"{type(error).__name__}: {error}")
        return BAD_INPUT
    except MemoryError:
        _say("MemoryError: the memory that is free is not enough for this input; make less of it, or free memory")
        return BAD_INPUT
    except KeyboardInterrupt:
        _say(INTERRUPTION)
        return INTERRUPTED
    except BrokenPipeError:  # The reader of the output, for example `head`, has ended.
        _discard_output()
        return 0
    except OSError as error:
        if error.errno not in FULL:
            return _fault(error)
        _discard_output()
        _say(f"{error.filename or 'standard output'}: cannot be written {refusal(error)}")
        return BAD_INPUT
    except Exception as error:  # No part of the program expects it, so no status of another end may stand for it.
        if is_interrupt(error):
            _say(INTERRUPTION)
            return INTERRUPTED
        return _fault(error)
    return status or 0


def _fault(error: Exception) -> int:
    """Say that the program is at fault, and return the exit status."""
    fault = _fault_of(error)
    _say(f"{type(fault).__name__}: {fault}")
    return FAULT


def _fault_of(error: Exception) -> ProgramFault:
    """Return the line about an exception; its traceback is written to a new file, which only the user can read."""
    found = f"{type(error).__name__}: {error}"
    lines = [f"stitchmesh {__version__}\n", *traceback.format_exception(error)]
    try:
        number, path = tempfile.mkstemp(prefix="stitchmesh-fault-", suffix=".txt")
        with os.fdopen(number, "w", encoding="utf-8", errors="backslashreplace") as file:
            file.writelines(lines)
    except OSError as refused:
        told = f"its traceback cannot be written ({refused.strerror}); set TMPDIR to a folder that you may write"
    else:
        told = f"{path} holds the traceback; please report it, with the command"
    return ProgramFault(f"this is a fault of the program, not of its input ({found}); {told}")


def _say(line: str) -> None:
    with suppress(OSError):  # The disk of standard error is full too.
        say(line, file=sys.stderr)


def _writes(command: Command) -> bool:
    """Return whether a command writes files that the user names, and does not open the application."""
    serves = hasattr(command, "serving") and getattr(command, "output", None) is None
    return hasattr(command, "overwrite") and not serves


def _check_words(words: Sequence[str]) -> None:
    """Check that all arguments are texts: reports, recipes and the files of many formats hold names as UTF-8.

    Raises:
        ParameterError: the bytes of one are not UTF-8, which a name of a file on a disk can be.
    """
    for number, word in enumerate(words, start=1):
        try:
            word.encode("utf-8")
        except UnicodeEncodeError as error:
            raise ParameterError(f"argument {number}: {word!r} is not UTF-8; rename the file") from error


def _discard_output() -> None:
    """Write the rest of the output nowhere."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


class _StandardErrorHandler(logging.Handler):
    """A log handler that prints to the present value of ``sys.stderr``.

    While a progress bar is drawn, ``sys.stderr`` is a stream that prints log lines above the bar. Other packages print
    warnings only, and messages too with ``--verbose``.
    """

    def __init__(self, verbose: bool) -> None:
        """Print details too if ``verbose``."""
        super().__init__()
        self._others = logging.INFO if verbose else logging.WARNING

    def filter(self, record: logging.LogRecord) -> bool:
        """Return whether a record is printed."""
        is_own = record.name.partition(".")[0] == "stitchmesh"
        return (is_own or record.levelno >= self._others) and bool(super().filter(record))

    def emit(self, record: logging.LogRecord) -> None:
        """Print one record."""
        say(self.format(record), file=sys.stderr)
