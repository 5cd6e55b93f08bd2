# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What each command of the command line does."""

from __future__ import annotations

import json
import sys
from argparse import Namespace
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from stitchmesh.errors import DisplayError, FileError
from stitchmesh.io import read_mesh, read_stitches, read_yarns, write_mesh, write_stitches, write_yarns
from stitchmesh.io.any_file import read_any
from stitchmesh.labeling import label as label_mesh
from stitchmesh.mesh import Mesh, StitchMesh
from stitchmesh.pipeline import KnitOptions, stitch_counts
from stitchmesh.pipeline import knit as knit_mesh
from stitchmesh.tessellate import tessellate as tessellate_mesh
from stitchmesh.yarn import YarnSet
from stitchmesh.yarngen import generate_yarns


def knit(arguments: Namespace) -> None:
    """The whole line, with a picture at the end."""
    from stitchmesh.progress import on_terminal

    options = KnitOptions(
        stitch_width=arguments.stitch_width,
        yarn_radius=arguments.yarn_radius,
        quality=arguments.quality,
        device=arguments.device,
        seeds=arguments.seed,
        flip=arguments.flip,
    )
    with _output_folder(arguments.output) as folder:
        mesh = read_mesh(arguments.mesh, unit=arguments.unit)
        with on_terminal() as progress:
            made = knit_mesh(mesh, folder, options, progress=progress)
    if not arguments.no_picture:
        _preview(made.yarns, folder / "preview.png")
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
    fabric = read_stitches(arguments.fabric)
    made = generate_yarns(fabric, yarn_radius=arguments.yarn_radius, quality=arguments.quality)
    write_yarns(arguments.output, made)
    print(f"{made.yarn_count} yarns, {len(made.points)} control points, {made.lengths.sum():.1f} cm")


def relax(arguments: Namespace) -> None:
    """Relaxed yarns; an interrupt leaves the last good state in the output file."""
    from stitchmesh.pipeline import relaxing_progress
    from stitchmesh.progress import on_terminal
    from stitchmesh.quality import quality_named
    from stitchmesh.yarnrelax import relax_yarns

    given = read_yarns(arguments.yarns, unit=arguments.unit, radius=arguments.yarn_radius)
    shape = None if arguments.keep_shape is None else read_stitches(arguments.keep_shape)
    quality = quality_named(arguments.quality)
    last = [given]
    try:
        with on_terminal() as progress:
            tell = relaxing_progress("yarnrelax", quality.tolerance, progress)
            relaxed = relax_yarns(
                given, quality=quality, device=arguments.device, keep_shape=shape, progress=tell,
                on_state=lambda state: last.__setitem__(0, state),
            )  # fmt: skip
    except KeyboardInterrupt:
        write_yarns(arguments.output, last[0])
        raise
    write_yarns(arguments.output, relaxed.yarns)
    print(json.dumps(relaxed.report, indent=2))


def info(arguments: Namespace) -> None:
    """What a file holds."""
    for line in _describe(read_any(arguments.file, unit=arguments.unit)):
        print(line)


def check(arguments: Namespace) -> None:
    """Reading a file validates it."""
    noun = read_any(arguments.file, unit=arguments.unit)
    print(f"{arguments.file}: sound {_kind(noun)}")


def convert(arguments: Namespace) -> None:
    """One format to another of the same noun."""
    noun = read_any(arguments.file, unit=arguments.unit)
    if isinstance(noun, YarnSet):
        write_yarns(arguments.output, noun)
    elif isinstance(noun, StitchMesh) and Path(arguments.output).suffix == ".h5":
        write_stitches(arguments.output, noun)
    else:
        write_mesh(arguments.output, noun)


def render(arguments: Namespace) -> None:
    """A picture."""
    from stitchmesh.viewer import render_file

    render_file(arguments.file, arguments.output, what=arguments.what, unit=arguments.unit)


def _preview(made: YarnSet, path: Path) -> None:
    """The picture of a run; a machine that cannot draw keeps its yarns and is told what it lacks."""
    from stitchmesh.viewer import render_yarns

    try:
        render_yarns(made, path)
    except DisplayError as error:
        print(f"no picture: {error}", file=sys.stderr)


@contextmanager
def _output_folder(name: str) -> Iterator[Path]:
    """The output folder, made before hours of work, so that they do not end at a closed door.

    Where the work is refused, a folder that was made for it and is still empty goes again.
    """
    folder = Path(name)
    made = not folder.exists()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        probe = folder / ".stitchmesh-probe"
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise FileError(f"{name}: cannot be written ({error.strerror}); choose another output folder") from error
    try:
        yield folder
    finally:
        if made and not any(folder.iterdir()):
            folder.rmdir()


def _kind(noun: Mesh | YarnSet) -> str:
    return {YarnSet: "yarns", StitchMesh: "stitch mesh", Mesh: "polygon mesh"}[type(noun)]


def _describe(noun: Mesh | YarnSet) -> list[str]:
    if isinstance(noun, YarnSet):
        return [
            f"yarns: {noun.yarn_count} ({int(noun.closed.sum())} closed)",
            f"control points: {len(noun.points)}",
            f"length: {noun.lengths.sum():.2f} cm",
            f"radius: {noun.radius.min():.4g} to {noun.radius.max():.4g} cm",
            f"strain: {noun.strain.min():.3%} to {noun.strain.max():.3%}",
            *_extent(noun.points),
        ]
    lines = [
        f"{_kind(noun)}: {noun.face_count} faces, {len(noun.vertices)} vertices, {len(noun.edge_side)} edges",
        f"borders: {len(noun.boundary_loops)}",
        f"area: {np.linalg.norm(noun.face_vector_area, axis=1).sum():.2f} cm2",
        *_extent(noun.vertices),
    ]
    if isinstance(noun, StitchMesh):
        lines.append(f"rows: {noun.row.max() + 1}")
        lines += [f"{name}: {count}" for name, count in stitch_counts(noun).items() if name != "faces"]
    return lines


def _extent(points: np.ndarray) -> list[str]:
    size = points.max(axis=0) - points.min(axis=0)
    return [f"extent: {size[0]:.2f} x {size[1]:.2f} x {size[2]:.2f} cm"]
