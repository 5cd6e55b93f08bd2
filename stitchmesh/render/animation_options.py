# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What a run of frames writes beside its animation: the format of the frames, and pictures of them."""

from __future__ import annotations

from dataclasses import dataclass

from stitchmesh.errors import ParameterError
from stitchmesh.settings import check_settings, setting

FRAME_FORMATS = ("bcc", "vtp", "obj", "glb", "usdc")
"""Formats of the yarns of a frame."""


@dataclass(frozen=True, kw_only=True)
class AnimationPictures:
    """Frames, and pictures of them.

    Raises:
        ParameterError: a choice is unknown, or a number is out of its bounds.
    """

    frame_format: str = setting(
        "bcc", f"format of the yarns of each frame: {', '.join(FRAME_FORMATS)}", form="NAME", choices=FRAME_FORMATS,
    )  # fmt: skip
    sheet: bool = setting(False, "also draw frames beside each other, as sheet.png")
    sheet_frames: int = setting(
        12, "largest number of frames on the sheet, evenly spaced in time", form="N", example=12, least=1, most=1000,
        expected="a number of frames",
    )  # fmt: skip
    sheet_columns: int = setting(
        6, "largest number of frames in a row of the sheet", form="N", example=6, least=1, most=100,
        expected="a number of frames",
    )  # fmt: skip
    video: bool = setting(False, "also draw all frames, as video.mp4; needs stitchmesh[video]")
    view: str = setting(
        "front", "view of the pictures: front, back, left, right, top, bottom, or azimuth,elevation in degrees",
        form="VIEW",
    )  # fmt: skip
    picture_size: tuple[int, int] = setting((720, 720), "width and height of the pictures [pixels]", form="W H")

    def __post_init__(self) -> None:
        check_settings(self)
        width, height = self.picture_size
        if self.video and (width % 2 or height % 2):
            raise ParameterError(f"picture size: got {width} x {height}; a video has even numbers of pixels")
