# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The options of a picture that a user can choose, besides the object."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import FloatArray, Mesh, StitchMesh
from stitchmesh.mesh.palette import parse_colour
from stitchmesh.render.close_up import CloseUpTarget, place_of
from stitchmesh.render.view import View, view_angles
from stitchmesh.yarn.yarn_look import YarnLook

Size = tuple[int, int]
"""Width and height [pixels]."""
PICTURE_SIZE: Size = (1600, 1000)
"""Default size of a picture."""
LARGEST = 16_384
"""Largest width or height of a picture [pixels]; graphics processors hold no window larger than twice this."""
TRANSPARENT = "transparent"
"""The background through which a page shows."""
MOST_COLOURS = 256
"""Largest number of colours of a picture with a palette."""


@dataclass(frozen=True, kw_only=True, eq=False)
class PictureOptions:
    """Options of a picture.

    Raises:
        ParameterError: a size, a view, a place, a colour or a number is not possible.
    """

    size: Size = PICTURE_SIZE
    """Width and height [pixels]."""
    view: View | None = None
    """Direction of the camera (``view.VIEWS``); the front by default, and the outward normal in a close-up."""
    close_up: str | int | Iterable[int] | None = None
    """Place that the picture shows; the whole object by default. A text is ``face 120``, ``row 12``, ``point X Y Z``
    [cm], ``share U V`` of the picture of the whole object, or a selection if a stitch mesh is given; numbers are faces.
    """
    extent: float | None = None
    """Width of the region of a close-up [cm]; about twelve stitches by default."""
    inset: bool = True
    """Whether a picture of whole yarns from the front also has a close-up of some stitches."""
    colour: str | None = None
    """``yarn``, ``row``, ``stitch``, ``strain``, ``stretch``, ``contact``, ``distance``, ``body-distance``, or one
    colour; for a stitch mesh also ``irregular``. Yarns have their own colours by default."""
    blend: float = 1.0
    """Weight of the colours of rows or stitches against the colours of the yarns, from 0 to 1."""
    background: str | None = None
    """``transparent`` or a colour; a pale gradient by default."""
    body: Mesh | None = None
    """A body that the picture shows too."""
    fabric: StitchMesh | None = None
    """The stitch mesh of yarns, for colours by stitch and close-ups of a selection."""
    look: str | YarnLook | None = None
    """How yarns look, or the name of a look; by default the look of the yarn, or like wool if it is not known."""
    occlusion: bool = True
    """Whether surfaces hide light from each other: hollows are darker, and the key light throws shadows."""
    scale_bar: bool = True
    """Whether the picture has a scale bar; a picture that is too small for it has none."""
    framed: FloatArray | None = None
    """Points that a picture of whole yarns shows [cm], shape (n, 3), such as those of all frames of an animation; those
    of the yarns and of the body by default."""
    colours: int | None = None
    """Number of different colours; a small file needs few. All by default."""

    def __post_init__(self) -> None:
        if len(self.size) != 2 or not all(
            isinstance(side, int | np.integer) and 1 <= side <= LARGEST for side in self.size
        ):
            found = " x ".join(str(side) for side in self.size)
            raise ParameterError(f"size: got {found}; expected width and height from 1 to {LARGEST} pixels")
        if self.view is not None:
            view_angles(self.view)
        if self.extent is not None and not (np.isfinite(self.extent) and self.extent > 0.0):
            raise ParameterError(f"extent: got {self.extent:g} cm; expected a positive number")
        if self.extent is not None and self.close_up is None:
            raise ParameterError("extent: got the width of a close-up without a close-up; give its place too")
        if self.background not in (None, TRANSPARENT):
            try:
                parse_colour(self.background)
            except ParameterError as error:
                raise ParameterError(f"background: {error}; or {TRANSPARENT}") from None
        if isinstance(self.look, str):
            YarnLook(self.look)
        if self.colours is not None and not 2 <= self.colours <= MOST_COLOURS:
            raise ParameterError(f"colours: got {self.colours}; expected 2 to {MOST_COLOURS}")

    @property
    def place(self) -> CloseUpTarget | None:
        """The place of the close-up; None for a picture of the whole object."""
        return None if self.close_up is None else place_of(self.close_up)

    @property
    def aspect(self) -> float:
        """Width of the picture over its height."""
        return self.size[0] / self.size[1]


DEFAULTS = PictureOptions()
"""The options of a picture if the user chooses nothing."""
