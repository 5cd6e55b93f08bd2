# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command line. What a command does stands in ``commands.py``, which is loaded when one runs."""

from __future__ import annotations

import argparse
import logging
import os
import sys
from collections.abc import Sequence
from typing import NoReturn, get_args

from stitchmesh import __version__
from stitchmesh.errors import StitchMeshError
from stitchmesh.quality import Solver
from stitchmesh.stretch_command import add_stretch
from stitchmesh.swatch_command import add_swatch

BAD_INPUT, INTERRUPTED = 2, 130
"""Exit statuses."""
READ_YARNS = "yarns: .h5, .bcc, .usda, .usdc, .vtp or .obj"
WRITTEN_YARNS = "yarns: .h5, .bcc, .usda, .usdc, .vtp, .glb or .obj"
STITCHES = "stitch mesh, .h5 or .smobj"
GENERATED_RADIUS = "an eighth of the stitch width"
FOUND_RADIUS = "the file's own, else estimated from the distances of yarns"


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; returns the exit status.

    Args:
        argv: the words after the program's name; those of the process unless given.
    """
    arguments = parser().parse_args(argv)
    from stitchmesh import commands

    logging.basicConfig(format="%(message)s", level=logging.INFO, handlers=[_ToStandardError()])
    try:
        getattr(commands, arguments.command.replace("-", "_"))(arguments)
        sys.stdout.flush()
    except StitchMeshError as error:
        print(f"{type(error).__name__}: {error}", file=sys.stderr)
        return BAD_INPUT
    except KeyboardInterrupt:
        print("interrupted; what was saved last is whole", file=sys.stderr)
        return INTERRUPTED
    except BrokenPipeError:  # who reads the output, `head` say, has seen enough; what is left goes nowhere
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return 0


class _ToStandardError(logging.Handler):
    """Logs to what standard error is now; while a progress is drawn that is a stream that keeps its lines apart."""

    def emit(self, record: logging.LogRecord) -> None:
        """Print one record."""
        print(self.format(record), file=sys.stderr)


class _Parser(argparse.ArgumentParser):
    """A parser that refuses in one line, as all of StitchMesh does."""

    def error(self, message: str) -> NoReturn:
        self.exit(BAD_INPUT, f"{self.prog}: {message}; see {self.prog} --help\n")


def parser() -> argparse.ArgumentParser:
    """The parser of all commands."""
    top = _Parser(prog="stitchmesh", description="From a polygon mesh to knitted, relaxed yarns.")
    top.add_argument("--version", action="version", version=f"stitchmesh {__version__}")
    commands = top.add_subparsers(dest="command", required=True, metavar="COMMAND")
    _add_knit(commands)
    _add_stitch_stages(commands)
    _add_yarn_stages(commands)
    add_swatch(commands)
    add_stretch(commands)
    _add_file_commands(commands)
    return top


def _add_knit(commands: argparse._SubParsersAction) -> None:
    knit = commands.add_parser("knit", help="a polygon mesh to relaxed yarns, a picture and a report")
    knit.add_argument("mesh", metavar="MESH", help="any polygon mesh: OBJ, PLY, OFF, STL, VTK ...")
    _add_output(knit, "DIR", "folder for the stitches, the yarns, a picture, a report and the convergence")
    _add_unit(knit)
    _add_rows(knit)
    _add_stitch_size(knit)
    knit.add_argument("--pattern", metavar="NAME|FILE", help="pattern that the stitches are worked in (all knit)")
    _add_remainder(knit, "--pattern-remainder")
    what = "knit tubes in one row that climbs, a single yarn (rings)"
    knit.add_argument("--spiral", action="store_true", help=what)
    _add_yarn(knit, GENERATED_RADIUS)
    _add_finish(knit)
    _add_rest_lengths(knit)
    _add_relaxation(knit)
    _add_device(knit)
    knit.add_argument("--no-picture", action="store_true", help="write no preview.png")


def _add_stitch_stages(commands: argparse._SubParsersAction) -> None:
    label = commands.add_parser("label", help="a polygon mesh to knitting rows")
    label.add_argument("mesh", metavar="MESH", help="any polygon mesh")
    _add_output(label, "FILE", "labeled mesh, .h5 or .smobj")
    _add_unit(label)
    _add_rows(label)

    tessellate = commands.add_parser("tessellate", help="a labeled mesh to stitches")
    tessellate.add_argument("labeled", metavar="LABELED", help="what `label` wrote")
    _add_output(tessellate, "FILE", STITCHES)
    _add_stitch_size(tessellate)
    tessellate.add_argument("--stitch-height", type=float, metavar="CM", help="course spacing (0.77 of the width)")

    pattern = commands.add_parser("pattern", help="work a stitch mesh in a pattern")
    pattern.add_argument("fabric", metavar="FABRIC", help=STITCHES)
    pattern.add_argument("pattern", metavar="PATTERN", help="name of a pattern (`stitchmesh patterns`), or a file")
    _add_output(pattern, "FILE", STITCHES)
    pattern.add_argument(
        "--face", type=int, metavar="FACE",
        help="only the largest grid of plain stitches around this face, counted from 0 (the whole fabric)",
    )  # fmt: skip
    _add_remainder(pattern, "--remainder")

    edit = commands.add_parser("edit", help="edit stitches: apply a log of edits")
    edit.add_argument("fabric", metavar="FABRIC", help=STITCHES)
    edit.add_argument("--replay", metavar="LOG", help="edits to apply, one JSON object a line (docs/editing.md)")
    edit.add_argument("-o", "--output", metavar="FILE", help=STITCHES)

    relax_mesh = commands.add_parser("relax-mesh", help="even out stitches on the surface")
    relax_mesh.add_argument("fabric", metavar="FABRIC", help=STITCHES)
    relax_mesh.add_argument("--surface", required=True, metavar="LABELED", help="what `label` wrote")
    _add_output(relax_mesh, "FILE", STITCHES)


def _add_yarn_stages(commands: argparse._SubParsersAction) -> None:
    yarns = commands.add_parser("yarns", help="stitches to yarn curves")
    yarns.add_argument("fabric", metavar="FABRIC", help=STITCHES)
    _add_output(yarns, "FILE", WRITTEN_YARNS)
    _add_yarn(yarns, GENERATED_RADIUS)
    _add_finish(yarns)

    relax = commands.add_parser("relax", help="relax yarns physically")
    relax.add_argument("yarns", metavar="YARNS", help=READ_YARNS)
    _add_output(relax, "FILE", WRITTEN_YARNS)
    _add_report(relax)
    fabric = relax.add_mutually_exclusive_group()
    fabric.add_argument("--keep-shape", metavar="FABRIC", help=f"{STITCHES}, whose shape the yarns keep")
    fabric.add_argument("--fabric", help=f"{STITCHES}, that the yarns were made from, if they need not keep it")
    _add_yarn(relax, FOUND_RADIUS)
    _add_rest_lengths(relax)
    _add_relaxation(relax)
    _add_pins(relax)
    _add_unit(relax)
    _add_device(relax)

    again = commands.add_parser("relax-edited", help="relax yarns again after an edit, from where they were at rest")
    again.add_argument("yarns", metavar="YARNS", help="yarns at rest before the edit, .h5")
    again.add_argument("--before", required=True, metavar="FABRIC", help=f"{STITCHES}, that they were made from")
    again.add_argument("--after", required=True, metavar="FABRIC", help=f"{STITCHES}, edited; the yarns keep its shape")
    _add_output(again, "FILE", WRITTEN_YARNS)
    _add_report(again)
    _add_quality(again)
    _add_finish(again)
    _add_relaxation(again)
    _add_device(again)


def _add_file_commands(commands: argparse._SubParsersAction) -> None:
    info = commands.add_parser("info", help="what a file holds")
    info.add_argument("file", metavar="FILE")
    _add_reading(info)

    check = commands.add_parser("check", help="whether a file is sound: status 0, or one line and status 2")
    check.add_argument("file", metavar="FILE")
    _add_reading(check)

    commands.add_parser("patterns", help="the patterns and weaves of the library, their sizes and sources")

    instructions = commands.add_parser("instructions", help="a stitch mesh in words, to knit by hand")
    instructions.add_argument("fabric", metavar="FABRIC", help=STITCHES)
    instructions.add_argument("-o", "--output", metavar="FILE", help="text file (printed)")

    what = "one yarn or mesh format to another; stitch meshes: .h5, .smobj, or .k for a knitting machine"
    convert = commands.add_parser("convert", help=what)
    convert.add_argument("file", metavar="IN")
    convert.add_argument("output", metavar="OUT")
    what = "of yarns that repeat: periods along the courses and along the wales to write (one, or the lattice)"
    convert.add_argument("--tile", type=int, nargs=2, metavar=("C", "R"), help=what)
    _add_reading(convert)

    render = commands.add_parser("render", help="a picture of yarns, stitches, rows or a mesh")
    render.add_argument("file", metavar="FILE")
    _add_output(render, "PNG", "picture")
    what = "of a stitch mesh: rows, stitches or stretch (rows if it is only labeled, else stitches)"
    render.add_argument("--what", metavar="KIND", help=what)
    _add_reading(render)


def _add_reading(command: argparse.ArgumentParser) -> None:
    _add_unit(command)
    _add_radius(command, FOUND_RADIUS)


def _add_output(command: argparse.ArgumentParser, metavar: str, text: str) -> None:
    command.add_argument("-o", "--output", required=True, metavar=metavar, help=text)


def _add_report(command: argparse.ArgumentParser) -> None:
    what = "folder for report.json, convergence.csv and convergence.png"
    command.add_argument("--report", metavar="DIR", help=what)


def _add_unit(command: argparse.ArgumentParser) -> None:
    command.add_argument("--unit", default="cm", help="unit of files that state none: mm, cm, dm, m, inch (cm)")


def _add_rows(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--seed", type=_edge, action="append", default=[], metavar="V,W",
        help="course edge that rows start from, by its two vertices counted from 0; repeatable",
    )  # fmt: skip
    command.add_argument(
        "--flip", type=int, action="append", default=[], metavar="FACE",
        help="face whose row is turned over, counted from 0; repeatable",
    )  # fmt: skip


def _add_stitch_size(command: argparse.ArgumentParser) -> None:
    command.add_argument("--stitch-width", type=float, default=0.8, metavar="CM", help="wale spacing (0.8)")


def _add_remainder(command: argparse.ArgumentParser, flag: str) -> None:
    what = "stitches that whole tiles of the pattern leave over: centre, stretch or refuse (centre)"
    command.add_argument(flag, default="centre", metavar="HOW", help=what)


def _add_yarn(command: argparse.ArgumentParser, radius: str) -> None:
    _add_radius(command, radius)
    _add_quality(command)


def _add_quality(command: argparse.ArgumentParser) -> None:
    command.add_argument("--quality", default="standard", help="draft, standard (default) or reference")


def _add_radius(command: argparse.ArgumentParser, otherwise: str) -> None:
    command.add_argument("--yarn-radius", type=float, metavar="CM", help=f"yarn radius ({otherwise})")


def _add_finish(command: argparse.ArgumentParser) -> None:
    group = command.add_argument_group("first and last rows, and floats")
    what = "backward loops (default), or open yarn-overs"
    group.add_argument("--cast-on", default="backward", metavar="backward|open", help=what)
    what = "yarn drawn through the last loops (default), or a chain"
    group.add_argument("--bind-off", default="drawn", metavar="drawn|chain", help=what)
    what = "stitches of other yarns behind which a yarn is carried on; beyond, it is cut (12)"
    group.add_argument("--longest-float", type=int, default=12, metavar="N", help=what)


def _add_relaxation(command: argparse.ArgumentParser) -> None:
    _add_terms(command)
    _add_solver(command)


def _add_rest_lengths(command: argparse.ArgumentParser) -> None:
    group = command.add_argument_group("rest lengths")
    group.add_argument("--rest-length-factor", type=float, default=1.0, metavar="F", help="factor of all yarn (1)")
    group.add_argument("--loop-length", type=float, metavar="CM", help="yarn in every plain stitch, before factors")
    group.add_argument(
        "--rest-length", action="append", default=[], metavar="KEY=F",
        help="factor of a stitch type (k=1.1), a row (row:3=0.9), a yarn (yarn:12=1.2), or of the floats=F or held=F "
        "loops of slip stitches; repeatable",
    )  # fmt: skip


def _add_terms(command: argparse.ArgumentParser) -> None:
    group = command.add_argument_group("more physics, off unless asked for")
    what = "acceleration [cm/s^2]; on Earth 0 -981 0 where y points up"
    group.add_argument("--gravity", type=float, nargs=3, metavar=("X", "Y", "Z"), help=what)
    what = "coefficient of friction between yarns, or two: along the yarn and across it"
    group.add_argument("--friction", type=_coefficients, metavar="MU[,MU]", help=what)
    what = "torsional stiffness [erg cm], and twist of each yarn from end to end [rad] (0)"
    group.add_argument("--twist", type=_one_or_two, metavar="K[,ANGLE]", help=what)
    group.add_argument("--body", metavar="MESH", help="polygon mesh that the yarns stay outside of")
    group.add_argument("--body-unit", default="cm", metavar="UNIT", help="unit of the body's file (cm)")


def _add_solver(command: argparse.ArgumentParser) -> None:
    group = command.add_argument_group("solver")
    what = "stitchmesh (default), leaf, kaldor-simulation or kaldor-relaxation; scaled to the yarn's radius"
    group.add_argument("--material", default="stitchmesh", metavar="NAME", help=what)
    what = "quasistatic (default), or dynamics as Leaf 2018"
    group.add_argument("--solver", choices=get_args(Solver), help=what)
    what = "iterations after which to stop, at rest or not (the quality's)"
    group.add_argument("--max-iterations", type=int, metavar="N", help=what)
    what = "write a checkpoint every N iterations: in knit's folder, or beside the file in a folder of its name"
    group.add_argument("--checkpoint-every", type=int, metavar="N", help=what)
    what = "checkpoint, .smc, to go on from; all else as it was given then"
    group.add_argument("--resume", metavar="PATH", help=what)


def _add_pins(command: argparse.ArgumentParser) -> None:
    group = command.add_argument_group("pins")
    what = "control point that stays where it is, counted from 0; repeatable"
    group.add_argument("--pin-point", type=int, action="append", default=[], metavar="POINT", help=what)
    what = "stitch face whose loops stay where they are, counted from 0; repeatable"
    group.add_argument("--pin-face", type=int, action="append", default=[], metavar="FACE", help=what)


def _add_device(command: argparse.ArgumentParser) -> None:
    command.add_argument("--device", help="cpu or cuda:0 (the first GPU if there is one)")


def _coefficients(text: str) -> float | tuple[float, float]:
    first, *second = _one_or_two(text)
    return (first, second[0]) if second else first


def _one_or_two(text: str) -> tuple[float, ...]:
    try:
        numbers = tuple(float(word) for word in text.split(","))
    except ValueError:
        numbers = ()
    if len(numbers) not in (1, 2):
        raise argparse.ArgumentTypeError(f"got {text!r}; expected one number, or two with a comma between them")
    return numbers


def _edge(text: str) -> tuple[int, int]:
    first, second = text.split(",")
    return int(first), int(second)
