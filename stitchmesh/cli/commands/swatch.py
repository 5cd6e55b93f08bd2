# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``swatch``."""

from __future__ import annotations

import sys
from dataclasses import asdict, dataclass, field, fields, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from tyro.conf import Positional, UseAppendAction, arg

from stitchmesh import __version__
from stitchmesh.budget.budget import NO_TIME_FOR_PICTURE, POINT_OF_PICTURE, START_OF_RENDERER
from stitchmesh.cli.budget_options import (
    BudgetOptions,
    ChosenQuality,
    chosen_setting,
    exit_status,
    time_after,
)
from stitchmesh.cli.options import (
    Device,
    DrawnRadius,
    MaxIterations,
    Overwrite,
    Serving,
    SwatchFabric,
    Threads,
    YarnColours,
)
from stitchmesh.cli.output_folder import (
    draw_if_possible,
    output_folder,
    plot_history,
)
from stitchmesh.cli.say import say
from stitchmesh.cli.setting_flags import flag_of
from stitchmesh.cli.summary import AsJson, exploration_summary, files_to_open, print_result, sized_lines, swatch_summary
from stitchmesh.cli.words import Flag, Period, help_entry
from stitchmesh.errors import FileError, ParameterError
from stitchmesh.jobs.sections import SwatchTable
from stitchmesh.mesh.palette import checked_palette
from stitchmesh.periodic.swatch_options import ReleaseSettings, SwatchOptions
from stitchmesh.quality import DEFAULT_QUALITY, PRESETS, Quality, quality_named, quality_with
from stitchmesh.recipe.sections import MaterialSection
from stitchmesh.yarn.rest_length import parse_rest_lengths

if TYPE_CHECKING:
    from stitchmesh.budget.budget import Budget
    from stitchmesh.patterns import Pattern
    from stitchmesh.periodic.swatch import Swatch
    from stitchmesh.periodic.swatch_to import SizedSwatch
    from stitchmesh.periodic.weave.weave import Weave
    from stitchmesh.progress import Progress
    from stitchmesh.yarn import YarnSet
    from stitchmesh.yarnrelax import YarnMaterial

PICTURE = "preview.png"
"""Picture of the tiled repeat in the output folder."""
SHEET = "pattern.pdf"
"""Pattern to take home there."""
OUTPUTS = ("cell.h5", "cell.pyp", "tiled.bcc", "report.json", "convergence.csv", "convergence.png")
"""Other files that one relaxation writes there."""
FOUND_BY_SIZE = ("loop_length", "period", "relax_cell", "columns", "rows", "gamma", "spacing")
"""Options that a search for a size finds, or that weaves have."""
RESTS = ("rests.json", "rests.png")
"""Files that a search for states of rest writes there, beside the yarns of each state."""


@dataclass(frozen=True)
class SwatchCommand:
    """Relax one repeat of a pattern or weave, or design it in the browser."""

    pattern: Annotated[Positional[str], help_entry("PATTERN")]
    """pattern or weave: a name of `stitchmesh patterns`, or a file"""
    output: Annotated[str | None, help_entry("DIR", "none", short="-o")] = None
    """output folder for the repeat, a tiled piece, a picture, a report and the convergence"""
    stitches: Annotated[str | None, help_entry("FILE", "built-in stitches only")] = None
    """drawings (.json) of stitches of your own, whose codes the pattern uses (docs/own-stitches.md)"""
    fabric: SwatchFabric = field(default_factory=SwatchFabric)
    rest_length: Annotated[UseAppendAction[tuple[str, ...]], flag_of(SwatchTable, "rest_lengths")] = ()
    drawn_radius: DrawnRadius = None
    colours: YarnColours = field(default_factory=YarnColours)
    material: MaterialSection = field(default_factory=MaterialSection)
    release: Annotated[ReleaseSettings, arg(name="")] = field(default_factory=ReleaseSettings)
    sheet: Flag = False
    """write pattern.pdf too: picture, measures, yarn, chart and legend, to take home"""
    explore: Annotated[int | None, help_entry("N", "one relaxation")] = None
    """relax the free repeat, without friction unless --relaxation says otherwise, from N perturbed starts too, and list
    and draw its distinct states of rest instead"""
    period: Annotated[Period, flag_of(SwatchTable, "period")] = SwatchOptions.period
    width: Annotated[float | None, help_entry("CM", "as the yarn gives")] = None
    """width of a piece of whole repeats, which comes true: the loop length, the numbers of stitches and rows and the
    needle are found; a --gauge with rows, such as 22x30, comes true in this pattern likewise"""
    height: Annotated[float | None, help_entry("CM", "as the yarn gives")] = None
    """height of that piece"""
    quality: ChosenQuality = None
    budget: Annotated[BudgetOptions, arg(name="")] = field(default_factory=BudgetOptions)
    max_iterations: MaxIterations = None
    device: Device = None
    threads: Threads = None
    tile: Annotated[tuple[int, int], help_entry("C R")] = (5, 5)
    """numbers of repeats along the courses and along the wales in the picture and in tiled.bcc"""
    texture: Annotated[tuple[int, ...] | None, help_entry("PIXELS [PIXELS]", "no textures")] = None
    """write texture maps of one repeat with this width and height; without a height, pixels are square"""
    no_picture: Flag = False
    """do not write preview.png"""
    json: AsJson = False
    view: Flag = False
    """design the swatch in the browser, from this pattern, yarn, gauge and --gamma; nothing is written"""
    serving: Annotated[Serving, arg(name="")] = field(default_factory=Serving)
    overwrite: Overwrite = False

    def run(self) -> int | None:
        """Relax the repeat, write it with its pictures, and print a summary; or open the application at its page.

        Returns:
            The exit status if the time ended the relaxation, otherwise None.

        Raises:
            ParameterError: neither an output folder nor the browser is asked for, or an option is given that has no
                effect beside the others.
        """
        if self.view:
            own = replace(self.fabric, spacing=None, longest_float=SwatchFabric.longest_float)  # what the dials take
            effective = SwatchCommand(self.pattern, fabric=own, threads=self.threads, view=True, serving=self.serving)
            self._refuse_others(effective, "--view", "the browser has dials and stitches of its own")
            self._open_in_browser()
            return None
        if self.output is None:
            raise ParameterError("swatch: needs -o DIR for its files, or --view for the browser")
        self._refuse_others(replace(self, serving=Serving()), "-o DIR", "add --view, which opens the browser")
        release = self.release
        if release.unsupported and not release.has_free_size and self.explore is None:
            raise ParameterError("unsupported: a repeat of fixed size lies on nothing anyway; add --relax-cell")
        from stitchmesh.cli.progress import show_progress
        from stitchmesh.first_use import compile_before_relaxing
        from stitchmesh.periodic.weave.weave import Weave
        from stitchmesh.render import render_swatch

        tiles, pixels = check_tiles(self.tile), check_texture(self.texture)
        source = self._source()
        woven = isinstance(source, Weave)
        fabric = self.fabric
        if self._sized:
            fabric = replace(fabric, yarn=replace(fabric.yarn, gauge=None))
        options = SwatchOptions(
            **fabric.options(woven=woven, drawn_radius=self.drawn_radius),
            rest_lengths=parse_rest_lengths(self.rest_length), period=self.period,
            relaxation=release.relaxation, friction=release.friction, unsupported=release.unsupported,
            blocked=release.blocked, relax_cell=release.relax_cell, residual_twist=release.residual_twist,
            steamed=release.steamed, yield_curvature=release.yield_curvature,
        )  # fmt: skip
        self._check_memory(source, options, tiles, pixels)
        if self.explore is not None:
            self._explore(source, options)
            return None
        after, draws = time_after(None if self.no_picture else self._picture_seconds(source), self.budget.within)
        budget = self.budget.budget(after, chooses=self._leaves_quality)
        outputs = [*OUTPUTS, *([] if self.no_picture else [PICTURE]), *([SHEET] if self.sheet else [])]
        sized = None
        with output_folder(self.output, outputs) as folder, show_progress() as progress:
            compile_before_relaxing(self.device, on_lattice=True, progress=progress)
            if self._sized:
                sized = self._to_size(source, options, progress)
                made = sized.swatch
                options = replace(
                    options, relax_cell=True, loop_length=sized.loop_length, yarn_radius=sized.yarn_radius
                )
            else:
                made = self._relaxed(source, options, budget, progress)
            made = replace(made, yarns=replace(made.yarns, made_of=self.fabric.yarn.named()))
            report = self._report(source, options, made)
            if sized is not None:
                report["sized"] = sized.report()
            _write(folder, made, report, tiles, pixels)
            drawn = False
            if draws:
                progress("picture", 0.0, PICTURE)
                drawn = draw_if_possible(lambda: render_swatch(made.yarns, folder / PICTURE, tiles))
            elif not self.no_picture:
                say(NO_TIME_FOR_PICTURE, file=sys.stderr)
            if self.sheet:
                self._write_sheet(folder, source, made, drawn)
        lines = swatch_summary(made, report["name"], self.fabric.yarn.named())
        if sized is not None:
            lines += sized_lines(sized)
        print_result(report, [*lines, files_to_open(folder, drawn)], as_json=self.json)
        return exit_status(report)

    def _write_sheet(self, folder: Path, source: Pattern | Weave, made: Swatch, drawn: bool) -> None:
        """Write the pattern to take home."""
        from stitchmesh.io.contents import read_bytes
        from stitchmesh.render.pattern_sheet import swatch_sheet, write_pattern_sheet
        from stitchmesh.yarn.yarn_presets import Gauge

        gauge = Gauge.of_stitch(made.report["wale_spacing"], made.report["course_spacing"])
        picture = read_bytes(folder / PICTURE) if drawn else None
        sheet = swatch_sheet(source, made.yarns, gauge, yarn=self.fabric.yarn.named(), picture=picture)
        write_pattern_sheet(folder / SHEET, sheet)

    def _explore(self, source: Pattern | Weave, options: SwatchOptions) -> None:
        """Search for states of rest, and write and print them."""
        from stitchmesh.cli.progress import show_progress
        from stitchmesh.io.atomic import write_json
        from stitchmesh.io.yarns import write_yarns
        from stitchmesh.periodic.explore import explore

        assert self.output is not None and self.explore is not None
        if self._sized:
            raise ParameterError("explore: got a size that comes true beside it; leave one of both out")
        effective = replace(self, tile=SwatchCommand.tile, texture=None, release=replace(self.release, shaken=0))
        self._refuse_others(effective, "--explore", "it writes and draws each state")
        if self.budget.budget() is not None:
            raise ParameterError("explore: got --within or --error beside it; each start runs to rest; leave one out")
        quality, starts = self._quality, self.explore
        options = replace(options, relaxation=options.relaxation or "frictionless", relax_cell=True)
        with output_folder(self.output, RESTS) as folder, show_progress() as progress:
            found = explore(
                source, starts, material=self._material(options),
                quality=quality, device=self.device, progress=progress, **vars(options),
            )  # fmt: skip
            head = {"pattern": self.pattern, "name": source.name, "quality": self._name, "version": __version__}
            counts = {"starts": found.starts, "not_at_rest": found.not_at_rest, "spread": found.spread}
            report = head | counts | {"rests": found.table()}
            for number, rest in enumerate(found.rests, 1):
                write_yarns(folder / f"rest-{number}.h5", rest.swatch.yarns)
            write_json(folder / "rests.json", head | {"options": asdict(options)} | report)
            drawn = False
            if found.rests and not self.no_picture:
                from stitchmesh.render.thumbnails.rest_sheet import draw_rests

                drawn = draw_if_possible(lambda: draw_rests(found, folder / "rests.png"))
        print_result(report, exploration_summary(found, folder, drawn=drawn), as_json=self.json)

    def _material(self, options: SwatchOptions) -> YarnMaterial:
        """Return the material of the yarn."""
        return self.material.yarn_material(options.yarn_radius, options.mass_per_length, self.fabric.yarn.yarn)

    def _refuse_others(self, effective: SwatchCommand, beside: str, reason: str) -> None:
        """Refuse an option that has no effect beside another one.

        Args:
            effective: the command with those options that have an effect.
            beside: the other option.
            reason: why the option has no effect, or what to do.

        Raises:
            ParameterError: another option is given.
        """
        pairs: list[tuple[Any, Any]] = [(self, effective)]
        pairs += [(self.release, effective.release), (self.fabric, effective.fabric)]
        differing = [each.name for own, kept in pairs for each in fields(own)
                     if getattr(own, each.name) != getattr(kept, each.name)]  # fmt: skip
        for name in [each for each in differing if each not in {"release", "fabric"}]:
            raise ParameterError(f"swatch: {name.replace('_', '-')} has no effect beside {beside}; {reason}")

    def _open_in_browser(self) -> None:
        from stitchmesh.app.starts import SWATCH, swatch_project

        self.serving.run(partial(swatch_project, self.pattern, **self.design_dials()), SWATCH)

    def design_dials(self) -> dict[str, float]:
        """Return the dials of a design that the options of the fabric set."""
        from stitchmesh.periodic.resolve_pattern import resolve_pattern
        from stitchmesh.periodic.swatch_design import dials_of_yarn

        fabric, yarn = self.fabric, self.fabric.yarn.named()
        options = SwatchOptions(**fabric.options(woven=False))
        sizes = {"yarn_radius": options.yarn_radius, "loop_length": options.plain_loop}
        repeat = {name: getattr(options, name) for name in ("gamma", "columns", "rows")}
        if yarn is None:
            return sizes | repeat
        given = {"yarn_radius": fabric.yarn_radius, "loop_length": fabric.loop_length or fabric.yarn.gauge}
        own = {name: value for name, value in sizes.items() if given[name] is not None}
        return dials_of_yarn(yarn, resolve_pattern(self.pattern)) | own | repeat

    def _source(self) -> Pattern | Weave:
        """Return the pattern or the weave, with the colours of the options."""
        from stitchmesh.periodic.resolve_pattern import resolve_pattern
        from stitchmesh.yarngen.templates.own_checks import read_own_stitches

        drawings = () if self.stitches is None else read_own_stitches(self.stitches)
        source = resolve_pattern(self.pattern, drawings)
        if not self.colours.colour:
            return source
        palette = self.colours.recoloured(checked_palette(source.palette, ParameterError))
        return replace(source, palette=tuple(map(tuple, palette.tolist())))

    def _check_memory(
        self, source: Pattern | Weave, options: SwatchOptions, tiles: tuple[int, int],
        pixels: tuple[int, int | None] | None,
    ) -> None:  # fmt: skip
        """Refuse what does not fit into the memory, before the relaxation.

        Raises:
            ParameterError: as for ``check_memory``.
        """
        from stitchmesh.periodic.relaxation.prepared_swatch import check_repeat_memory
        from stitchmesh.yarn.tiling import check_tiled_memory

        check_repeat_memory(source, options, self._quality, self.device, free=False)
        check_tiled_memory(self._points(source), *tiles)
        if pixels is not None:
            from stitchmesh.periodic.textures.textures import check_texture_memory

            check_texture_memory(pixels[0], pixels[1] or pixels[0])  # Without a height the pixels are square.

    def _points(self, source: Pattern | Weave) -> float:
        """Return the number of control points of the cell at the default quality."""
        from stitchmesh.periodic.resolve_pattern import stitches_of

        stitches = stitches_of(source) * self.fabric.columns * self.fabric.rows
        return PRESETS[DEFAULT_QUALITY].control_points_per_stitch * stitches

    def _picture_seconds(self, source: Pattern | Weave) -> float:
        """Estimate the time to draw the repeats [s]."""
        return START_OF_RENDERER + POINT_OF_PICTURE * self._points(source) * self.tile[0] * self.tile[1]

    @property
    def _name(self) -> str:
        return self.quality or DEFAULT_QUALITY

    @property
    def _leaves_quality(self) -> bool:
        """Whether no option asks for a quality."""
        return self.quality is None and self.max_iterations is None

    @property
    def _quality(self) -> Quality:
        return quality_named(quality_with(self._name, max_iterations=self.max_iterations))

    def _relaxed(
        self, source: Pattern | Weave, options: SwatchOptions, budget: Budget | None, progress: Progress
    ) -> Swatch:
        """Relax the repeat, and report the progress."""
        from stitchmesh.periodic.swatch import swatch
        from stitchmesh.progress import with_work_after

        material = self._material(options)
        return swatch(
            source, material=material, quality=self._quality, device=self.device, shaken=self.release.shaken,
            budget=budget,
            progress=progress if self.no_picture else with_work_after(progress, START_OF_RENDERER), **vars(options),
        )  # fmt: skip

    @property
    def _sized(self) -> bool:
        """Whether a size is asked for that comes true: a width, a height, or a gauge with rows."""
        gauge = self.fabric.yarn.gauge
        return self.width is not None or self.height is not None or (gauge is not None and "x" in gauge.lower())

    def _to_size(self, source: Pattern | Weave, options: SwatchOptions, progress: Progress) -> SizedSwatch:
        """Find the loop length that gives the size, and report the progress.

        Raises:
            ParameterError: an option is given that the search finds or does not obey.
        """
        from stitchmesh.periodic.swatch_to import swatch_to
        from stitchmesh.progress import with_work_after

        fabric, release = self.fabric, self.release
        others = {
            "period": self.period != SwatchOptions.period, "loop-length": fabric.loop_length is not None,
            "gamma": fabric.gamma != 1.0, "columns": fabric.columns != 1, "rows": fabric.rows != 1,
            "shaken": release.shaken != 0, "within": self.budget.budget() is not None,
        }  # fmt: skip
        for name in (name for name, given in others.items() if given):
            raise ParameterError(f"swatch: {name} has no effect beside a size that comes true; leave one of both out")
        yarn = fabric.yarn.named()
        given = yarn is not None or fabric.yarn_radius is not None
        named = given or self.material != MaterialSection()
        kept = {name: value for name, value in vars(options).items() if name not in FOUND_BY_SIZE and value is not None}
        if not given:
            kept.pop("yarn_radius")
        return swatch_to(
            source, gauge=fabric.yarn.gauge, width=self.width, height=self.height, yarn=yarn, quality=self._quality,
            device=self.device,
            progress=progress if self.no_picture else with_work_after(progress, START_OF_RENDERER),
            **({"material": self._material(options)} if named else {}), **kept,
        )  # fmt: skip

    def _report(self, source: Pattern | Weave, options: SwatchOptions, made: Swatch) -> dict[str, Any]:
        """Return the report: the pattern, the options, the version, and the figures of the swatch."""
        yarn = {"material": self.material.chosen(self.fabric.yarn.yarn), "stiffness": self.material.values()}
        name = chosen_setting(made.report) or self._name
        asked = {"quality": name, **yarn}
        head = {"pattern": self.pattern, "name": source.name, "source": source.source, "version": __version__}
        return head | {"options": asked | asdict(options)} | made.report


def check_tiles(tiles: tuple[int, int]) -> tuple[int, int]:
    """Check the numbers of repeats, and return them.

    Raises:
        ParameterError: a number is less than 1.
    """
    if min(tiles) < 1:
        raise ParameterError(f"tile: got {tiles[0]} {tiles[1]}; expected whole numbers from 1")
    return tiles


def check_texture(numbers: tuple[int, ...] | None) -> tuple[int, int | None] | None:
    """Check the size of texture maps before the relaxation, and return width and height [pixels].

    Raises:
        ParameterError: there are more than two numbers, or a number is out of bounds.
    """
    if numbers is None:
        return None
    from stitchmesh.periodic.textures.textures import LARGEST

    if len(numbers) > 2 or not all(1 <= number <= LARGEST for number in numbers):
        found = " ".join(map(str, numbers))
        raise ParameterError(f"texture: got {found}; expected a width, or width and height, from 1 to {LARGEST} pixels")
    return numbers[0], numbers[1] if len(numbers) == 2 else None


def _write(
    folder: Path, made: Swatch, report: dict[str, Any], tiles: tuple[int, int],
    pixels: tuple[int, int | None] | None,
) -> None:  # fmt: skip
    from stitchmesh.io.atomic import write_json
    from stitchmesh.io.history import write_history
    from stitchmesh.io.yarns import write_yarns
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
    """Write the format of periodic yarn patterns; if it cannot hold the yarns, print the reason instead."""
    from stitchmesh.io.yarn_formats.pyp import check_pyp
    from stitchmesh.io.yarns import write_yarns

    try:
        check_pyp(path, cell)
    except FileError as error:
        say(f"not written: {error}", file=sys.stderr)
        return
    write_yarns(path, cell)
