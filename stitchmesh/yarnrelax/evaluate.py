# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Energies, forces and contact loads of yarns in their current positions, and their distances from a body.

The contact load says how hard the yarns press on each segment. The contact forces on a yarn between others cancel, so
their sum does not show this. The contact load therefore sums the magnitudes of the forces between pairs of contact
samples (``energies/contact``), and divides the sum of each segment by its rest length.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.device import alone, device_named
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.precision import Scalar, Vec4, scalar_named
from stitchmesh.errors import check_kind
from stitchmesh.mesh import FloatArray, Mesh
from stitchmesh.simulation.bodies.body_surface import SurfaceArrays, gap_to
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.collision.captured_search import ContactSearch
from stitchmesh.yarnrelax.collision.narrow_phase import Candidates, make_candidates
from stitchmesh.yarnrelax.energies import by_term, evaluation
from stitchmesh.yarnrelax.energies.body import put_surface
from stitchmesh.yarnrelax.energies.contact import contact_force_scale
from stitchmesh.yarnrelax.model.constants import Model, YarnConstants
from stitchmesh.yarnrelax.model.lattice_images import sample_number
from stitchmesh.yarnrelax.model.material import YarnMaterial
from stitchmesh.yarnrelax.model.spline import from_entry, place_contact_samples
from stitchmesh.yarnrelax.model.state import State, make_state
from stitchmesh.yarnrelax.model.upload import put_cells, put_model


@alone()
def yarn_energies(
    yarns: YarnSet,
    material: YarnMaterial,
    *,
    precision: str = "float64",
    quadrature_points: int = 11,
    contact_samples: int = 11,
    device: str | None = None,
) -> dict[str, float]:
    """Return the energies of yarns in their current positions [erg].

    Args:
        yarns: the yarns; on a lattice the energies are the energies of one cell.
        material: stiffnesses, used without change (``YarnMaterial.scaled`` adapts them to another radius).
        precision: "float32" or "float64".
        quadrature_points: Gauss points for each segment for stretch, length and bending; three are as accurate as
            eleven equidistant points.
        contact_samples: contact samples for each segment; choose a number that places them closer than half a radius.
        device: "cpu", "cuda:0" ...; None for the first GPU, or the CPU if there is no GPU.

    Returns:
        Energies under "stretch", "length", "bend" and "contact".

    Raises:
        ParameterError: the device or the precision is unknown, or a count is below 1.
    """
    given = [(yarns, material)]
    model, state, candidates = put_evaluations(given, precision, quadrature_points, contact_samples, device)
    return by_term.energies(model, state, candidates, ())


@alone()
def yarn_forces(
    yarns: YarnSet,
    material: YarnMaterial,
    *,
    precision: str = "float64",
    quadrature_points: int = 11,
    contact_samples: int = 11,
    device: str | None = None,
) -> NDArray[np.float64]:
    """Return minus the gradient of the sum of ``yarn_energies`` by the control points [dyn], shape (N, 3).

    The arguments and errors are the same as in ``yarn_energies``.
    """
    given = [(yarns, material)]
    model, state, candidates = put_evaluations(given, precision, quadrature_points, contact_samples, device)
    no_stiffness = model.empty(model.point_count)
    evaluation.force_launches(model, state, candidates, (), no_stiffness, model.launch)
    return state.force.numpy().astype(np.float64) / model.unit


def put_evaluations(
    given: Sequence[tuple[YarnSet, YarnMaterial]],
    precision: str,
    quadrature_points: int,
    contact_samples: int | Sequence[int],
    device: str | None,
) -> tuple[Model, State, Candidates]:
    """Return a model of cells on lattices, or of one piece, and a state with placed samples and listed candidates."""
    for yarns, material in given:
        check_kind("yarn_energies", yarns, YarnSet)
        check_kind("yarn_energies, material", material, YarnMaterial)
    model = put_cells(
        given,
        quadrature_points=quadrature_points,
        contact_samples=contact_samples,
        scalar=scalar_named(precision),
        device=device_named(device),
    )
    state = make_state(model)
    candidates = make_candidates(model, margin=1e-4)  # in mean radii; the result does not depend on it
    ContactSearch(model, state, candidates).run()
    return model, state, candidates


@kernel
def contact_magnitudes(
    # model
    model: YarnConstants,
    # state in
    samples: wp.array[Vec4],
    candidate_count: wp.array[wp.int32],
    candidates: wp.array2d[wp.int32],
    # state out
    magnitude: wp.array[Scalar],
) -> None:
    """Sum of the magnitudes of the contact forces on each sample."""
    p = wp.tid()
    here = samples[p]
    scale = model.sample_stiffness[p]
    total = scale - scale
    for c in range(candidate_count[p]):
        entry = candidates[p, c]
        apart = from_entry(model.images, samples, p, here, entry)
        distance2 = apart[0] * apart[0] + apart[1] * apart[1] + apart[2] * apart[2]
        reach2 = apart[3] * apart[3]
        if distance2 < reach2:
            weight = model.sample_weight[sample_number(model.images, entry)]
            push, _stiff, _inverse = contact_force_scale(model.contact, p, distance2, reach2, weight)
            total += push * wp.sqrt(distance2)
    magnitude[p] = total * scale


@alone()
def contact_load(
    yarns: YarnSet, material: YarnMaterial, *, precision: str = "float64", contact_samples: int = 11,
    device: str | None = None,
) -> FloatArray:  # fmt: skip
    """Return the contact force per rest length on each segment [dyn/cm], shape (S,).

    Args:
        yarns: the yarns, on a lattice or not.
        material: stiffnesses, used without change (``YarnMaterial.scaled`` adapts them to another radius).
        precision: "float32" or "float64".
        contact_samples: contact samples for each segment.
        device: "cpu", "cuda:0" ...; None for the first GPU, or the CPU if there is no GPU.

    Raises:
        ParameterError: the device or the precision is unknown, or a count is below 1.
    """
    model, state, candidates = put_evaluations([(yarns, material)], precision, 1, contact_samples, device)
    magnitude = model.empty(model.sample_count)
    model.launch(
        contact_magnitudes, model.sample_count,
        [model.constants, state.samples, candidates.count, candidates.lists], [magnitude],
    )  # fmt: skip
    total = np.add.reduceat(magnitude.numpy().astype(np.float64), np.asarray(model.sample_start)[:-1])
    return total / model.unit / yarns.rest_length


@kernel
def surface_distances(
    # model
    surface: SurfaceArrays,
    limit: Scalar,
    # state in
    samples: wp.array[Vec4],
    # state out
    distance: wp.array[Scalar],
) -> None:
    """Signed distance of each sample from a surface, at most ``limit``."""
    p = wp.tid()
    distance[p] = gap_to(surface, samples[p], limit)[3]


@alone()
def body_distance(yarns: YarnSet, body: Mesh, *, contact_samples: int = 3, device: str | None = None) -> FloatArray:
    """Return the least distance [cm] from the surface of a body to the surface of the yarn in each segment, shape (S,).

    The distance is negative where the yarn is inside the body.

    Args:
        yarns: the yarns.
        body: the surface, with its faces outwards.
        contact_samples: number of places along each segment at which the distance is measured.
        device: "cpu", "cuda:0" ...; None for the first GPU, or the CPU if there is no GPU.

    Raises:
        ParameterError: the device is unknown, or the count is below 1.
    """
    model = put_model(
        yarns, YarnMaterial.named(), quadrature_points=1, contact_samples=contact_samples,
        scalar=scalar_named("float64"), device=device_named(device),
    )  # fmt: skip
    state = make_state(model)
    place_contact_samples(model, state, model.launch)
    surface = put_surface(model, body)
    everything = np.concatenate([yarns.points, body.vertices])
    limit = 2.0 * float(np.linalg.norm(np.ptp(everything, axis=0))) / model.unit
    distance = model.empty(model.sample_count)
    inputs = [surface.constants, model.number(limit), state.samples]
    model.launch(surface_distances, model.sample_count, inputs, [distance])
    least = np.minimum.reduceat(distance.numpy().astype(np.float64), np.asarray(model.sample_start)[:-1])
    return least * model.unit - yarns.radius[yarns.segment_yarn]
