# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Coulomb's law, smoothed, for everything that rubs.

These are yarn on yarn, yarn in its crossings, yarn and cloth on a body, and cloth on cloth.

Two things that press each other with a normal force N have the energy

    E = mu N phi(s),    phi(s) = s^2 / e - s^3 / (3 e^2)  for s < e, else s - e / 3        [erg]

with the coefficient mu, the slip length e and the slip s = |u|. The vector u is the displacement from an anchor, less
its part along the contact normal n. This is the mollifier of Li et al. 2020 (Incremental Potential Contact) less its
constant. N and n are taken from the last state of rest or the last step, so the force is a gradient,

    f = -mu N phi' / s u,    H = mu N (phi' / s (1 - n n^T) - c u u^T),    c = 1 / (e^2 s)  for s < e, else 1 / s^3

and H has no negative eigenvalue, because phi is convex and rises. Along a slip beyond e, H is zero.

An anchor lasts: when N and n are renewed, it is dragged behind a slip that is longer than e, up to s = e. A fabric thus
rests under loads up to mu N. Only the layers of a cloth take the beginning of the step as the anchor
(``mixed.contact.layer_friction``), and creep.
"""

from __future__ import annotations

from typing import Any

import warp as wp

from stitchmesh.compute.precision import Scalar, Vec3

LARGEST_COEFFICIENT = 2.0
"""No yarn has a larger coefficient on yarn, skin or cloth; the largest of dry and wet fibres in Morton and Hearle is
0.9, of swollen wool."""


@wp.func
def within(slip: Vec3, normal: Vec3) -> Any:
    """Part of a vector in the plane across a unit normal."""
    return slip - normal * wp.dot(slip, normal)


@wp.func
def slip_energy(measure: Scalar, slip_length: Scalar) -> Any:
    """phi(s)."""
    if measure < slip_length:
        part = measure / slip_length
        return measure * part * (type(part)(1.0) - part / type(part)(3.0))
    return measure - slip_length / type(measure)(3.0)


@wp.func
def slip_slope(measure: Scalar, slip_length: Scalar) -> Any:
    """phi'(s) / s."""
    if measure < slip_length:
        return (type(measure)(2.0) - measure / slip_length) / slip_length
    return type(measure)(1.0) / measure


@wp.func
def slip_second_derivative(measure: Scalar, slip_length: Scalar) -> Any:
    """phi''(s), the slope of friction along the slip."""
    part = measure / slip_length
    return type(measure)(2.0) / slip_length * wp.max(type(measure)(1.0) - part, part - part)


@wp.func
def slip_curvature(measure: Scalar, slip_length: Scalar) -> Any:
    """c, the part of phi' / s by which friction is softer along the slip, over s^2; zero without slip."""
    if measure < slip_length:
        return measure / (slip_length * slip_length * wp.max(measure * measure, type(measure)(1.0e-30)))
    return type(measure)(1.0) / (measure * measure * measure)


@wp.func
def slip_block(slip: Vec3, normal: Vec3, slip_length: Scalar) -> Any:
    """H over mu N of an isotropic contact, a matrix."""
    measure = wp.length(slip)
    across = wp.identity(n=3, dtype=type(measure)) - wp.outer(normal, normal)
    return across * slip_slope(measure, slip_length) - wp.outer(slip, slip) * slip_curvature(measure, slip_length)


@wp.func
def slip_force(slip: Vec3, size: Scalar, slip_length: Scalar) -> Any:
    """F of an isotropic contact; ``size`` is mu N."""
    return slip * (-size * slip_slope(wp.length(slip), slip_length))
