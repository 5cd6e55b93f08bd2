# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Pictures of yarns that move with a body or a cloth: frames beside each other as one picture, and a video.

The camera goes along with the middle of the body or of the cloth, and shows as much around it as all frames need; what
moves within the picture is what moves beside this middle. Frames are drawn one by one.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from importlib.util import find_spec
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np

from stitchmesh.errors import DisplayError, FileError
from stitchmesh.io.atomic import atomic_path
from stitchmesh.io.contents import FilePath
from stitchmesh.mesh import FloatArray
from stitchmesh.mesh.vertex_motion import MovingMesh
from stitchmesh.progress import Progress, shown_stages
from stitchmesh.render.animation_options import AnimationPictures
from stitchmesh.render.gl_probe import check_display
from stitchmesh.render.options import PictureOptions
from stitchmesh.render.picture import render_yarns
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.frame_run import YarnFrame

if TYPE_CHECKING:
    from PIL import Image

SHEET, VIDEO = "sheet.png", "video.mp4"
"""Names in the output folder."""
SMALLER = 3
"""How much smaller a frame is on a sheet than it is drawn, because yarns are finer than a pixel there."""
ENCODER = "imageio_ffmpeg"


def picture_names(pictures: AnimationPictures) -> list[str]:
    """Return the names of the pictures that will be made, and check that this machine can make them.

    Raises:
        DisplayError: this machine cannot draw pictures, or has no program that writes videos.
    """
    names = [SHEET] * pictures.sheet + [VIDEO] * pictures.video
    if pictures.video and find_spec(ENCODER) is None:
        raise DisplayError("video: ffmpeg is not installed; install it by `pip install stitchmesh[video]`")
    if names:
        check_display()
    return names


def draw_animation(
    frames: Iterable[YarnFrame],
    moving: MovingMesh,
    folder: FilePath,
    pictures: AnimationPictures,
    *,
    body: bool = False,
    progress: Progress | Literal[False] | None = None,
) -> None:
    """Draw frames of yarns as ``sheet.png`` and ``video.mp4`` in a folder, as far as they are chosen.

    Args:
        frames: the frames, such as those of ``FollowFiles.frames``; they are read once, one by one.
        moving: the body or the cloth.
        folder: where the pictures are written.
        pictures: which pictures are drawn, and how.
        body: whether the pictures show the body or the cloth too.
        progress: function that is called for each frame; None for one line on a terminal, False for nothing.

    Raises:
        DisplayError: this machine cannot draw pictures, or has no program that writes videos.
        ParameterError: the view is unknown, or the size is not possible.
        FileError: a file cannot be written, or the file of a frame is missing.
    """
    if not picture_names(pictures):
        return
    count, stills = len(moving.motion.times), []
    on_sheet = np.linspace(0, count - 1, min(count, pictures.sheet_frames)).round().astype(int).tolist()
    around = _extent(moving.motion.vertices)
    with ExitStack() as stack:
        report, send = stack.enter_context(shown_stages(progress)), None
        if pictures.video:
            video = Path(folder) / VIDEO
            send = stack.enter_context(_video(video, pictures.picture_size, moving.motion.frames_per_second))
        for frame in frames:
            chosen = pictures.sheet and frame.number in on_sheet
            if send is None and not chosen:
                continue
            vertices = moving.motion.vertices[frame.number]
            options = PictureOptions(
                size=pictures.picture_size, view=pictures.view, inset=False, framed=vertices.mean(axis=0) + around,
                body=replace(moving.mesh, vertices=vertices) if body else None,
            )  # fmt: skip
            image = _drawn(frame.yarns, options)
            report("pictures", (frame.number + 1) / count, f"frame {frame.number} of {count - 1}")
            if send is not None:
                send(image)
            if chosen:
                stills.append(image.reduce(SMALLER))
    if pictures.sheet:
        with atomic_path(Path(folder) / SHEET) as temporary:
            joined(stills, pictures.sheet_columns).save(temporary, optimize=True)


def _extent(frames: FloatArray) -> FloatArray:
    """Return the corners of the box around all frames, each beside its own middle, shape (8, 3)."""
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for vertices in frames:
        beside = vertices - vertices.mean(axis=0)
        low, high = np.minimum(low, beside.min(axis=0)), np.maximum(high, beside.max(axis=0))
    return np.array(list(product(*np.stack([low, high], axis=1))))


def _drawn(yarns: YarnSet, options: PictureOptions) -> Image.Image:
    from PIL import Image

    with tempfile.TemporaryDirectory(prefix="stitchmesh-") as folder:
        path = Path(folder) / "frame.png"
        render_yarns(yarns, path, options)
        return Image.open(path).convert("RGB")


def joined(pictures: Sequence[Image.Image], most: int) -> Image.Image:
    """Return pictures of one size beside each other, in rows of a largest number of pictures."""
    from PIL import Image

    columns = min(len(pictures), most)
    width, height = pictures[0].size
    sheet = Image.new("RGB", (columns * width, -(-len(pictures) // columns) * height), "white")
    for place, picture in enumerate(pictures):
        sheet.paste(picture, (width * (place % columns), height * (place // columns)))
    return sheet


@contextmanager
def _video(path: Path, size: tuple[int, int], frames_per_second: float) -> Iterator[Callable[[Image.Image], None]]:
    """Provide the function that adds a frame; the video is written after the block.

    Raises:
        FileError: the file cannot be written.
    """
    import imageio_ffmpeg

    with atomic_path(path) as temporary:
        writer = imageio_ffmpeg.write_frames(
            str(temporary), size, fps=frames_per_second, quality=8, macro_block_size=2, ffmpeg_log_level="error"
        )

        def add(image: Image.Image) -> None:
            try:
                writer.send(image.tobytes())
            except OSError as error:  # The program ended.
                reason = " ".join(str(error).split())[:100]
                raise FileError(f"{path}: cannot be written ({reason}); free space there") from error

        writer.send(None)
        try:
            yield add
        finally:
            writer.close()
