# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What each command of the command line does."""

from __future__ import annotations

import dataclasses
import json
from argparse import Namespace
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

from stitchmesh.description import description, kind_of, stitch_counts
from stitchmesh.errors import ParameterError
from stitchmesh.hand_knitting import knitting_instructions
from stitchmesh.io import read_mesh, read_stitches, read_yarns, write_mesh, write_stitches, write_yarns
from stitchmesh.io.any_file import read_any
from stitchmesh.io.atomic import write_json, write_text
from stitchmesh.io.contents import suffix_of
from stitchmesh.io.history import write_history
from stitchmesh.io.stitches import WRITABLE as WRITABLE_STITCHES
from stitchmesh.io.yarns import check_writable
from stitchmesh.labeling import label as label_mesh
from stitchmesh.mesh import Mesh, StitchMesh
from stitchmesh.output_folder import draw_if_possible, output_folder, plot_history
from stitchmesh.patterns import pattern_names, read_pattern
from stitchmesh.patterns.placement.columns import check_remainder
from stitchmesh.pipeline import KnitOptions, RelaxOptions, relax_as_told, with_pattern
from stitchmesh.pipeline import knit as knit_mesh
from stitchmesh.quality import Quality, quality_with
from stitchmesh.stretch_command import stretch  # noqa: F401 (a command that stands in a file of its own)
from stitchmesh.swatch_command import swatch  # noqa: F401 (another)
from stitchmesh.tessellate import tessellate as tessellate_mesh
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.rest_length import RestLengths, parse_rest_lengths
from stitchmesh.yarngen import YarnFinish, generate_yarns, regenerate_yarns

if TYPE_CHECKING:
    from stitchmesh.yarnrelax.checkpoint import Checkpoints
    from stitchmesh.yarnrelax.energies.term import ConstraintChoice, TermChoice


def knit(arguments: Namespace) -> None:
    """The whole line, with a picture at the end."""
    from stitchmesh.progress import on_terminal

    options = KnitOptions(
        stitch_width=arguments.stitch_width,
        yarn_radius=arguments.yarn_radius,
        quality=_quality(arguments),
        device=arguments.device,
        seeds=arguments.seed,
        flip=arguments.flip,
        pattern=None if arguments.pattern is None else read_pattern(arguments.pattern),
        pattern_remainder=check_remainder(arguments.pattern_remainder),
        spiral=arguments.spiral,
        finish=_finish(arguments),
        relaxation=_relax_options(arguments, Path(arguments.output), _rest_lengths(arguments)),
    )
    with output_folder(arguments.output) as folder:
        mesh = read_mesh(arguments.mesh, unit=arguments.unit)
        with on_terminal() as progress:
            made = knit_mesh(mesh, folder, options, progress=progress)
    plot_history(made.history, folder, options.quality)
    if not arguments.no_picture:
        from stitchmesh.render import render_yarns

        draw_if_possible(lambda: render_yarns(made.yarns, folder / "preview.png"))
    print(json.dumps(made.report, indent=2))


def label(arguments: Namespace) -> None:
    """Rows and wale directions."""
    mesh = read_mesh(arguments.mesh, unit=arguments.unit)
    labeled = label_mesh(mesh, seeds=arguments.seed, flip=arguments.flip)
    write_stitches(arguments.output, labeled)
    print(f"{labeled.row.max() + 1} rows of {labeled.face_count} faces")


def tessellate(arguments: Namespace) -> None:
    """Stitch faces."""
    labeled = read_stitches(arguments.labeled)
    fabric = tessellate_mesh(labeled, stitch_width=arguments.stitch_width, stitch_height=arguments.stitch_height)
    write_stitches(arguments.output, fabric)
    print(", ".join(f"{count} {name}" for name, count in stitch_counts(fabric).items()))


def pattern(arguments: Namespace) -> None:
    """A stitch mesh in a pattern."""
    chosen = read_pattern(arguments.pattern)
    remainder = check_remainder(arguments.remainder)
    fabric = read_stitches(arguments.fabric)
    made, faces = with_pattern(fabric, chosen, remainder, face=arguments.face)
    write_stitches(arguments.output, made)
    print(f"{chosen.name}: {faces} of {made.face_count} stitches changed")


def edit(arguments: Namespace) -> None:
    """Stitches after the edits of a log; where one is refused, nothing is written."""
    from stitchmesh.editing.log import replay_edits

    if arguments.replay is None or arguments.output is None:
        raise ParameterError("edit: needs a log of edits and a file for the result; give --replay LOG and -o FILE")
    before = read_stitches(arguments.fabric)
    after = replay_edits(before, arguments.replay)
    write_stitches(arguments.output, after)
    print(f"{before.face_count} stitches, now {after.face_count}")


def relax_mesh(arguments: Namespace) -> None:
    """Even stitches on the smooth surface."""
    from stitchmesh.meshrelax import relax_mesh_with_report
    from stitchmesh.pipeline import MESH_TOLERANCE, relaxing_progress
    from stitchmesh.progress import on_terminal

    fabric, surface = read_stitches(arguments.fabric), read_stitches(arguments.surface)
    with on_terminal() as progress:
        tell = relaxing_progress("meshrelax", MESH_TOLERANCE, progress)
        relaxed, how = relax_mesh_with_report(fabric, surface=surface, progress=tell)
    write_stitches(arguments.output, relaxed)
    print(f"{how.iterations} iterations, stretch rms {how.rms_stretch:.3f}, at most {how.max_stretch:.3f}")


def yarns(arguments: Namespace) -> None:
    """Yarn curves."""
    finish = dataclasses.asdict(_finish(arguments))
    fabric = read_stitches(arguments.fabric)
    made = generate_yarns(fabric, yarn_radius=arguments.yarn_radius, quality=arguments.quality, **finish)
    write_yarns(arguments.output, made)
    print(f"{made.yarn_count} yarns, {len(made.points)} control points, {made.lengths.sum():.1f} cm")


def relax(arguments: Namespace) -> None:
    """Relaxed yarns."""
    given = read_yarns(arguments.yarns, unit=arguments.unit, radius=arguments.yarn_radius)
    options = _relax_options(arguments, _checkpoint_folder(arguments), _rest_lengths(arguments))
    options = dataclasses.replace(options, constraints=_constraints(arguments))
    check_writable(arguments.output, given)
    shape = arguments.keep_shape or arguments.fabric
    fabric = None if shape is None else read_stitches(shape)
    _relax_to_file(arguments, given, options, fabric=fabric, keep_shape=arguments.keep_shape is not None)


def relax_edited(arguments: Namespace) -> None:
    """Yarns of an edited fabric, relaxed from where those of the fabric before were at rest."""
    finish, quality = dataclasses.asdict(_finish(arguments)), _quality(arguments)
    options = _relax_options(arguments, _checkpoint_folder(arguments), RestLengths())
    rested = read_yarns(arguments.yarns)
    check_writable(arguments.output, rested)
    before, after = read_stitches(arguments.before), read_stitches(arguments.after)
    made, start = regenerate_yarns(rested, before, after, quality=quality, **finish)
    _relax_to_file(arguments, made, options, fabric=after, keep_shape=True, start=start)


def _relax_to_file(
    arguments: Namespace, given: YarnSet, options: RelaxOptions, *, fabric: StitchMesh | None, keep_shape: bool,
    start: YarnSet | None = None,
) -> None:  # fmt: skip
    """Relax yarns and write them; an interrupt leaves the last good state in the output file."""
    from stitchmesh.progress import on_terminal

    output, quality = Path(arguments.output), _quality(arguments)
    last = [start or given]
    with ExitStack() as stack:
        stack.enter_context(output_folder(str(output.parent)))
        folder = None if arguments.report is None else stack.enter_context(output_folder(arguments.report))
        progress = stack.enter_context(on_terminal())
        try:
            relaxed = relax_as_told(
                given, options, quality=quality, device=arguments.device, fabric=fabric, keep_shape=keep_shape,
                start=start, progress=progress, on_state=lambda state: last.__setitem__(0, state),
            )  # fmt: skip
        except KeyboardInterrupt:
            write_yarns(output, last[0])
            if folder is not None:
                write_json(folder / "report.json", {"unfinished": True})
            raise
        write_yarns(output, relaxed.yarns)
        if folder is not None:
            write_json(folder / "report.json", relaxed.report)
            write_history(folder / "convergence.csv", relaxed.history)
            plot_history(relaxed.history, folder, quality)
    print(json.dumps(relaxed.report, indent=2))


def info(arguments: Namespace) -> None:
    """What a file holds."""
    for line in description(_read(arguments)):
        print(line)


def check(arguments: Namespace) -> None:
    """Reading a file validates it."""
    noun = _read(arguments)
    print(f"{arguments.file}: sound {kind_of(noun)}")


def patterns(arguments: Namespace) -> None:
    """The library: what is knitted, then what is woven."""
    from stitchmesh.periodic.weave.library import read_weave, weave_names

    width = max(map(len, (*pattern_names(), *weave_names())))
    print(f"{'name':{width}}    size  yarns  title; source")
    for name in pattern_names():
        found = read_pattern(name)
        size = f"{found.width} x {found.height}"
        print(f"{name:{width}}  {size:>7}  {found.yarn_count:5}  {found.name}; {found.source}")
    for name in weave_names():
        weave = read_weave(name)
        size = f"{len(weave.warps)} x {len(weave.wefts)}"
        print(f"{name:{width}}  {size:>7}  woven  {weave.name}; {weave.source}")


def instructions(arguments: Namespace) -> None:
    """A stitch mesh in words, printed unless a file is named."""
    text = knitting_instructions(read_stitches(arguments.fabric))
    if arguments.output is None:
        print(text, end="")
    else:
        write_text(arguments.output, text)


def convert(arguments: Namespace) -> None:
    """One format to another of the same noun."""
    noun = _read(arguments)
    tiles = None if arguments.tile is None else tuple(arguments.tile)
    if isinstance(noun, YarnSet):
        write_yarns(arguments.output, noun, tiles=tiles)
    elif tiles is not None:
        raise ParameterError(f"tile: {arguments.file} is a {kind_of(noun)}; only yarns that repeat can be tiled")
    elif isinstance(noun, StitchMesh) and suffix_of(arguments.output, (*WRITABLE_STITCHES, ".obj")) != ".obj":
        write_stitches(arguments.output, noun)
    else:
        write_mesh(arguments.output, noun)


def render(arguments: Namespace) -> None:
    """A picture."""
    from stitchmesh.render import render_file

    unit, radius = arguments.unit, arguments.yarn_radius
    render_file(arguments.file, arguments.output, what=arguments.what, unit=unit, radius=radius)


def _read(arguments: Namespace) -> Mesh | YarnSet:
    """What the file of a command holds."""
    return read_any(arguments.file, unit=arguments.unit, radius=arguments.yarn_radius)


def _quality(arguments: Namespace) -> str | Quality:
    """The preset, or what the arguments make of it."""
    return quality_with(arguments.quality, solver=arguments.solver, max_iterations=arguments.max_iterations)


def _finish(arguments: Namespace) -> YarnFinish:
    return YarnFinish(arguments.bind_off, arguments.cast_on, arguments.longest_float)


def _relax_options(arguments: Namespace, checkpoints: Path, rest_lengths: RestLengths) -> RelaxOptions:
    """What the arguments tell the relaxation of yarns; checkpoints, if asked for, go into the folder named."""
    return RelaxOptions(
        material=arguments.material,
        rest_lengths=rest_lengths,
        terms=_terms(arguments),
        checkpoint=_checkpoint(arguments, checkpoints),
        resume=arguments.resume,
    )


def _rest_lengths(arguments: Namespace) -> RestLengths:
    factor, loop_length = arguments.rest_length_factor, arguments.loop_length
    return parse_rest_lengths(arguments.rest_length, factor=factor, loop_length=loop_length)


def _terms(arguments: Namespace) -> list[TermChoice]:
    """The energies asked for; the module of one that is not is not imported."""
    terms: list[TermChoice] = []
    if arguments.gravity is not None:
        from stitchmesh.yarnrelax.energies.gravity import Gravity

        terms.append(Gravity(tuple(arguments.gravity)))
    if arguments.friction is not None:
        from stitchmesh.yarnrelax.energies.friction import Friction

        terms.append(Friction(arguments.friction))
    if arguments.twist is not None:
        from stitchmesh.yarnrelax.energies.twist import Twist

        terms.append(Twist(*arguments.twist))
    if arguments.body is not None:
        from stitchmesh.yarnrelax.energies.body import Body

        terms.append(Body(read_mesh(arguments.body, unit=arguments.body_unit)))
    return terms


def _constraints(arguments: Namespace) -> list[ConstraintChoice]:
    if not (arguments.pin_point or arguments.pin_face):
        return []
    from stitchmesh.yarnrelax.constraints.pins import Pins

    return [Pins(points=arguments.pin_point, faces=arguments.pin_face)]


def _checkpoint_folder(arguments: Namespace) -> Path:
    """Beside the output, in a folder of its name."""
    return Path(arguments.output).with_suffix(".checkpoints")


def _checkpoint(arguments: Namespace, folder: Path) -> Checkpoints | None:
    if arguments.checkpoint_every is None:
        return None
    from stitchmesh.yarnrelax.checkpoint import Checkpoints

    return Checkpoints(folder, arguments.checkpoint_every)
