# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``yarns``."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from typing import Annotated

from tyro.conf import Positional, UseAppendAction

from stitchmesh.cli.options import (
    READ_STITCHES,
    WRITTEN_YARNS,
    DrawnRadius,
    Overwrite,
    QualityName,
    YarnName,
    YarnRadius,
)
from stitchmesh.cli.say import say
from stitchmesh.cli.words import help_entry
from stitchmesh.quality import DEFAULT_QUALITY
from stitchmesh.yarn.stitch_size import stitch_size
from stitchmesh.yarngen.finish import YarnFinish


@dataclass(frozen=True)
class Yarns:
    """Generate yarn curves from a stitch mesh."""

    fabric: Annotated[Positional[str], help_entry("FABRIC", help=READ_STITCHES)]
    output: Annotated[str, help_entry("FILE", short="-o", help=WRITTEN_YARNS)]
    yarn: YarnName = None
    yarn_radius: YarnRadius = None
    drawn_radius: DrawnRadius = None
    faces: Annotated[UseAppendAction[tuple[str, ...]], help_entry("SF", "none")] = ()
    """library of drawn faces (.sf), for the faces of an .smobj file that are no stitches; may be repeated"""
    quality: QualityName = DEFAULT_QUALITY
    finish: YarnFinish = field(default_factory=YarnFinish)
    overwrite: Overwrite = False

    def run(self) -> None:
        """Generate the yarns, and write them."""
        from stitchmesh.io import read_stitches, write_yarns
        from stitchmesh.io.contents import suffix_of
        from stitchmesh.io.stitch_formats.face_libraries import read_face_libraries
        from stitchmesh.io.stitch_formats.face_meshes import holds_foreign_faces, read_face_mesh
        from stitchmesh.io.stitches import READABLE
        from stitchmesh.yarngen import generate_yarns
        from stitchmesh.yarngen.face_yarns.generate import face_yarns

        size = stitch_size(self.yarn, yarn_radius=self.yarn_radius, drawn_radius=self.drawn_radius)
        if self.faces or (suffix_of(self.fabric, READABLE) == ".smobj" and holds_foreign_faces(self.fabric)):
            library = read_face_libraries(self.faces)
            yarns = face_yarns(
                read_face_mesh(self.fabric), library, yarn_radius=size.yarn_radius, quality=self.quality
            ).yarns
        else:
            yarns = generate_yarns(
                read_stitches(self.fabric), yarn_radius=size.yarn_radius, drawn_radius=size.drawn_radius,
                mass_per_length=size.mass_per_length, quality=self.quality, **asdict(self.finish),
            )  # fmt: skip
        write_yarns(self.output, yarns)
        say(f"{yarns.yarn_count} yarns, {len(yarns.points)} control points, {yarns.lengths.sum():.1f} cm")
