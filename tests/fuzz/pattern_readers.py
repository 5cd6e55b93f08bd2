# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The readers of patterns, charts, weaves and drawings of stitches, each with small undamaged files."""

from __future__ import annotations

import io
from functools import partial
from pathlib import Path

import numpy as np

import stitchmesh as sm
from stitchmesh.errors import FileError, ParameterError, PatternError
from stitchmesh.patterns.charts.leaf_chart import write_leaf_chart
from tests.fuzz import mutations as damage
from tests.fuzz.reader import Reader, files, later, written
from tests.fuzz.structures import JSON, PNG


def _png(folder: Path) -> list[bytes]:
    """Return charts as pictures: with a palette, in true colours, interlaced, with text, and small ones."""
    from PIL import Image, PngImagePlugin

    pixels = np.array([[0, 1, 0, 1], [1, 0, 1, 0], [0, 0, 1, 1]], np.uint8)
    palette = Image.fromarray(pixels, "P")
    palette.putpalette([255, 255, 255, 40, 40, 40])
    text = PngImagePlugin.PngInfo()
    text.add_text("stitchmesh chart", "row 1: K P", zip=True)
    found = []
    deep = Image.fromarray(pixels.astype(np.uint16) * 40_000)
    modes = [palette, *(palette.convert(mode) for mode in ("RGB", "RGBA", "1", "LA")), deep]
    for image in modes:
        content, options = io.BytesIO(), {"pnginfo": text} if image.mode == "RGB" else {}
        image.save(content, format="PNG", **options)
        found.append(content.getvalue())
    return found


def _other_image(suffix: str) -> Reader:
    def seeds(folder: Path) -> list[bytes]:
        """Return a chart as a picture with a palette, in true colours and in greys."""
        from PIL import Image

        first = Image.open(io.BytesIO(_png(folder)[0]))
        for number, mode in enumerate(("P", "RGB", "L")):
            first.convert(mode).save(folder / f"seed{number}{suffix}")
        return [(folder / f"seed{number}{suffix}").read_bytes() for number in range(3)]

    return Reader(suffix, _read_other_image, seeds, damage.BINARY, has_own_process=True)


def _read_other_image(path: Path) -> object:
    """Do in this process what ``read_other_image`` does in a child, whose start takes longer than the reading."""
    from stitchmesh.patterns.charts.other_images import packed_image

    return packed_image(str(path), path)


def _drafts(folder: Path) -> list[bytes]:
    from tests.periodic.weave.test_wif import TWILL

    colours = "[COLOR TABLE]\n1=20,30,90\n2=240,230,210\n[WARP COLORS]\n1=1\n2=2\n[WEFT COLORS]\n1=2\n"
    return [TWILL.encode(), (TWILL.replace("[TIEUP]", "[LIFTPLAN]") + colours).encode()]


def _leaf_png(folder: Path) -> list[bytes]:
    """Return tile codes as a picture."""
    pattern = sm.resolve_pattern("rib2x2")
    return written(write_leaf_chart, pattern, suffix=".png")(folder)


def _instructions(folder: Path) -> list[bytes]:
    from stitchmesh.patterns import pattern_mesh, read_pattern

    names = ("rope-cable", "eyelet-lace", "twisted-rib")
    pieces = (pattern_mesh(read_pattern(name), 2, 2, stitch_width=1.0, stitch_height=1.0) for name in names)
    return [sm.knitting_instructions(piece).encode() for piece in pieces]


def _graded_instructions(folder: Path) -> list[bytes]:
    """Return instructions of two sizes."""
    from stitchmesh.patterns import pattern_mesh, read_pattern

    pieces = {
        size: pattern_mesh(read_pattern("eyelet-lace"), width, height, stitch_width=1.0, stitch_height=1.0)
        for size, width, height in (("S", 2, 2), ("M", 3, 3))
    }
    return [sm.graded_instructions(pieces, ["Finished measures: chest 92.5 (100.0) cm."]).encode()]


def _read_second_size(path: Path) -> object:
    return sm.parse_instructions(path.read_text(encoding="utf-8", errors="replace"), size="M")


def read_chart(name: str, path: Path) -> object:
    return sm.read_chart(name, path.read_bytes())


PATTERN_ERRORS = (FileError, PatternError, ParameterError)
"""Errors of charts: a chart that is too large is a ``ParameterError``."""
RESOLVED = later("stitchmesh.resolve_pattern")
PATTERNS = [f"assets/patterns/{name}.knit" for name in ("rib2x2", "eyelet-lace", "seed")]
WEAVES = [f"assets/patterns/{name}.weave" for name in ("satin-2x3", "double-plain-stitched", "orthogonal-interlock")]

PATTERN_READERS: dict[str, Reader] = {
    "pattern": Reader(".knit", RESOLVED, files(*PATTERNS), errors=PATTERN_ERRORS),
    "chart": Reader(".knit", partial(read_chart, "chart.knit"), files(*PATTERNS), errors=PATTERN_ERRORS),
    "chart text": Reader(".txt", partial(read_chart, "chart.txt"), lambda folder: [b"KPKP\nPKPK\n", b"0011\n1100\n"],
                         errors=PATTERN_ERRORS),
    "weave": Reader(".weave", RESOLVED, files(*WEAVES), errors=PATTERN_ERRORS),
    "weave chart": Reader(".weave", partial(read_chart, "chart.weave"), files(*WEAVES), errors=PATTERN_ERRORS),
    "wif": Reader(".wif", RESOLVED, _drafts, errors=PATTERN_ERRORS),
    "gif chart": _other_image(".gif"),
    "bmp chart": _other_image(".bmp"),
    "tif chart": _other_image(".tif"),
    "png chart": Reader(".png", partial(read_chart, "chart.png"), _png, PNG, PATTERN_ERRORS),
    "png weave": Reader(".weave.png", RESOLVED, _png, PNG, PATTERN_ERRORS),
    "own stitches": Reader(".json", later("stitchmesh.io.own_stitches.read_own_drawings"),
                           files("examples/stitches/daisy.json"), JSON),
    "instructions": Reader(".txt", RESOLVED, _instructions, errors=PATTERN_ERRORS),
    "graded instructions": Reader(".txt", _read_second_size, _graded_instructions, errors=PATTERN_ERRORS),
    "tile codes": Reader(".leaf", RESOLVED, lambda folder: [b"KPKP\nPKPK\n", b"Y3YK\n2UYS\n"], errors=PATTERN_ERRORS),
    "digits": Reader(".txt", RESOLVED, lambda folder: [b"0011\n1100\n"], errors=PATTERN_ERRORS),
    "png tile codes": Reader(".leaf.png", RESOLVED, _leaf_png, PNG, PATTERN_ERRORS),
}  # fmt: skip
"""Readers by name."""
