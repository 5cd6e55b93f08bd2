# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Takes the state of a run over into another region.

*State.* Nodes that were simulated keep their positions and their Eulerian coordinates. New nodes start on the
triangles, with the Eulerian coordinates of the layout. Vertices that belonged only to full-yarn triangles did not move
in the run; the nodes around them now place them. Their positions are the least squares of |p - B v|^2 over the nodes of
their triangles, where the other vertices stay. For vertices with few nodes, the sum contains a small part of a spring
between neighbours that keeps their differences. Hybrid nodes then lose the part that the triangles can represent,
x = F (p - B v), so that p = B v + F x holds. Velocities move in the same manner, with Eulerian velocities of zero for
new nodes.

Control points of B-splines stand out of their triangles. New control points begin at their heights above the triangles,
and vertices and hybrid nodes change to the nearest positions with p = B v + F x, as at the start of a run
(``enrichment.projection``).

Attached nodes and vertices go to the place that their attachment prescribes, and the hybrid nodes and vertices around
them follow: attached nodes that begin on a triangle with a free corner are not at this place.

*Memory of terms.* Rest angles of bending and anchors of friction between yarns belong to nodes; anchors on bodies
belong to contact points. Nodes and points that stay keep their values. A new node gets the values that it had when it
was simulated last, or begins as laid out. A new contact point finds its anchor at its present place.

Nodes of the layout keep values also while they are not simulated. Eulerian coordinates of yarns that slid, rest angles
of bends that yielded and anchors of friction are the marks of a run. A node that leaves the region keeps its marks in a
memory, and gets them back where the region grows over it again.

*Momentum.* When a region grows or shrinks, mass moves between vertices and nodes. Their velocities are interpolated, so
the momentum changes a little. A rigid motion (a, w) is therefore added to the velocities of all free coordinates. It is
chosen so that both momenta, linear and angular about the centre c of the vertices, are the same as before the change:

    sum over all masses of  M (u + a + w x (x - c))  =  P,    of  (x - c) x M (u + a + w x (x - c))  =  L.

Fixed coordinates keep their velocity, and hybrid nodes move with their triangles.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, diags_array
from scipy.sparse.linalg import spsolve

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mixed.assembly import Loads, MixedFabric, contact_points, fixed_points, loaded_system
from stitchmesh.mixed.contact.body_friction import BodyFriction
from stitchmesh.mixed.contact.contact_points import ContactPoints
from stitchmesh.mixed.contact.motion import Attachment, PrescribedMotion
from stitchmesh.mixed.dynamics.equilibrium import EquilibriumSettings, find_equilibrium
from stitchmesh.mixed.dynamics.mixed_system import MixedSystem
from stitchmesh.mixed.dynamics.vector_sums import choose, set_sum
from stitchmesh.mixed.enrichment.region import YARNS, Region, embed
from stitchmesh.mixed.layout.spline_yarns import SplineYarns
from stitchmesh.mixed.mixed_vector import MixedVector
from stitchmesh.mixed.term import MixedTerm

Numbers = NDArray[np.float64]
SPRING = 1e-6
"""Stiffness of the springs between neighbouring vertices, over the stiffness of one node."""


@dataclass(frozen=True, eq=False)
class MovedState:
    """Positions or velocities of a region; arrays are read-only."""

    vertices: Numbers
    """Vertices, shape (V, 3)."""
    nodes: Numbers
    """Simulated nodes, shape (n, 3)."""
    sliding: Numbers
    """Eulerian coordinates of the simulated nodes, shape (n, 2)."""

    def __post_init__(self) -> None:
        for array in (self.vertices, self.nodes, self.sliding):
            array.flags.writeable = False


def move_state(
    old: Region,
    new: Region,
    vertices: Numbers,
    nodes: Numbers,
    sliding: Numbers,
    rest_sliding: Numbers,
    above: Callable[[Numbers], Numbers] | None = None,
) -> MovedState:
    """Positions for a new region; also velocities, if ``rest_sliding`` is zero.

    Args:
        old: the region of the given state.
        new: the region of the result, on the same cloth and layout.
        vertices: vertices, shape (V, 3).
        nodes: simulated nodes of the old region, shape (n, 3).
        sliding: their Eulerian coordinates, shape (n, 2).
        rest_sliding: Eulerian coordinates of all nodes of the layout, shape (N, 2).
        above: positions of all layout nodes above given vertices, for nodes that stand out of the triangles. The result
            then does not have the form p = B v + F x yet.

    Raises:
        ParameterError: the regions belong to different layouts, or an array has the wrong shape.
    """
    _check(old, new, vertices, nodes, sliding, rest_sliding)
    placed = place_hidden_vertices(old, vertices, nodes)
    moved = moved_values(old, new, sliding, rest_sliding)
    if above is not None:
        return MovedState(placed, moved_values(old, new, nodes, above(placed)), moved)
    corners = placed[new.triangles[new.node_triangle]]
    on_triangles = np.einsum("nk,nkd->nd", new.node_weight, corners)
    return MovedState(placed, _filtered(new, placed, moved_values(old, new, nodes, on_triangles)), moved)


def moved_values(old: Region, new: Region, values: NDArray[np.float64], at_rest: NDArray[np.float64]) -> Numbers:
    """Values of the simulated nodes of a new region: the values of the old region, and values at rest for new nodes.

    Args:
        old: the region of the given values.
        new: the region of the result.
        values: one row for each simulated node of the old region, shape (n, ...).
        at_rest: one row for each node of the layout, shape (N, ...).
    """
    everywhere = np.array(at_rest, dtype=np.float64)
    everywhere[old.nodes] = values
    return everywhere[new.nodes]


def place_hidden_vertices(region: Region, vertices: Numbers, nodes: Numbers) -> Numbers:
    """Positions of all vertices [cm], (V, 3); the yarns place the vertices without triangles of their own.

    Args:
        region: the region of the state.
        vertices: vertices, shape (V, 3).
        nodes: simulated nodes, shape (n, 3).
    """
    placed = np.array(vertices, dtype=np.float64)
    hidden = np.flatnonzero(~region.unknown_vertices)
    if len(hidden) == 0:
        return placed
    simulated = region.nodes
    of_yarns = region.triangle_kind[region.node_triangle[simulated]] == YARNS
    corners = region.triangles[region.node_triangle[simulated[of_yarns]]]
    weight = region.node_weight[simulated[of_yarns]]
    start = np.arange(0, corners.size + 1, 3)
    basis = csr_array((weight.ravel(), corners.ravel(), start), shape=(len(corners), len(placed)))
    springs = SPRING * _springs(region)
    matrix = csr_array(basis.T @ basis + springs)
    right = basis.T @ nodes[of_yarns] + springs @ placed
    known = np.ones(len(placed), dtype=bool)
    known[hidden] = False
    others = np.flatnonzero(known)
    right = right[hidden] - matrix[hidden][:, others] @ placed[others]
    placed[hidden] = np.asarray(spsolve(matrix[hidden][:, hidden].tocsc(), right)).reshape(-1, 3)
    return placed


def _springs(region: Region) -> csr_array:
    """The matrix of springs of unit stiffness along the sides of all triangles, shape (V, V)."""
    sides = region.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    count = len(region.vertex_alpha)
    ones = np.ones(len(sides))
    links = csr_array((ones, (sides[:, 0], sides[:, 1])), shape=(count, count))
    links = csr_array(links + links.T)
    # a little more on the diagonal keeps a cloth of full-yarn triangles without nodes definite
    return csr_array(diags_array(np.asarray(links.sum(axis=1)).ravel() * (1.0 + SPRING)) - links)


def _filtered(region: Region, vertices: Numbers, nodes: Numbers) -> Numbers:
    """Positions of the simulated nodes with p = B v + F x in the hybrid region."""
    embedding = embed(region)
    result = np.array(nodes)
    if len(embedding.columns):
        base = embedding.basis @ vertices
        detail = result[embedding.nodes] - base
        independent = embedding.independent
        part = np.asarray(spsolve(csr_array(independent.T @ independent).tocsc(), independent.T @ detail))
        result[embedding.nodes] = base + detail - independent @ part.reshape(-1, 3)
    return result


def _check(old: Region, new: Region, *arrays: Numbers) -> None:
    """Refuse regions of different layouts and arrays of wrong shapes."""
    same = np.array_equal(old.triangles, new.triangles) and np.array_equal(old.node_triangle, new.node_triangle)
    if not same:
        raise ParameterError("region: got regions of different cloths or layouts; expected the same")
    count, layout, vertices = len(old.nodes), len(old.node_triangle), len(old.vertex_alpha)
    expected = [(vertices, 3), (count, 3), (count, 2), (layout, 2)]
    found = [np.shape(array) for array in arrays]
    if found != expected:
        raise ParameterError(f"region: got arrays of shapes {found}; expected {expected}")


SLIDING = "sliding"
"""Name of the Eulerian coordinates."""
PREFIX = "node memory "
"""How the names of the arrays of a checkpoint begin."""


@dataclass(frozen=True, eq=False)
class NodeMemory:
    """Values of all N nodes of the layout, by name."""

    values: Mapping[str, Numbers] = field(default_factory=dict)
    """Arrays of shape (N, ...); their values are not numbers where a node has never been simulated."""

    def kept(self, name: str, region: Region, values: NDArray[Any]) -> NodeMemory:
        """Return the memory with the present values of the simulated nodes of a region, shape (n, ...)."""
        missing = np.full((len(region.node_triangle), *values.shape[1:]), np.nan)
        everywhere = np.array(self.values.get(name, missing))
        everywhere[region.nodes] = values
        return NodeMemory({**self.values, name: everywhere})

    def recalled(self, name: str, at_rest: NDArray[Any]) -> Numbers:
        """Return the values of all nodes, shape (N, ...); nodes that were never simulated have their values at rest."""
        known = self.values.get(name)
        result: Numbers = np.array(at_rest) if known is None else np.where(np.isnan(known), at_rest, known)
        return result

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return the arrays of a checkpoint."""
        return {f"{PREFIX}{name}": values for name, values in self.values.items()}

    @staticmethod
    def of(arrays: Mapping[str, NDArray[Any]]) -> NodeMemory:
        """Return the memory of a checkpoint."""
        return NodeMemory({name[len(PREFIX) :]: np.asarray(a) for name, a in arrays.items() if name.startswith(PREFIX)})


@dataclass(frozen=True, eq=False)
class RegionChange:
    """The region of a run before and after a change, with its contact points."""

    old: Region
    new: Region
    memory: NodeMemory
    """The memory of nodes, with the last values of the old region (``remember``)."""
    old_points: ContactPoints | None = None
    """Contact points of the old region; none without contact."""
    new_points: ContactPoints | None = None


def remember(memory: NodeMemory, terms: Sequence[MixedTerm], region: Region) -> NodeMemory:
    """Return a memory that includes the values of the terms of a region at its nodes.

    Raises:
        ParameterError: a term has values that belong neither to nodes nor to contact points.
    """
    for key, term in _keyed(terms):
        for name, array in () if isinstance(term, BodyFriction) else term.carried_arrays().items():
            values = array.numpy()
            if len(values) != len(region.nodes):
                found = f"{term.name}: remembers {len(values)} values"
                raise ParameterError(f"{found}; expected one for each of {len(region.nodes)} nodes: keep the region")
            memory = memory.kept(_named(key, name), region, values)
    return memory


def _named(key: tuple[str, int], name: str) -> str:
    """Name of an array of a term in the memory."""
    return f"{key[0]} {key[1]} {name}"


def carry_terms(old: Sequence[MixedTerm], new: Sequence[MixedTerm], change: RegionChange) -> None:
    """Give to the terms of a new region the remembered values of the terms of the old region.

    Args:
        old: the terms of the old region.
        new: the terms of the new region, as they begin; changed.
        change: both regions, and the memory of nodes.
    """
    remembered = dict(_keyed(old))
    for key, term in _keyed(new):
        own = {name: array.numpy() for name, array in term.carried_arrays().items()}
        if isinstance(term, BodyFriction):
            before = remembered[key].carried_arrays() if key in remembered else {}
            own = {name: _at_points(before[name].numpy(), array, change) for name, array in own.items() if before}
        else:
            own = {name: _at_nodes(_named(key, name), array, change) for name, array in own.items()}
        if own:
            term.carry(own)


def _keyed(terms: Sequence[MixedTerm]) -> list[tuple[tuple[str, int], MixedTerm]]:
    """Each term with its name, and its number among the terms of this name."""
    names = [term.name for term in terms]
    return [((term.name, names[:place].count(term.name)), term) for place, term in enumerate(terms)]


def _at_nodes(name: str, start: NDArray[Any], change: RegionChange) -> NDArray[Any]:
    """One array of a term of the new region: the remembered values of its nodes, or their values at the start."""
    at_rest = np.zeros((len(change.new.node_triangle), *start.shape[1:]))
    at_rest[change.new.nodes] = start
    return change.memory.recalled(name, at_rest)[change.new.nodes]


def _at_points(before: NDArray[Any], start: NDArray[Any], change: RegionChange) -> NDArray[Any]:
    """One array of the friction on bodies: the old values at points that stay, the values at the start elsewhere."""
    result = np.array(start)
    if change.old_points is not None and change.new_points is not None:
        there, here = _same_points(change)
        result[here] = before[there]
    return result


def _same_points(change: RegionChange) -> tuple[IntArray, IntArray]:
    """Numbers in the old and in the new region of the contact points that both have."""
    assert change.old_points is not None
    assert change.new_points is not None
    number = {key: place for place, key in enumerate(_point_keys(change.old_points, change.old))}
    pairs = [(number.get(key, -1), place) for place, key in enumerate(_point_keys(change.new_points, change.new))]
    there, here = np.array(pairs, dtype=np.int64).reshape(-1, 2).T
    kept = there >= 0
    return there[kept], here[kept]


def _point_keys(points: ContactPoints, region: Region) -> list[bytes]:
    """A key for each contact point that is the same in all regions: its vertices or its layout node, and its shares."""
    numbered = np.concatenate([np.arange(points.vertex_count), points.vertex_count + region.nodes])
    shares = np.rint(points.share * 2**20).astype(np.int64)  # all shares are multiples of a power of 1/2
    rows = np.concatenate([numbered[points.index], shares], axis=1)
    return [row.tobytes() for row in np.ascontiguousarray(rows)]


def moved_positions(fabric: MixedFabric, change: RegionChange, positions: MixedVector) -> MixedVector:
    """Return positions for another region.

    Args:
        fabric: cloth and yarns.
        change: the region of the positions and the region of the result. New nodes have the Eulerian coordinates of its
            memory, or of the layout.
        positions: positions [cm].
    """
    stands_out = isinstance(fabric.yarns, SplineYarns)
    above = partial(fabric.yarns.world, fabric.cloth) if stands_out else None
    return _moved(change, positions, change.memory.recalled(SLIDING, fabric.yarns.rest_sliding), above)


def moved_velocities(fabric: MixedFabric, change: RegionChange, velocities: MixedVector) -> MixedVector:
    """Return velocities for another region [cm/s]; the arguments are the same as for ``moved_positions``."""
    return _moved(change, velocities, np.zeros_like(fabric.yarns.rest_sliding), None)


def _moved(
    change: RegionChange,
    vector: MixedVector,
    rest_sliding: FloatArray,
    above: Callable[[FloatArray], FloatArray] | None,
) -> MixedVector:
    state = move_state(change.old, change.new, *vector.numpy(), rest_sliding, above)
    return MixedVector.from_numpy(state.vertices, state.nodes, state.sliding, vector.scalar, vector.device)


def region_change(fabric: MixedFabric, old: Region, new: Region, memory: NodeMemory, loads: Loads) -> RegionChange:
    """Return both regions of a fabric, with the memory of nodes and the contact points that they have under loads."""
    if not loads.bodies:
        return RegionChange(old, new, memory)
    points = [contact_points(fabric, region, loads.thickness)[0] for region in (old, new)]
    return RegionChange(old, new, memory, *points)


def settle_changed(
    fabric: MixedFabric,
    change: RegionChange,
    loads: Loads,
    old_terms: Sequence[MixedTerm],
    positions: MixedVector,
    time_step: float,
) -> None:
    """Let nodes that begin on triangles, and vertices that begin at yarns, move towards their equilibrium.

    The yarns of nodes on flat triangles are bent at the sides of triangles, and stretched like a whole triangle;
    vertices that yarns place stretch their triangles. A step in time from rest removes the energy of this before the
    motion makes waves of it. The step has no gravity and no wind, which move everything together. Nodes whose triangles
    have become hybrid or full move too; all others stay.

    Args:
        fabric: cloth, yarns and materials.
        change: both regions.
        loads: gravity, attachments, bodies and contact.
        old_terms: the terms of the old region, with their memory.
        positions: positions in the new region [cm]; changed.
        time_step: length of the step [s].
    """
    old, new = change.old, change.new
    fixed_vertices, fixed_nodes = fixed_points(loads.held)
    nodes = np.union1d(np.flatnonzero(old.node_kind == new.node_kind), fixed_nodes)
    corners = np.union1d(np.flatnonzero(old.unknown_vertices), fixed_vertices)
    if np.isin(new.nodes, nodes).all() and np.isin(np.flatnonzero(new.unknown_vertices), corners).all():
        return
    stays = Attachment(corners, nodes)
    held = replace(loads, held=[stays], gravity=(0.0, 0.0, 0.0), terms=())
    system = loaded_system(
        fabric, change.new, held, scalar=positions.scalar, device=positions.device, always_held=loads.held
    )
    carry_terms(old_terms, system.terms, change)
    # three iterations bring new nodes near to their equilibrium
    settings = EquilibriumSettings(most_iterations=3, first_time_step=time_step, longest_time_step=time_step)
    find_equilibrium(system, positions, settings)


def place_held(system: MixedSystem, motion: PrescribedMotion, positions: MixedVector, time: float) -> None:
    """Move attached nodes and vertices to their place at a time, and let the hybrid nodes and vertices follow.

    Args:
        system: the system.
        motion: the motion of the attachments.
        positions: positions [cm]; changed.
        time: the time [s].
    """
    present, places = positions.numpy(), motion.places(time)
    moves = [np.zeros_like(part) for part in present]
    for part, fixed in ((0, motion.fixed_vertices), (1, motion.fixed_nodes)):
        moves[part][fixed] = places[part][fixed] - present[part][fixed]
    vertices, nodes, sliding = moves
    wanted = MixedVector.from_numpy(vertices, nodes, sliding, system.scalar, system.device)
    choose(wanted, system.moves, wanted.like(), wanted)
    system.make_motion(wanted)
    set_sum(positions, 1.0, positions, 1.0, wanted)


Moving = tuple[MixedSystem, MixedVector, MixedVector]
"""A system, its positions [cm] and its velocities [cm/s]."""


def keep_momentum(before: Moving, after: Moving) -> None:
    """Change the velocities of a system so that it keeps the momentum that the cloth had before a change.

    Args:
        before: the system before the change.
        after: the system after it; its velocities are changed.
    """
    centre = before[1].numpy()[0].mean(axis=0)
    for system, positions, _velocities in (before, after):
        system.update_masses(positions)
    give_momentum(*after, centre, momentum_about(*before, centre))


def momentum_about(
    system: MixedSystem, positions: MixedVector, velocities: MixedVector, centre: NDArray[np.float64]
) -> Numbers:
    """Linear momentum [g cm/s] and angular momentum about a centre [g cm^2/s], shape (6,).

    Args:
        system: the system, with its masses at the positions of the last ``update_masses``.
        positions: positions [cm].
        velocities: velocities [cm/s].
        centre: the centre [cm], shape (3,).
    """
    product = system.zeros()
    system.set_mass_product(velocities, product)
    amount = np.concatenate(product.numpy()[:2])
    arm = np.concatenate(positions.numpy()[:2]) - centre
    return np.concatenate([amount.sum(axis=0), np.cross(arm, amount).sum(axis=0)])


def give_momentum(
    system: MixedSystem,
    positions: MixedVector,
    velocities: MixedVector,
    centre: NDArray[np.float64],
    expected: Numbers,
) -> None:
    """Add the rigid motion with which the velocities have the expected momentum.

    Args:
        system: the system.
        positions: positions [cm].
        velocities: velocities [cm/s]; changed.
        centre: centre of the angular momentum [cm], shape (3,).
        expected: linear and angular momentum, shape (6,), as ``momentum_about`` returns them.
    """
    rigid = [_rigid_motion(system, positions, centre, number) for number in range(6)]
    matrix = np.stack([momentum_about(system, positions, each, centre) for each in rigid], axis=1)
    missing = expected - momentum_about(system, positions, velocities, centre)
    amount = np.linalg.lstsq(matrix, missing, rcond=None)[0]
    for part, motion in zip(amount.tolist(), rigid, strict=True):
        set_sum(velocities, 1.0, velocities, part, motion)


def _rigid_motion(system: MixedSystem, positions: MixedVector, centre: Numbers, number: int) -> MixedVector:
    """Translation along an axis (0 to 2), or rotation about it (3 to 5), of the free coordinates."""
    axis = np.eye(3)[number % 3]
    places = positions.numpy()[:2]
    v, p = (np.tile(axis, (len(part), 1)) if number < 3 else np.cross(axis, part - centre) for part in places)
    motion = MixedVector.from_numpy(v, p, np.zeros((len(p), 2)), system.scalar, system.device)
    choose(motion, system.moves, motion, motion.like())
    system.make_motion(motion)
    return motion
