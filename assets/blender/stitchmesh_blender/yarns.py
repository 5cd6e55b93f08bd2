# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The mesh that leaves Blender, and the yarns that come back."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix

from .curves import length_along, nearest_control, on_spline
from .program import ProgramError, write_obj
from .wool import add_wool

YARNS_OF = "stitchmesh_yarns_of"
"""Property of an object of yarns: the object of which they were knitted."""
KINDS = {"FLOAT": ("value", 1, np.float32), "INT": ("value", 1, np.int32), "BOOLEAN": ("value", 1, bool),
         "FLOAT_VECTOR": ("vector", 3, np.float32), "FLOAT_COLOR": ("color", 4, np.float32)}  # fmt: skip
"""Types of attributes: the name of a value, its numbers, and their type."""
LABELS = {"row": "row", "face": "stitch", "part": "part"}
"""Labels of points in the file, and the names of their attributes in Blender."""
OF_YARN = {"yarn": "yarn", "colour": "colour", "displayColor": "wool"}
"""Attributes of curves in the file, and their names in Blender."""


def write_garment(path: Path, garment: bpy.types.Object, context: bpy.types.Context) -> None:
    """Write the mesh of an object as it is seen: with its modifiers, in the place where it stands, in metres.

    Raises:
        ProgramError: the mesh has no faces.
    """
    seen = garment.evaluated_get(context.evaluated_depsgraph_get())
    mesh = seen.to_mesh()
    try:
        vertices = _filled(mesh.vertices, "co", 3, np.float32)
        turn = np.array(seen.matrix_world) * context.scene.unit_settings.scale_length
        placed = vertices.astype(np.float64) @ turn[:3, :3].T + turn[:3, 3]
        corners = _filled(mesh.loops, "vertex_index", 1, np.int32)[:, 0]
        write_obj(path, placed, corners, _filled(mesh.polygons, "loop_total", 1, np.int32)[:, 0])
    finally:
        seen.to_mesh_clear()


def read_yarns(path: Path, garment: bpy.types.Object, context: bpy.types.Context) -> bpy.types.Object:
    """Read the yarns of a file, put them on a garment in the place of its former ones, and return their object.

    Former yarns give up their curves only: what the user has changed in the material and the modifier stays.

    Raises:
        ProgramError: Blender finds no curves in the file.
    """
    imported = _imported(path)
    try:
        curves = [thing for thing in imported if thing.type == "CURVES"]
        if not curves:
            raise ProgramError(f"{path.name}: Blender {bpy.app.version_string} found no curves in it; update Blender")
        context.view_layer.update()
        data = _joined(f"{garment.name} yarns", curves, 1.0 / context.scene.unit_settings.scale_length)
    finally:
        for thing in imported:
            data_of_import = thing.data
            bpy.data.objects.remove(thing)
            _remove_unused(data_of_import)
    yarns = next((thing for thing in bpy.data.objects if thing.get(YARNS_OF) == garment), None)
    if yarns is None:
        yarns = _new_yarns(garment, data)
    else:
        _replace_curves(yarns, data)
    yarns.parent, yarns.matrix_parent_inverse = garment, garment.matrix_world.inverted_safe()
    yarns.matrix_basis = Matrix.Identity(4)
    garment.hide_render, garment.display_type = True, "WIRE"
    _choose(garment, context)
    return yarns


def _new_yarns(garment: bpy.types.Object, data: bpy.types.Curves) -> bpy.types.Object:
    """Return a new object of yarns, in wool, in the collections of the garment."""
    yarns = bpy.data.objects.new(data.name, data)
    yarns[YARNS_OF] = garment
    for collection in garment.users_collection:
        collection.objects.link(yarns)
    add_wool(yarns, float(_values(data, "radius").mean()))
    return yarns


def _replace_curves(yarns: bpy.types.Object, data: bpy.types.Curves) -> None:
    """Give an object of yarns new curves with the materials of its former ones, which are removed."""
    former = yarns.data
    for material in former.materials:
        data.materials.append(material)
    yarns.data = data
    _remove_unused(former)


def _remove_unused(data: bpy.types.ID | None) -> None:
    """Remove curves that no object uses any more."""
    if isinstance(data, bpy.types.Curves) and data.users == 0:
        bpy.data.hair_curves.remove(data)


def _choose(garment: bpy.types.Object, context: bpy.types.Context) -> None:
    """Make the garment the active object again, which the import has changed, so that it can be knitted once more."""
    if garment.name in context.view_layer.objects:
        garment.select_set(True)
        context.view_layer.objects.active = garment


def _imported(path: Path) -> list[bpy.types.Object]:
    """Return the objects that Blender makes of a USD file."""
    before = set(bpy.data.objects)
    bpy.ops.wm.usd_import(
        filepath=str(path), import_materials=False, set_frame_range=False, import_cameras=False, import_lights=False
    )
    return [thing for thing in bpy.data.objects if thing not in before]


def _joined(name: str, objects: list[bpy.types.Object], scale: float) -> bpy.types.Curves:
    """Return the curves of some objects as points on their B-splines, in the world and in the unit of the scene."""
    points, radii, lengths, sizes = [], [], [], []
    labels: dict[str, list[np.ndarray]] = {}
    own: dict[str, list[np.ndarray]] = {}
    for thing in objects:
        data, turn = thing.data, np.array(thing.matrix_world, dtype=np.float64) * scale
        control = _values(data, "position").astype(np.float64) @ turn[:3, :3].T + turn[:3, 3]
        size = np.cbrt(np.linalg.det(turn[:3, :3]))
        radius, closed = _values(data, "radius")[:, 0] * size, _values(data, "cyclic")[:, 0]
        for number, curve in enumerate(data.curves):
            part = slice(curve.first_point_index, curve.first_point_index + curve.points_length)
            chosen = part.start + nearest_control(curve.points_length, bool(closed[number]))
            points.append(on_spline(control[part], bool(closed[number])))
            radii.append(radius[chosen])
            lengths.append(length_along(points[-1]))
            sizes.append(len(points[-1]))
            for label, title in LABELS.items():
                labels.setdefault(title, []).append(_values(data, label)[chosen])
        for label, title in OF_YARN.items():
            own.setdefault(title, []).append(_values(data, label))
    joined = bpy.data.hair_curves.new(name)
    joined.add_curves(sizes)
    _set(joined, "position", "FLOAT_VECTOR", "POINT", np.concatenate(points))
    _set(joined, "radius", "FLOAT", "POINT", np.concatenate(radii))
    _set(joined, "length", "FLOAT", "POINT", np.concatenate(lengths))
    for title, values in labels.items():
        _set(joined, title, "INT", "POINT", np.concatenate(values))
    for title, values in own.items():
        _set(joined, title, "FLOAT_COLOR" if title == "wool" else "INT", "CURVE", np.concatenate(values))
    return joined


def _values(data: bpy.types.Curves, name: str) -> np.ndarray:
    """Return an attribute of points or curves, shape (n, numbers of a value)."""
    attribute = data.attributes[name]
    value, columns, kind = KINDS[attribute.data_type]
    return _filled(attribute.data, value, columns, kind)


def _filled(items: bpy.types.bpy_prop_collection, name: str, columns: int, kind: type) -> np.ndarray:
    """Return a property of all items, shape (n, columns)."""
    numbers = np.empty(len(items) * columns, dtype=kind)
    items.foreach_get(name, numbers)
    return numbers.reshape(-1, columns)


def _set(data: bpy.types.Curves, name: str, kind: str, domain: str, values: np.ndarray) -> None:
    """Set an attribute, which is made if the curves lack it."""
    attribute = data.attributes.get(name) or data.attributes.new(name, kind, domain)
    value, _, dtype = KINDS[kind]
    attribute.data.foreach_set(value, np.ascontiguousarray(values, dtype=dtype).ravel())
