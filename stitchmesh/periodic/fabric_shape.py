# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Whether a swatch lies flat, folds or is crumpled, from the places of its yarns.

A fabric that lies flat is as thick as its stitches need. The generated yarns show this: they lie in one plane, with
their loops, cables, floats, slips and decreases on one another (plain loops are 2.2 yarn diameters thick, a cable 3.7).
A fabric with both knit and purl stitches has loops on both sides of the links between them and is one layer of plain
loops thicker (``LAYER``): ribs, garter and seed stitch are nearly twice as thick as stockinette, as measured fabrics
are. The sum is the flat thickness. The layers of a weave are generated so that they nest; each is at least two
diameters thick.

The middle surface of the fabric has a node for each stitch: the mean of the control points of its face. With r the
vector from a node to the next one in its row, u the vector to a node above, e1, e2 and n the frame of the lattice and A
the area of the cell, sums over all top sides of faces are

    course fold = sum |r| / sum r . e1        wale fold = sum |u| / sum u . e2        layers = sum |n . (r x u)| / A

each over its value for the generated yarns. They are 1 in a flat fabric. Along a direction in which the fabric folds,
the surface is longer than its projection. Where courses or columns lie behind others, parts of the surface are turned
over, and more than one layer covers the plane.

A fabric whose thickness is at most ``THICK`` flat thicknesses is flat: there is no room for a fold, which has two
layers. Otherwise it is crumpled if it folds along both directions (``FOLD``), and folded if along one only. A weave
that is not flat is folded; its middle surface is not measured.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, Literal

import numpy as np

from stitchmesh.lattice import Lattice, lattice_frame
from stitchmesh.mesh import TOP, FloatArray, IntArray, StitchMesh
from stitchmesh.periodic.resolve_pattern import Source
from stitchmesh.periodic.weave.weave import Weave
from stitchmesh.yarn import FLOATING, YarnSet

Shape = Literal["flat", "folded", "crumpled"]

SAMPLES = 8
"""Points of each segment at which the thickness is measured."""
LAYER = 2.25
"""Thickness of a layer of plain loops [yarn diameters]; loops of stockinette at rest have 2.24 to 2.30."""
RARE = 0.1
"""Share of the yarn that may lie beyond the planes of a free cell: yarn of the thickest stitches of lace and cables."""
THICK = 1.5
"""A fabric is flat up to this ratio of its thickness to its flat thickness. No pattern of the library has more than 1.4
where it lies between the planes of a free cell (``support``), and the thinnest fold has two layers."""
FOLD = 1.25
"""A fabric folds from this ratio of the length of its middle surface to its projection: the mean slope is then 37
degrees."""


@dataclass(frozen=True)
class FabricShape:
    """The shape of a fabric: flat, folded or crumpled."""

    thickness_ratio: float
    """Thickness over flat thickness."""
    course_fold: float = 1.0
    """Length of the middle surface along the courses over the length of its projection."""
    wale_fold: float = 1.0
    """Length of the middle surface along the wales over the length of its projection."""
    layers: float = 1.0
    """How many layers of the middle surface cover the plane."""

    @property
    def name(self) -> Shape:
        """``flat``, ``folded`` or ``crumpled``."""
        if self.thickness_ratio <= THICK:
            return "flat"
        return "crumpled" if min(self.course_fold, self.wale_fold) >= FOLD else "folded"

    def report(self) -> dict[str, Any]:
        """Return shape, thickness_ratio, course_fold, wale_fold and layers."""
        return {"shape": self.name} | asdict(self)

    @property
    def text(self) -> str:
        """The finding in words."""
        thick = f"{self.thickness_ratio:.2g} times as thick as its stitches need"
        folds = {"course": self.course_fold, "wale": self.wale_fold}
        most = max(folds, key=lambda name: folds[name])
        return f"the fabric is {self.name}: {thick}, and {folds[most]:.2g} times as long along the {most}s as it seems"


@dataclass(frozen=True, eq=False)
class FlatFabric:
    """The shape of a fabric as it is generated, where it lies flat."""

    diameters: float
    """Flat thickness [yarn diameters]."""
    common: float
    """Thickness of the fabric without its few thickest stitches, such as decreases and cables [yarn diameters]."""
    stitch_length: float
    """Mean length of yarn in a stitch, or at a crossing of a weave [cm]."""
    fabric: StitchMesh | None
    """The stitch mesh; None for a weave, where only the thickness is compared."""
    image: IntArray
    """Lattice image of each control point relative to the face of its stitch, shape (N, 2)."""
    folds: tuple[float, float, float]
    """Course fold, wale fold and layers of the generated yarns; the values of other yarns are divided by them."""

    @classmethod
    def of(cls, drawn: YarnSet, fabric: StitchMesh | None, source: Source) -> FlatFabric:
        """Measure generated yarns.

        Args:
            drawn: the yarns on their lattice, as they are generated.
            fabric: the stitch mesh of a knit; None for a weave.
            source: the pattern or the weave.
        """
        length = float(drawn.rest_length.sum())
        diameter = 2.0 * float(drawn.radius.mean())
        heights = _heights(drawn)
        diameters, common = _thickness(heights, drawn) / diameter, _common_thickness(heights, drawn) / diameter
        if fabric is None:
            crossings = int(np.prod((drawn.lattice_step != 0).sum(axis=0))) if drawn.lattice_step is not None else 1
            layers = source.layer_count if isinstance(source, Weave) else 1
            image = np.zeros((len(drawn.points), 2), dtype=np.int64)
            # Thickness of a layer of plain cloth [yarn diameters]: one yarn passes over another.
            least = 2.0 * layers
            return cls(max(diameters, least), max(diameters, least), length / crossings, None, image, (1.0, 1.0, 1.0))
        image = _images(drawn, fabric)
        more = LAYER * _has_two_faces(fabric)
        common = max(common, min(diameters, LAYER)) + more
        diameters += more
        # Where most of a fabric is thinner than this share of its thickest stitches, these stitches are exceptions
        common = common if common < 0.85 * diameters else diameters
        return cls(diameters, common, length / fabric.face_count, fabric, image, _folds(drawn, fabric, image))

    def thickness(self, yarns: YarnSet) -> float:
        """Flat thickness of yarns with other radii [cm]."""
        return self.diameters * 2.0 * float(yarns.radius.mean())

    def shape_of(self, yarns: YarnSet) -> FabricShape:
        """Compare the relaxed yarns, on their lattice, with the generated yarns."""
        ratio = thickness_of(yarns) / self.thickness(yarns)
        if self.fabric is None:
            return FabricShape(ratio)
        now = _folds(yarns, self.fabric, self.image)
        return FabricShape(ratio, *(new / old for new, old in zip(now, self.folds, strict=True)))


def thickness_of(yarns: YarnSet) -> float:
    """Return the extent of yarns on a lattice along the normal of the fabric, at the contact radius [cm]."""
    return _thickness(_heights(yarns), yarns)


def _heights(yarns: YarnSet) -> list[FloatArray]:
    """Return how far samples of each yarn lie out along the normal of the fabric [cm]."""
    assert yarns.lattice is not None
    curves = yarns.sampled(SAMPLES)
    out = np.concatenate(curves) @ lattice_frame(yarns.lattice.periods)[2]
    return np.split(out, np.cumsum([len(curve) for curve in curves])[:-1])


def _thickness(heights: list[FloatArray], yarns: YarnSet) -> float:
    """Return the extent of yarns along the normal at the contact radius [cm], from their heights."""
    out, radius = np.concatenate(heights), np.repeat(yarns.radius, [len(each) for each in heights])
    return float((out + radius).max() - (out - radius).min())


def _common_thickness(heights: list[FloatArray], yarns: YarnSet) -> float:
    """Return the distance of two planes [cm]; only ``RARE`` of the yarn lies outside, both sides together."""
    low, high = np.quantile(np.concatenate(heights), [RARE / 2.0, 1.0 - RARE / 2.0])
    return float(high - low + 2.0 * yarns.radius.mean())


def _has_two_faces(fabric: StitchMesh) -> bool:
    """Return whether a fabric makes both knit and purl loops."""
    used = set(np.unique(fabric.stitch).tolist())
    made = {kind for code, making in fabric.makings.items() if code in used for kind in making.made}
    return {"k", "p"} <= made


def _images(drawn: YarnSet, fabric: StitchMesh) -> IntArray:
    """Return the lattice image of each control point relative to its face, shape (N, 2).

    All consecutive control points of a face lie in one image: the image in which their middle is nearest to the face.
    """
    assert fabric.lattice is not None
    begins = np.concatenate([[True], drawn.face[1:] != drawn.face[:-1]])
    begins[drawn.start[:-1]] = True
    run = np.cumsum(begins) - 1
    middle = _means(drawn.points, run, run[-1] + 1)
    centre = np.add.reduceat(fabric.corner_position, fabric.face_start[:-1], axis=0)
    centre = centre / np.diff(fabric.face_start)[:, None]
    away = (middle - centre[drawn.face[begins]]) @ np.linalg.pinv(fabric.lattice.periods)
    image: IntArray = np.rint(away).astype(np.int64)[run]
    return image


def _folds(yarns: YarnSet, fabric: StitchMesh, image: IntArray) -> tuple[float, float, float]:
    """Return course fold, wale fold and layers of yarns; floats do not count."""
    assert yarns.lattice is not None
    own = (yarns.face >= 0) & (yarns.part != FLOATING)
    places = yarns.points - yarns.lattice.shift(image)
    node = _means(places[own], yarns.face[own], fabric.face_count)
    top = np.flatnonzero(fabric.side_role == TOP)
    up = _to_neighbours(fabric, node, yarns.lattice, top)
    along = _to_neighbours(fabric, node, yarns.lattice, fabric.right_wale[fabric.side_face[top]])
    known = np.isfinite(up + along).all(axis=1)
    up, along = up[known], along[known]
    e1, e2, normal = lattice_frame(yarns.lattice.periods)
    layers = np.abs(np.cross(along, up) @ normal).sum() / yarns.lattice.area
    return _excess(along, e1), _excess(up, e2), float(layers)


def _to_neighbours(fabric: StitchMesh, node: FloatArray, lattice: Lattice, sides: IntArray) -> FloatArray:
    """Return the vector from the node of each side's face to the node across the side [cm], shape (n, 3)."""
    across = node[fabric.side_face[fabric.twin[sides]]] + lattice.shift(fabric.side_image[sides])
    return across - node[fabric.side_face[sides]]


def _excess(steps: FloatArray, direction: FloatArray) -> float:
    """Return the length of steps over the length that they advance in a direction."""
    return float(np.linalg.norm(steps, axis=1).sum() / np.abs((steps @ direction).sum()))


def _means(values: FloatArray, group: IntArray, count: int) -> FloatArray:
    """Return the mean of the rows of each group, NaN for a group without rows, shape (count, 3)."""
    size = np.bincount(group, minlength=count).astype(np.float64)
    sums = np.stack([np.bincount(group, column, minlength=count) for column in values.T], axis=1)
    return np.divide(sums, size[:, None], out=np.full_like(sums, np.nan), where=size[:, None] > 0.0)
