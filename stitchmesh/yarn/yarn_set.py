# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarns as uniform cubic B-splines.

Segment ``i`` of a yarn with control points q runs over s in [0, 1] and is

    y(s) = [(1-s)^3 q_i + (3s^3-6s^2+4) q_(i+1) + (-3s^3+3s^2+3s+1) q_(i+2) + s^3 q_(i+3)] / 6

A closed yarn of n control points has n segments, an open yarn n - 3. Segment ``i`` begins near control point i + 1 and
ends near control point i + 2. A quantity that is given per control point, such as the natural curvature, has the values
of these two points at the ends of the segment and is linear in between.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stitchmesh.compute.threads import each_block
from stitchmesh.errors import YarnError, first_few
from stitchmesh.lattice import LARGEST_LENGTH, Lattice
from stitchmesh.mesh import FloatArray, IntArray, extent, frozen_array
from stitchmesh.mesh.palette import Palette, checked_palette, empty_palette
from stitchmesh.yarn.yarn_presets import Yarn

UNKNOWN_FACE = -1
"""Stitch face of a control point that no stitch made."""

FLOATING = -1
"""Part of control points of a float behind stitches of other yarns; their face is the stitch that the float leaves."""

APPARENT_OVER_CONTACT = 1.7
"""Apparent radius over contact radius of knitting yarn. At the gauges of the standard yarn weights the wale spacing is
4.3 to 5 apparent radii, and 8.2 contact radii in loops of incompressible yarn (Peirce's compact loop), because soft
yarn is pressed together where it touches; fibres and plies of the apparent radius overlap there."""

GAUSS_POINTS = 5
"""Gauss points per segment for segment lengths; five points give the length of a knitted segment to 1e-8 of it."""


SEGMENTS_OF_BLOCK = 4096
"""Segments that are sampled or measured at once, so few that their numbers stay in the cache of a core."""


def basis(parameter: ArrayLike) -> FloatArray:
    """Return the weights of the four control points at each parameter in [0, 1], shape (n, 4)."""
    s = np.atleast_1d(np.asarray(parameter, dtype=np.float64))
    t = 1.0 - s
    return np.stack([t**3, 3 * s**3 - 6 * s**2 + 4, -3 * s**3 + 3 * s**2 + 3 * s + 1, s**3], axis=1) / 6


def basis_derivative(parameter: ArrayLike) -> FloatArray:
    """Return the derivative of ``basis`` with respect to the parameter, shape (n, 4)."""
    s = np.atleast_1d(np.asarray(parameter, dtype=np.float64))
    t = 1.0 - s
    return np.stack([-(t**2), 3 * s**2 - 4 * s, -3 * s**2 + 2 * s + 1, s**2], axis=1) / 2


def _no_numbers() -> FloatArray:
    """Return an empty array, the default of some fields; the constructor replaces it by the default numbers."""
    return np.zeros(0)


def _default_colour() -> IntArray:
    """Return an empty array of colours; the constructor replaces it by zeros of the right length."""
    return np.zeros(0, dtype=np.int64)


@dataclass(frozen=True, eq=False, kw_only=True)
class YarnSet:
    """A set of yarns in a CSR layout: yarn ``y`` owns the control points ``points[start[y]:start[y + 1]]``.

    N, S and Y below are the numbers of control points, segments and yarns.

    Raises:
        YarnError: a coordinate or a natural curvature is not finite, a radius or rest length is not positive and
            finite, a stated mass is not positive and finite, a colour is negative, a yarn has too few control points
            (fewer than 3 if closed, 4 if open), the palette is not an array of bytes, or an array has the wrong shape.
    """

    points: FloatArray
    """B-spline control points [cm], shape (N, 3)."""
    start: IntArray
    """First control point of each yarn, and N at the end, shape (Y + 1,)."""
    closed: NDArray[np.bool_]
    """Whether each yarn is closed, shape (Y,)."""
    radius: FloatArray
    """Radius of each yarn at contacts [cm], shape (Y,)."""
    rest_length: FloatArray
    """Rest length of each segment [cm], shape (S,)."""
    row: IntArray
    """Knitting row of each control point, shape (N,); the number of its yarn if no stitch made the point."""
    face: IntArray
    """Stitch face that made each control point, ``UNKNOWN_FACE`` if no stitch made the point, shape (N,)."""
    part: IntArray
    """Part of the stitch that each control point belongs to, counted along the template, or ``FLOATING``, (N,)."""
    colour: IntArray = field(default_factory=_default_colour)
    """Colour number of each yarn (``StitchMesh.yarn`` of its stitches), shape (Y,); all 0 by default."""
    natural_curvature: FloatArray = field(default_factory=_no_numbers)
    """Signed curvature of the unstressed yarn where segments meet [1/cm], shape (N,); all 0 (straight) by default.

    Only the magnitude enters the energy, because yarns turn about their own axis without resistance (the bending energy
    of ``yarnrelax``). The sign matters between two control points of opposite sign, where the curvature passes through
    0. The values at the first and last control point of an open yarn are not used.
    """
    lattice: Lattice | None = None
    """Lattice of a periodic set of yarns; None for yarns that do not repeat."""
    lattice_step: IntArray | None = None
    """Lattice step of each yarn, shape (Y, 2): the image in which the yarn continues after its last control point."""
    palette: Palette = field(default_factory=empty_palette)
    """Colour of each colour number (sRGB), shape (P, 3); numbers beyond it have stock colours (``mesh.palette``)."""
    drawn_radius: FloatArray = field(default_factory=_no_numbers)
    """Apparent radius of each yarn [cm], shape (Y,); ``radius`` by default.

    Pictures and files for renderers draw yarns with it. The relaxation never reads it."""
    mass_per_length: FloatArray = field(default_factory=_no_numbers)
    """Mass of a length of each yarn [g/cm], shape (Y,); NaN where a yarn states no mass, which is the default.

    A stated mass has precedence over the mass of the material."""
    made_of: Yarn | None = field(default=None, metadata={"stored": False})
    """The yarn of which all were made, if it is known; its stiffnesses hold where no other material is given."""

    def __post_init__(self) -> None:
        kinds = {"points": np.float64, "start": np.int64, "closed": np.bool_, "radius": np.float64,
                 "rest_length": np.float64, "row": np.int64, "face": np.int64, "part": np.int64}  # fmt: skip
        for name, kind in kinds.items():
            object.__setattr__(self, name, frozen_array(getattr(self, name), kind))
        if self.lattice_step is not None:
            object.__setattr__(self, "lattice_step", frozen_array(self.lattice_step, np.int64))
        colour = np.asarray(self.colour)
        object.__setattr__(self, "colour", frozen_array(colour if colour.size else np.zeros(self.yarn_count), np.int64))
        natural = np.asarray(self.natural_curvature)
        natural = frozen_array(natural if natural.size else np.zeros(len(self.points)), np.float64)
        object.__setattr__(self, "natural_curvature", natural)
        drawn = np.asarray(self.drawn_radius)
        object.__setattr__(self, "drawn_radius", frozen_array(drawn if drawn.size else self.radius, np.float64))
        mass = np.asarray(self.mass_per_length)
        mass = frozen_array(mass if mass.size else np.full(self.yarn_count, np.nan), np.float64)
        object.__setattr__(self, "mass_per_length", mass)
        object.__setattr__(self, "palette", checked_palette(self.palette, YarnError))
        self._check_shapes()
        self._check_values()

    @classmethod
    def from_curves(
        cls,
        curves: Sequence[ArrayLike],
        *,
        closed: Sequence[bool],
        radius: float | ArrayLike,
        rest_lengths: Sequence[ArrayLike] | None = None,
    ) -> YarnSet:
        """Build a set of yarns from lists of B-spline control points.

        Args:
            curves: control points of each yarn [cm], shape (n, 3) each; a closed yarn does not repeat its first point.
            closed: whether each yarn is closed.
            radius: one radius for all yarns [cm], or one radius per yarn, shape (Y,).
            rest_lengths: rest lengths of the segments of each yarn [cm]; the present lengths if None.

        Raises:
            YarnError: as for the class.
        """
        arrays = [np.asarray(curve, dtype=np.float64).reshape(-1, 3) for curve in curves]
        if not arrays:
            raise YarnError("yarns: got no curves; expected at least one")
        start = np.concatenate([[0], np.cumsum([len(a) for a in arrays])])
        points = np.concatenate(arrays)
        flags = np.asarray(closed, dtype=np.bool_)
        _check_counts(start, flags)
        lengths = None if rest_lengths is None else np.concatenate([np.ravel(r) for r in rest_lengths])
        if lengths is None:
            lengths = segment_lengths(points, segment_points(start, flags))
        unknown = np.full(len(points), UNKNOWN_FACE)
        return cls(
            points=points,
            start=start,
            closed=flags,
            radius=np.broadcast_to(np.asarray(radius, dtype=np.float64), len(arrays)),
            rest_length=lengths,
            row=np.repeat(np.arange(len(arrays)), np.diff(start)),
            face=unknown,
            part=np.zeros(len(points), dtype=np.int64),
        )

    def __repr__(self) -> str:
        """Return one line: the numbers of yarns and control points, the rest length of all yarn, radius and size."""
        counts = f"{self.yarn_count} yarns, {len(self.points)} control points, {self.rest_length.sum() / 100:.1f} m"
        thin, thick = self.radius.min(), self.radius.max()
        radius = f"radius {thin:.3g} cm" if thin == thick else f"radius {thin:.3g} to {thick:.3g} cm"
        periodic = ", periodic" if self.lattice is not None else ""
        return f"YarnSet({counts}, {radius}, {extent(self.points)}{periodic})"

    def with_radius(self, radius: ArrayLike) -> YarnSet:
        """Return the yarns with other contact radii; the drawn radii change by the same factors.

        Args:
            radius: one radius for all yarns [cm], or one radius per yarn, shape (Y,).
        """
        new = np.broadcast_to(np.asarray(radius, dtype=np.float64), self.radius.shape)
        return dataclasses.replace(self, radius=new, drawn_radius=self.drawn_radius * (new / self.radius))

    def masses_per_length(self, unstated: float) -> FloatArray:
        """Return the mass of a length of each yarn [g/cm], shape (Y,); ``unstated`` for yarns that state no mass."""
        return np.where(np.isnan(self.mass_per_length), unstated, self.mass_per_length)

    def mass(self, unstated: float) -> float:
        """Return the mass of all yarn [g]; ``unstated`` is the mass of a length of yarn that states none [g/cm]."""
        return float(self.masses_per_length(unstated)[self.segment_yarn] @ self.lengths)

    @property
    def yarn_count(self) -> int:
        """Number of yarns."""
        return len(self.start) - 1

    @cached_property
    def segment_start(self) -> IntArray:
        """First segment of each yarn, and S at the end, shape (Y + 1,)."""
        return _segment_start(self.start, self.closed)

    @cached_property
    def segment_points(self) -> IntArray:
        """The four control points of each segment, shape (S, 4)."""
        return segment_points(self.start, self.closed)

    @cached_property
    def segment_yarn(self) -> IntArray:
        """Yarn of each segment, shape (S,)."""
        return np.repeat(np.arange(self.yarn_count), np.diff(self.segment_start))

    @cached_property
    def point_yarn(self) -> IntArray:
        """Yarn of each control point, shape (N,)."""
        return np.repeat(np.arange(self.yarn_count), np.diff(self.start))

    @cached_property
    def lengths(self) -> FloatArray:
        """Present arc length of each segment [cm], shape (S,)."""
        return segment_lengths(self.points, self.segment_points, self.point_shift)

    @cached_property
    def strain(self) -> FloatArray:
        """Strain of each segment: length / rest length - 1, shape (S,)."""
        return self.lengths / self.rest_length - 1.0

    @cached_property
    def natural_ends(self) -> FloatArray:
        """Natural curvature [1/cm] at both ends of each segment, linear in between, shape (S, 2)."""
        return self.natural_curvature[self.segment_points[:, 1:3]]

    @cached_property
    def point_shift(self) -> FloatArray | None:
        """Lattice shift of the four control points of each segment [cm], shape (S, 4, 3); None without a lattice."""
        if self.lattice is None or self.lattice_step is None:
            return None
        wrapped = np.diff(self.segment_points, axis=1) < 0
        wraps = np.concatenate([np.zeros((len(wrapped), 1)), np.cumsum(wrapped, axis=1)], axis=1)
        return wraps[:, :, None] * self.lattice.shift(self.lattice_step)[self.segment_yarn][:, None, :]

    def corners_of(self, segments: IntArray | slice = slice(None)) -> FloatArray:
        """Return the four control points of some segments [cm], by default of all, in one piece, shape (n, 4, 3)."""
        corners = self.points[self.segment_points[segments]]
        return corners if self.point_shift is None else corners + self.point_shift[segments]

    def sampled(self, per_segment: int) -> list[FloatArray]:
        """Sample each yarn with ``per_segment`` points per segment [cm], shape (n, 3) each.

        The end of an open yarn is included; a closed yarn does not repeat its first point.
        """
        curves, result = self.samples(per_segment), []
        ends = np.einsum("j,sjd->sd", basis(1.0)[0], self.corners_of(self.segment_start[1:] - 1))
        for yarn in range(self.yarn_count):
            first, last = self.segment_start[yarn], self.segment_start[yarn + 1]
            curve = curves[first * per_segment : last * per_segment]
            result.append(curve if self.closed[yarn] else np.concatenate([curve, ends[yarn : yarn + 1]]))
        return result

    def samples(self, per_segment: int) -> FloatArray:
        """Sample each segment with ``per_segment`` points from its beginning [cm], one after another, shape (n, 3)."""
        weights = basis(np.arange(per_segment) / per_segment)
        samples = np.empty((len(self.segment_points), per_segment, 3))

        def sample(some: slice) -> None:
            curves = weights @ self.corners_of(some).transpose(1, 2, 0).reshape(4, -1)
            samples[some] = curves.reshape(per_segment, 3, -1).transpose(2, 0, 1)

        each_block(sample, len(samples), SEGMENTS_OF_BLOCK)
        return samples.reshape(-1, 3)

    def _check_shapes(self) -> None:
        if self.points.ndim != 2 or self.points.shape[1:] != (3,):
            raise YarnError(f"points: got shape {self.points.shape}; expected (N, 3)")
        if self.start[0] != 0 or self.start[-1] != len(self.points):
            raise YarnError(f"start: got {self.start[0]} to {self.start[-1]}; expected 0 to {len(self.points)}")
        _check_counts(self.start, self.closed)
        expected = {"radius": self.yarn_count, "row": len(self.points), "face": len(self.points),
                    "part": len(self.points), "rest_length": int(self.segment_start[-1]),
                    "colour": self.yarn_count, "natural_curvature": len(self.points),
                    "drawn_radius": self.yarn_count, "mass_per_length": self.yarn_count}  # fmt: skip
        for name, count in expected.items():
            if getattr(self, name).shape != (count,):
                raise YarnError(f"{name}: got shape {getattr(self, name).shape}; expected ({count},)")
        if (self.lattice is None) != (self.lattice_step is None):
            raise YarnError("yarns: a lattice and lattice steps must be given together; got one without the other")
        if self.lattice_step is not None and self.lattice_step.shape != (self.yarn_count, 2):
            raise YarnError(f"lattice_step: got shape {self.lattice_step.shape}; expected ({self.yarn_count}, 2)")

    def _check_values(self) -> None:
        if not _are_within(self.points, -LARGEST_LENGTH, LARGEST_LENGTH):
            bad = np.flatnonzero(~(np.abs(self.points) <= LARGEST_LENGTH).all(axis=1))
            yarn = np.searchsorted(self.start, bad[0], side="right") - 1
            found = f"coordinates are not finite or beyond {LARGEST_LENGTH:g}"
            raise YarnError(f"control point {first_few(bad)} (yarn {yarn}): {found}")
        for name in ("radius", "rest_length", "drawn_radius"):
            values = getattr(self, name)
            if not _are_within(values, np.nextafter(0.0, 1.0), LARGEST_LENGTH):
                bad = np.flatnonzero(~((values <= LARGEST_LENGTH) & (values > 0.0)))
                raise YarnError(f"{name} {first_few(bad)}: got {values[bad[0]]}; expected a positive number of cm")
        bad = np.flatnonzero((self.mass_per_length <= 0.0) | np.isinf(self.mass_per_length))
        if len(bad):
            found = f"got {self.mass_per_length[bad[0]]} g/cm"
            raise YarnError(f"mass_per_length {first_few(bad)}: {found}; expected a positive number, or nan for none")
        natural = self.natural_curvature
        if not _are_within(natural, -LARGEST_LENGTH, LARGEST_LENGTH):
            bad = np.flatnonzero(~(np.abs(natural) <= LARGEST_LENGTH))
            found = natural[bad[0]]
            raise YarnError(f"natural_curvature {first_few(bad)}: got {found}; expected finite numbers in 1/cm")
        bad = np.flatnonzero(self.colour < 0)
        if len(bad):
            raise YarnError(f"yarn {first_few(bad)}: got colour {self.colour[bad[0]]}; colours are numbered from 0")


def _are_within(values: FloatArray, least: float, most: float) -> bool:
    """Whether all values are finite and within bounds, without an array of answers: most sets are right."""
    return bool(values.min() >= least and values.max() <= most)  # a minimum is not a number if a value is not one


def _check_counts(start: IntArray, closed: NDArray[np.bool_]) -> None:
    counts = np.diff(start)
    if closed.shape != counts.shape or len(counts) == 0:
        raise YarnError(f"closed: got {len(closed)} flags for {len(counts)} yarns; expected one per yarn, at least one")
    bad = np.flatnonzero(counts < np.where(closed, 3, 4))
    if len(bad):
        raise YarnError(
            f"yarn {first_few(bad)}: got {counts[bad[0]]} control points; a closed yarn needs 3, an open yarn 4"
        )


def _segment_start(start: IntArray, closed: NDArray[np.bool_]) -> IntArray:
    """First segment of each yarn, and the number of segments at the end, shape (Y + 1,)."""
    counts = np.diff(start) - np.where(closed, 0, 3)
    return np.concatenate([[0], np.cumsum(counts)])


def segment_points(start: IntArray, closed: NDArray[np.bool_]) -> IntArray:
    """Return the four control points of each segment, shape (S, 4); the segments of a closed yarn wrap around.

    Args:
        start: first control point of each yarn, and N at the end, shape (Y + 1,).
        closed: whether each yarn is closed, shape (Y,).
    """
    bounds = _segment_start(start, closed)
    shift = start[:-1] - bounds[:-1]
    first = np.arange(bounds[-1]) + np.repeat(shift, np.diff(bounds))
    points = first[:, None] + np.arange(4)
    # Only the last three segments of a closed yarn have control points at its beginning.
    last, end, size = bounds[1:][closed, None] - [1, 2, 3], start[1:][closed], np.diff(start)[closed]
    points[last] -= np.where(points[last] >= end[:, None, None], size[:, None, None], 0)
    return points


def segment_lengths(points: FloatArray, segments: IntArray, shift: FloatArray | None = None) -> FloatArray:
    """Return the arc length of each segment [cm] by Gauss quadrature, shape (S,).

    Args:
        points: control points [cm], shape (N, 3).
        segments: control points of each segment, shape (S, 4).
        shift: lattice shift of the control points of each segment [cm], shape (S, 4, 3); None without a lattice.
    """
    nodes, weights = np.polynomial.legendre.leggauss(GAUSS_POINTS)
    derivative, lengths = basis_derivative((nodes + 1) / 2), np.empty(len(segments))

    def measure(some: slice) -> None:
        corners = points[segments[some]] if shift is None else points[segments[some]] + shift[some]
        tangent = derivative @ corners.transpose(1, 2, 0).reshape(4, -1)
        squares = np.square(tangent, out=tangent).reshape(GAUSS_POINTS, 3, -1).sum(axis=1)
        lengths[some] = (weights / 2) @ np.sqrt(squares, out=squares)

    each_block(measure, len(segments), SEGMENTS_OF_BLOCK)
    return lengths
