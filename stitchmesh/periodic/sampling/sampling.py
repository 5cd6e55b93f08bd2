# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How finely the yarns of a repeat are sampled, and the samplings through which a free repeat comes to rest.

A fabric has several states of rest, and a coarse sampling adds some of its own. A repeat whose size relaxes therefore
always follows one path. Its yarns are generated with one sampling (``GENERATED``), which gives their curves, their
lengths and the planes between which the fabric lies. They relax with the sampling of the coarsest preset, and each
relaxed yarn is sampled again (``even_sampling``) for the next preset, up to the quality that the caller asked for. All
presets take the same path; a coarser preset only leaves out its last steps.

The spacing of a sampled repeat differs from the spacing of the fabric. The error falls with about the third power of
the number of control points; ``Quality.refinement`` makes it smaller than the error that a preset promises
(docs/accuracy.md). The numbers of contact samples and quadrature points of a segment fall as the segments become
shorter, but not below ``quality.FEWEST``.

Contacts between samples of yarn are not quite smooth: the samples of one yarn lie between the samples of the other.
These small hollows hold soft fabrics at places from which a finer sampling lets them slide, sometimes to another state.
A segment of a small cell (``SMALL_CELL``) therefore has at least ``CONTACTS`` samples, and a free repeat is at rest at
a residual of at most ``RESIDUAL``. With three samples the size of slack ribs and of garter was up to 1.4 % off at
``standard``, and slack honeycomb, moss stitch and cartridge belt rib came to other states at ``draft`` than with every
finer sampling. Larger cells, which take longest, keep three.

A knit that is let go with friction (``off_needles``) has one sampling, so that the anchors of its friction last. The
hollows act on it like more friction: with three samples a rope cable stayed 40 % wider than with nine
(``CONTACTS_RELEASED``). On the needles its yarns are bent more than at rest: with 16 control points a stitch, blocks of
knit and purl were 9 % narrower, and 1x1 rib with loops of 20 diameters 18 % narrower, than with 26; with 20
(``POINTS_RELEASED``) 4 % and 0.1 %.
"""

from __future__ import annotations

import math
from dataclasses import replace

from stitchmesh.mesh import StitchMesh
from stitchmesh.periodic.repeat.smallest_cell import SmallestCell
from stitchmesh.periodic.swatch_options import COMPACT_LOOP, SwatchOptions
from stitchmesh.quality import PRESETS, ROUNDING, Quality
from stitchmesh.yarnrelax import RelaxCell

GENERATED = PRESETS["reference"]
"""Quality with which the curves of every repeat are generated."""
CONTACTS = 5
"""Smallest number of contact samples of a segment of a small cell."""
CONTACTS_RELEASED = 9
"""Smallest number of contact samples of a segment of a knit that is let go with friction."""
POINTS_RELEASED = 20
"""Smallest number of control points of a stitch in a knit that is let go, if its quality is refined."""
SMALL_CELL = 16
"""Largest number of stitches of a small cell."""
RESIDUAL = 0.002
"""Largest residual of a refined repeat at rest."""


def refined(quality: Quality) -> Quality:
    """Return the quality with which a free repeat is relaxed; a quality without refinement is kept."""
    if quality.refinement == 1.0:
        return quality
    points = math.ceil(quality.control_points_per_stitch * quality.refinement * (1.0 - ROUNDING))
    return replace(
        quality, control_points_per_stitch=points, tolerance=min(quality.tolerance, RESIDUAL),
        contact_samples=quality.refined(quality.contact_samples),
        quadrature_points=quality.refined(quality.quadrature_points), refinement=1.0,
    )  # fmt: skip


def with_contacts(
    quality: Quality, options: SwatchOptions, fabric: StitchMesh | None, smallest: SmallestCell, cell: RelaxCell | None
) -> Quality:
    """Return a quality with as many contact samples as a repeat needs: more in small free cells and for loose loops.

    Args:
        quality: a quality of the path to rest.
        options: options of the swatch.
        fabric: the stitch mesh of the repeat; None for a weave.
        smallest: the cell that comes to rest.
        cell: its degrees of freedom; None for constant periods.
    """
    if cell is not None and cell.free.any() and is_small(fabric, smallest):
        quality = replace(quality, contact_samples=max(CONTACTS, quality.contact_samples))
    return close_contacts(quality, options)


def is_small(fabric: StitchMesh | None, smallest: SmallestCell) -> bool:
    """Return whether the cell that comes to rest has few stitches; for a weave (None) it has none."""
    return fabric is not None and fabric.face_count <= SMALL_CELL * smallest.copies


def close_contacts(quality: Quality, options: SwatchOptions) -> Quality:
    """Return the quality with more contact samples if loops are looser than compact ones.

    The number of control points of a stitch is the same for long and short loops, so the contact spheres of a segment
    are further apart in long loops. Such spheres interlock, and the loops stay narrower than in equilibrium.
    """
    looseness = options.plain_loop / (2 * COMPACT_LOOP * options.yarn_radius * options.gamma)
    # Spheres that interlock hold a loop back. In a looser loop the bends of the yarn are further apart, so both this
    # force and the forces that straighten the yarn are smaller (docs/validation.md): the number of samples grows with
    # the power 1.5 of the looseness, up to a looseness of 4.
    closer = min(max(looseness, 1.0), 4.0) ** 1.5
    exact = 1.0 - 1e-12  # the rounding of a quotient of lengths gives no further sample
    return replace(quality, contact_samples=math.ceil(quality.contact_samples * closer * exact))


def released(quality: Quality) -> Quality:
    """Return the quality with which a knit is let go with friction; without refinement its control points are kept."""
    found = replace(refined(quality), contact_samples=max(CONTACTS_RELEASED, quality.contact_samples))
    if quality.refinement == 1.0:
        return found
    return replace(found, control_points_per_stitch=max(POINTS_RELEASED, found.control_points_per_stitch))


def path_to(quality: Quality, cell: RelaxCell | None) -> tuple[Quality, ...]:
    """Return the qualities through which a repeat comes to rest.

    A repeat of constant size has only the given quality. A free repeat first goes through presets, ever finer, that
    sample less than the given quality, and ends with the given quality, all refined. No quality has a larger limit of
    iterations than the given one.
    """
    if cell is None or not cell.free.any():
        return (quality,)
    last = refined(quality)
    presets = [refined(preset) for preset in PRESETS.values()]
    coarser = [each for each in presets if each.control_points_per_stitch < last.control_points_per_stitch]
    steps = [replace(each, max_iterations=min(each.max_iterations, last.max_iterations)) for each in coarser]
    return (*steps, last)
