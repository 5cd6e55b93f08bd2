# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``swatch``: its arguments, and what it does."""

from __future__ import annotations

import argparse
import sys
from argparse import Namespace
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stitchmesh.errors import FileError, ParameterError

if TYPE_CHECKING:
    from stitchmesh.periodic.swatch import Swatch, SwatchOptions
    from stitchmesh.yarn import YarnSet

FREE = "free"
"""A size of the repeat that is not given."""
TILES = (5, 5)
"""Periods in the picture and in the tiled file unless told."""


def add_swatch(commands: argparse._SubParsersAction) -> None:
    """Add the command to the parser."""
    command = commands.add_parser("swatch", help="one repeat of a pattern or weave, relaxed")
    command.add_argument("pattern", metavar="PATTERN", help="name of a pattern or weave, or a file of one")
    what = "folder for the repeat, tiles of it, a picture, a report and the convergence"
    command.add_argument("-o", "--output", required=True, metavar="DIR", help=what)
    _add_yarn(command)
    _add_cell(command)
    _add_solver(command)
    group = command.add_argument_group("output")
    what = "repeats along the courses and along the wales in the picture and in tiled.bcc (5 5)"
    group.add_argument("--tile", type=int, nargs=2, default=list(TILES), metavar=("C", "R"), help=what)
    what = "texture maps of one repeat, so many pixels wide (and high; square pixels)"
    group.add_argument("--texture", type=int, nargs="+", metavar="PIXELS", help=what)
    group.add_argument("--no-picture", action="store_true", help="write no preview.png")


def _add_yarn(command: argparse.ArgumentParser) -> None:
    group = command.add_argument_group("yarn")
    group.add_argument("--yarn-radius", type=float, metavar="CM", help="yarn radius (0.125)")
    group.add_argument("--loop-length", type=float, metavar="CM", help="yarn of a plain stitch (16.67 diameters)")
    what = "distance of a weave's yarns, or of its warps and of its wefts (2.4 diameters)"
    group.add_argument("--spacing", type=float, nargs="+", metavar="CM", help=what)
    what = "yarn is taken up by this factor, 0.1 to 10: the fabric is so much tighter (1)"
    group.add_argument("--gamma", type=float, default=1.0, metavar="G", help=what)
    what = (
        "take-up, 0.1 to 2: of a stitch type (k=0.9), a row (row:3=0.9), a yarn (yarn:1=1.2), of floats=F and held=F "
        "loops of slip stitches, of warp=F or weft=F; repeatable"
    )
    group.add_argument("--rest-length", action="append", default=[], metavar="KEY=F", help=what)
    what = "stitchmesh (default), leaf, kaldor-simulation or kaldor-relaxation; scaled to the yarn's radius"
    group.add_argument("--material", default="stitchmesh", metavar="NAME", help=what)


def _add_cell(command: argparse.ArgumentParser) -> None:
    group = command.add_argument_group("repeat")
    what = "let the repeat find its own width and height, but for those that are given"
    group.add_argument("--relax-cell", action="store_true", help=what)
    what = f"width and height of the repeat, numbers or {FREE} (as drawn)"
    group.add_argument("--period", type=_size, nargs=2, default=[None, None], metavar=("CM", "CM"), help=what)
    group.add_argument("--columns", type=int, default=1, metavar="N", help="repeats of the pattern side by side (1)")
    group.add_argument("--rows", type=int, default=1, metavar="N", help="repeats of the pattern above one another (1)")


def _add_solver(command: argparse.ArgumentParser) -> None:
    group = command.add_argument_group("solver")
    group.add_argument("--quality", default="standard", help="draft, standard (default) or reference")
    what = "iterations after which to stop, at rest or not (the quality's)"
    group.add_argument("--max-iterations", type=int, metavar="N", help=what)
    group.add_argument("--device", help="cpu or cuda:0 (the first GPU if there is one)")


def swatch(arguments: Namespace) -> None:
    """A repeat in the files of its folder, and its report printed."""
    import json

    from stitchmesh.output_folder import draw_if_possible, output_folder
    from stitchmesh.render import render_swatch

    tiles, pixels = _counts("tile", arguments.tile), _texture_size(arguments.texture)
    options = _options(arguments)
    with output_folder(arguments.output) as folder:
        made = _relaxed(arguments, options)
        report = _report(arguments, options, made)
        _write(folder, made, report, tiles, pixels)
    if not arguments.no_picture:
        draw_if_possible(lambda: render_swatch(made.yarns, folder / "preview.png", tiles))
    print(json.dumps(report, indent=2))


def _relaxed(arguments: Namespace, options: SwatchOptions) -> Swatch:
    """The repeat; its progress is drawn on the terminal."""
    from stitchmesh.periodic.swatch import swatch as relaxed_swatch
    from stitchmesh.pipeline import relaxing_progress
    from stitchmesh.progress import on_terminal
    from stitchmesh.quality import quality_named, quality_with
    from stitchmesh.yarnrelax import REFERENCE_RADIUS, YarnMaterial

    quality = quality_named(quality_with(arguments.quality, max_iterations=arguments.max_iterations))
    material = YarnMaterial.named(arguments.material).scaled(options.yarn_radius / REFERENCE_RADIUS)
    given = {name: getattr(options, name) for name in options.__dataclass_fields__}
    with on_terminal() as progress:
        tell = relaxing_progress("yarnrelax", quality.tolerance, progress, max_iterations=quality.max_iterations)
        return relaxed_swatch(
            arguments.pattern, material=material, quality=quality, device=arguments.device,
            relax_cell=arguments.relax_cell, **given,
            progress=lambda entry: tell(entry["iteration"], entry["residual"], entry["energies"]),
        )  # fmt: skip


def _options(arguments: Namespace) -> SwatchOptions:
    from stitchmesh.periodic.swatch import YARN_RADIUS, SwatchOptions
    from stitchmesh.yarn.rest_length import parse_rest_lengths

    return SwatchOptions(
        yarn_radius=YARN_RADIUS if arguments.yarn_radius is None else arguments.yarn_radius,
        loop_length=arguments.loop_length,
        spacing=_spacing(arguments.spacing),
        rest_lengths=parse_rest_lengths(arguments.rest_length),
        gamma=arguments.gamma,
        period=(arguments.period[0], arguments.period[1]),
        columns=arguments.columns,
        rows=arguments.rows,
    )


def _report(arguments: Namespace, options: SwatchOptions, made: Swatch) -> dict[str, Any]:
    """What was asked for, by which version, and the numbers of the swatch."""
    from stitchmesh import __version__
    from stitchmesh.periodic.resolve_pattern import resolve_pattern

    source = resolve_pattern(arguments.pattern)
    asked = {"quality": arguments.quality, "material": arguments.material, "relax_cell": arguments.relax_cell}
    head = {"pattern": arguments.pattern, "name": source.name, "source": source.source, "version": __version__}
    return head | {"options": asked | asdict(options)} | made.report


def _write(
    folder: Path, made: Swatch, report: dict[str, Any], tiles: tuple[int, int], pixels: tuple[int, int | None] | None
) -> None:
    from stitchmesh.io.atomic import write_json
    from stitchmesh.io.history import write_history
    from stitchmesh.io.yarns import write_yarns
    from stitchmesh.output_folder import plot_history
    from stitchmesh.periodic.textures.files import write_textures
    from stitchmesh.periodic.textures.textures import texture_maps

    write_yarns(folder / "cell.h5", made.yarns)
    _write_pyp(folder / "cell.pyp", made.yarns)
    write_yarns(folder / "tiled.bcc", made.yarns, tiles=tiles)
    if pixels is not None:
        write_textures(folder / "textures", texture_maps(made.yarns, width=pixels[0], height=pixels[1]))
    write_history(folder / "convergence.csv", made.history)
    plot_history(made.history, folder, report["options"]["quality"])
    write_json(folder / "report.json", report)


def _write_pyp(path: Path, cell: YarnSet) -> None:
    """Write the format of periodic patterns, where it can hold the yarns."""
    from stitchmesh.io.pyp import check_pyp
    from stitchmesh.io.yarns import write_yarns

    try:
        check_pyp(path, cell)
    except FileError as error:
        print(f"not written: {error}", file=sys.stderr)
        return
    write_yarns(path, cell)


def _size(text: str) -> float | None:
    try:
        return None if text == FREE else float(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(f"got {text!r}; expected a number of cm or {FREE}") from error


def _spacing(numbers: list[float] | None) -> float | tuple[float, float] | None:
    if numbers is None or len(numbers) == 1:
        return None if numbers is None else numbers[0]
    if len(numbers) != 2:
        raise ParameterError(f"spacing: got {len(numbers)} numbers; expected one, or one of warps and one of wefts")
    return numbers[0], numbers[1]


def _counts(name: str, numbers: list[int]) -> tuple[int, int]:
    if min(numbers) < 1:
        raise ParameterError(f"{name}: got {numbers[0]} {numbers[1]}; expected whole numbers from 1")
    return numbers[0], numbers[1]


def _texture_size(numbers: list[int] | None) -> tuple[int, int | None] | None:
    """Width and, where given, height [pixels]; refused before the work and not after it."""
    if numbers is None:
        return None
    from stitchmesh.periodic.textures.textures import LARGEST

    if len(numbers) > 2 or not all(1 <= number <= LARGEST for number in numbers):
        found = " ".join(map(str, numbers))
        raise ParameterError(f"texture: got {found}; expected a width, or width and height, from 1 to {LARGEST} pixels")
    return numbers[0], numbers[1] if len(numbers) == 2 else None
