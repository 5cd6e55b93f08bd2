# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Render yarns like a photograph: a USD file of `stitchmesh convert` in wool, drawn by Cycles in Blender.

    stitchmesh convert out/sweater/yarns.h5 out/sweater.usdc
    blender -b -P examples/blender_render.py -- out/sweater.usdc out/sweater.png

Blender's own Python runs this program; without an installed Blender, `pip install bpy` in an environment of its own
and `python examples/blender_render.py out/sweater.usdc out/sweater.png` do the same. The module bpy is part of Blender
(GPL), and StitchMesh does not depend on it. docs/how-to/blender.md describes the options.

Yarns come in with the apparent radius and the colours that the file holds. A yarn is drawn as plies that are twisted
about each other, with fine fibres that stand off, in a material with the sheen of wool.
"""

from __future__ import annotations

import argparse
import math
import sys
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix, Vector

CENTIMETRE = 0.01
"""One centimetre in the unit of Blender [m]."""
POINTS_OF_SEGMENT = 3
"""Points on the curve for each segment of a B-spline; Cycles connects points, and does not evaluate the spline."""
PLIES = 3
"""Plies that are twisted about each other."""
TURN = 8.0
"""Length of yarn in which the plies turn once, over the diameter of the yarn."""
PLY_RADIUS, PLY_OFFSET = 0.56, 0.47
"""Radius of a ply, and distance of its axis from that of the yarn, over the radius of the yarn; soft plies overlap."""
FIBRE_RADIUS = 0.016
"""Radius of a fibre that stands off, over the radius of the yarn."""
WOOL = "wool"
"""Attribute of each curve that holds its colour."""
STOCK_COLOUR = (0.60, 0.52, 0.42)
"""Colour of yarn in a file without colours (linear)."""
BACKDROP = (0.62, 0.60, 0.57)
"""Colour of the wall behind the yarns (linear)."""
LAMPS = (
    ("key", (-0.8, 0.9, 0.7), 0.30, 40.0),
    ("fill", (1.1, 0.0, 0.9), 1.2, 5.0),
    ("rim", (0.9, 0.8, -0.1), 0.4, 12.0),
)
"""Lamps: direction from the yarns (right, up and toward the camera), size over that of the yarns, and power."""
FIELD_OF_VIEW = math.radians(24.0)
"""Horizontal angle of view of the camera; a long lens, as for a portrait."""


def main(words: list[str]) -> None:
    """Read the file, add material, fibres, light and camera, and render."""
    given = parse(words)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.usd_import(filepath=str(given.yarns.resolve()))
    objects = [thing for thing in bpy.data.objects if thing.type == "CURVES"]
    if not objects:
        sys.exit(f"{given.yarns}: holds no curves; write it by `stitchmesh convert YARNS.h5 OUT.usdc`")
    bpy.context.view_layer.update()
    yarns = [yarn for thing in objects for yarn in yarns_of(thing, given.colour)]
    drawn = [add_plies(yarns), *([add_fibres(yarns, given.fibres)] if given.fibres > 0.0 else [])]
    for thing in drawn:
        thing.data.materials.append(wool_material(yarns[0].radius))
        thing.matrix_world = objects[0].matrix_world
    low, high = bounds(objects)
    for thing in objects:
        bpy.data.objects.remove(thing)
    camera = add_camera(low, high, given)
    add_light(low, high, camera)
    add_wall(low, high, camera)
    render(given)


def parse(words: list[str]) -> argparse.Namespace:
    """Return the options."""
    parser = argparse.ArgumentParser(prog="blender_render.py", description=__doc__.splitlines()[0])
    parser.add_argument("yarns", type=Path, help="USD file of yarns")
    parser.add_argument("picture", type=Path, help="PNG or JPG file to write")
    parser.add_argument("--size", type=int, nargs=2, default=(900, 600), metavar=("W", "H"), help="pixels")
    parser.add_argument("--samples", type=int, default=48, help="light paths for each pixel")
    parser.add_argument("--azimuth", type=float, default=12.0, help="camera to the right of the front [degrees]")
    parser.add_argument("--elevation", type=float, default=6.0, help="camera above the middle [degrees]")
    parser.add_argument("--zoom", type=float, default=1.0, help="1 shows everything, 4 a quarter of the width")
    parser.add_argument("--at", type=float, nargs=3, metavar=("X", "Y", "Z"), help="point to look at [cm]")
    parser.add_argument("--colour", metavar="#RRGGBB", help="one colour for all yarns; by default those of the file")
    parser.add_argument("--fibres", type=float, default=12.0, help="fibres that stand off, for each cm of yarn")
    return parser.parse_args(words)


@dataclass(frozen=True)
class Yarn:
    """A yarn as points on its curve, in centimetres; a closed yarn repeats its first point."""

    points: np.ndarray
    radius: float
    colour: np.ndarray


def yarns_of(thing: bpy.types.Object, colour: str | None) -> list[Yarn]:
    """Return the yarns of a curves object, in the given colour (#rrggbb) or in those of the file."""
    data = thing.data
    points, radius = values(data, "position", 3), values(data, "radius", 1)[:, 0]
    closed = values(data, "cyclic", 1)[:, 0] if "cyclic" in data.attributes else np.zeros(len(data.curves))
    if colour is None and "displayColor" in data.attributes:
        colours = values(data, "displayColor", 4)[:, :3]
    else:
        colours = np.tile(linear(colour) if colour else STOCK_COLOUR, (len(data.curves), 1))
    found = []
    for number, curve in enumerate(data.curves):
        first = curve.first_point_index
        own = slice(first, first + curve.points_length)
        found.append(Yarn(on_spline(points[own], bool(closed[number])), float(radius[own].mean()), colours[number]))
    return found


def values(data: bpy.types.HairCurves, name: str, columns: int) -> np.ndarray:
    """Return an attribute of the points or of the curves, shape (n, columns)."""
    found = data.attributes[name].data
    numbers = np.empty(len(found) * columns, dtype=bool if name == "cyclic" else np.float32)
    found.foreach_get({1: "value", 3: "vector", 4: "color"}[columns], numbers)
    return numbers.reshape(-1, columns)


def on_spline(control: np.ndarray, closed: bool) -> np.ndarray:
    """Return points on the uniform cubic B-spline of some control points, shape (n, 3)."""
    s = np.arange(POINTS_OF_SEGMENT)[:, None] / POINTS_OF_SEGMENT
    weights = np.hstack([(1 - s) ** 3, 3 * s**3 - 6 * s**2 + 4, -3 * s**3 + 3 * s**2 + 3 * s + 1, s**3]) / 6.0
    count = len(control) if closed else len(control) - 3
    corners = control[(np.arange(count)[:, None] + np.arange(4)) % len(control)]
    points = np.einsum("kj,sjd->skd", weights, corners).reshape(-1, 3)
    end = points[:1] if closed else np.array([[0.0, 1.0, 4.0, 1.0]]) @ corners[-1] / 6.0
    return np.concatenate([points, end])


def add_plies(yarns: list[Yarn]) -> bpy.types.Object:
    """Add the plies of all yarns as curves."""
    curves, radii, colours = [], [], []
    for yarn in yarns:
        side, other = frames(yarn.points)
        length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(yarn.points, axis=0), axis=1))])
        for ply in range(PLIES):
            angle = 2.0 * math.pi * (length / (TURN * 2.0 * yarn.radius) + ply / PLIES)
            out = np.cos(angle)[:, None] * side + np.sin(angle)[:, None] * other
            curves.append(yarn.points + PLY_OFFSET * yarn.radius * out)
            radii.append(np.full(len(out), PLY_RADIUS * yarn.radius))
            colours.append(yarn.colour)
    return add_curves("plies", curves, radii, colours)


def frames(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return two directions across a curve at each point, which turn as little as possible along the curve."""
    along = np.gradient(points, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    side, sides = Vector(along[0]).orthogonal(), []
    for tangent in map(Vector, along):
        side = (side - side.dot(tangent) * tangent).normalized()
        sides.append(side)
    across = np.array(sides)
    return across, np.cross(along, across)


def add_fibres(yarns: list[Yarn], per_centimetre: float) -> bpy.types.Object:
    """Add thin curves that leave the yarns at random places and in random directions."""
    random = np.random.default_rng(1)
    curves, radii, colours = [], [], []
    for yarn in yarns:
        step = np.diff(yarn.points, axis=0)
        count = int(per_centimetre * np.linalg.norm(step, axis=1).sum())
        start = random.integers(len(step), size=count)
        along = step[start] / np.linalg.norm(step[start], axis=1, keepdims=True)
        out = np.cross(along, random.normal(size=(count, 3)))
        out /= np.linalg.norm(out, axis=1, keepdims=True)
        lean = along * random.normal(size=(count, 1))
        reach = yarn.radius * (0.2 + random.exponential(0.35, (count, 1)))
        root = yarn.points[start] + random.random((count, 1)) * step[start] + 0.9 * yarn.radius * out
        bent = root + (0.6 * out + lean) * reach + random.normal(scale=0.3, size=(count, 3)) * reach
        end = bent + (0.2 * out + 1.5 * lean) * reach + random.normal(scale=0.6, size=(count, 3)) * reach
        curves += list(np.stack([root, bent, end], axis=1))
        radii += [FIBRE_RADIUS * yarn.radius * np.array([1.0, 0.8, 0.4])] * count
        colours += [yarn.colour] * count
    return add_curves("fibres", curves, radii, colours)


def add_curves(name: str, curves: list, radii: list, colours: list) -> bpy.types.Object:
    """Add an object of curves: the points and the radii along each curve [cm], and the colour of each curve."""
    data = bpy.data.hair_curves.new(name)
    data.add_curves([len(curve) for curve in curves])
    data.attributes["position"].data.foreach_set("vector", np.concatenate(curves).astype(np.float32).ravel())
    radius = data.attributes.get("radius") or data.attributes.new("radius", "FLOAT", "POINT")
    radius.data.foreach_set("value", np.concatenate(radii).astype(np.float32))
    colour = np.hstack([np.array(colours), np.ones((len(colours), 1))])
    data.attributes.new(WOOL, "FLOAT_COLOR", "CURVE").data.foreach_set("color", colour.astype(np.float32).ravel())
    thing = bpy.data.objects.new(name, data)
    bpy.context.collection.objects.link(thing)
    return thing


def wool_material(radius: float) -> bpy.types.Material:
    """Return the material of wool: matt, with sheen, and with dye and surface that vary along the yarn."""
    material = bpy.data.materials.new(WOOL)
    material.use_nodes = True
    tree = material.node_tree
    new, link, surface = tree.nodes.new, tree.links.new, tree.nodes["Principled BSDF"]
    looks = {"Roughness": 0.9, "Specular IOR Level": 0.2, "Sheen Weight": 0.4, "Sheen Roughness": 0.5}
    for name, value in looks.items():
        surface.inputs[name].default_value = value
    dye, place, shade = new("ShaderNodeAttribute"), new("ShaderNodeTexCoord"), new("ShaderNodeHueSaturation")
    dye.attribute_name = WOOL
    blotch, grain, bump = new("ShaderNodeTexNoise"), new("ShaderNodeTexNoise"), new("ShaderNodeBump")
    for noise, size in ((blotch, 2.0 * radius), (grain, 0.12 * radius)):
        noise.inputs["Scale"].default_value = 1.0 / size
        link(place.outputs["Object"], noise.inputs["Vector"])
    brightness = new("ShaderNodeMath")
    brightness.operation = "MULTIPLY_ADD"
    brightness.inputs[1].default_value, brightness.inputs[2].default_value = 0.5, 0.75
    link(blotch.outputs[0], brightness.inputs[0])
    link(brightness.outputs[0], shade.inputs["Value"])
    link(dye.outputs["Color"], shade.inputs["Color"])
    link(shade.outputs[0], surface.inputs["Base Color"])
    bump.inputs["Distance"].default_value = 0.1 * radius * CENTIMETRE
    link(grain.outputs[0], bump.inputs["Height"])
    link(bump.outputs[0], surface.inputs["Normal"])
    return material


def bounds(objects: list[bpy.types.Object]) -> tuple[Vector, Vector]:
    """Return the lowest and the highest corner of the bounding box of all objects [m]."""
    corners = [thing.matrix_world @ Vector(corner) for thing in objects for corner in thing.bound_box]
    return (Vector(min(c[k] for c in corners) for k in range(3)), Vector(max(c[k] for c in corners) for k in range(3)))


def add_camera(low: Vector, high: Vector, given: argparse.Namespace) -> bpy.types.Object:
    """Add a camera that sees the whole box, or a part of it."""
    middle, size = (low + high) / 2.0, high - low
    if given.at is not None:
        x, y, z = given.at
        middle = Vector((x, -z, y)) * CENTIMETRE
    azimuth, elevation = math.radians(given.azimuth), math.radians(given.elevation)
    toward = Vector((math.sin(azimuth) * math.cos(elevation), -math.cos(azimuth) * math.cos(elevation),
                     math.sin(elevation)))  # fmt: skip
    wide = abs(math.cos(azimuth)) * size.x + abs(math.sin(azimuth)) * size.y
    tall = size.z * math.cos(elevation) + size.y * abs(math.sin(elevation))
    width = 1.04 * max(wide, tall * given.size[0] / given.size[1]) / given.zoom
    distance = width / 2.0 / math.tan(FIELD_OF_VIEW / 2.0) + size.y / 2.0
    data = bpy.data.cameras.new("camera")
    data.sensor_fit, data.angle, data.clip_start, data.clip_end = "HORIZONTAL", FIELD_OF_VIEW, 0.001, 100.0
    camera = bpy.data.objects.new("camera", data)
    camera.matrix_world = looking(middle + distance * toward, middle)
    bpy.context.collection.objects.link(camera)
    bpy.context.scene.camera = camera
    return camera


def looking(place: Vector, target: Vector) -> Matrix:
    """Return the placement of a camera or a lamp that looks at a target."""
    return Matrix.Translation(place) @ (target - place).to_track_quat("-Z", "Y").to_matrix().to_4x4()


def add_light(low: Vector, high: Vector, camera: bpy.types.Object) -> None:
    """Add the light of a studio: a strong lamp from the upper left, weak ones from the right, and a bright room."""
    middle, reach = (low + high) / 2.0, (high - low).length
    for name, direction, width, power in LAMPS:
        data = bpy.data.lights.new(name, "AREA")
        data.size, data.energy = width * reach, power * reach**2
        lamp = bpy.data.objects.new(name, data)
        place = camera.matrix_world.to_3x3() @ Vector(direction) * reach
        lamp.matrix_world = looking(middle + place, middle)
        bpy.context.collection.objects.link(lamp)
    world = bpy.data.worlds.new("room")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.85, 0.9, 1.0, 1.0)
    world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.16
    bpy.context.scene.world = world


def add_wall(low: Vector, high: Vector, camera: bpy.types.Object) -> None:
    """Add a wall behind the yarns, parallel to the picture."""
    middle, reach = (low + high) / 2.0, (high - low).length
    bpy.ops.mesh.primitive_plane_add(size=20.0 * reach)
    wall = bpy.context.object
    back = camera.matrix_world.to_3x3() @ Vector((0.0, 0.0, -0.30)) * reach
    wall.matrix_world = Matrix.Translation(middle + back) @ camera.matrix_world.to_3x3().to_4x4()
    material = bpy.data.materials.new("wall")
    material.use_nodes = True
    surface = material.node_tree.nodes["Principled BSDF"]
    surface.inputs["Base Color"].default_value = (*BACKDROP, 1.0)
    surface.inputs["Roughness"].default_value = 1.0
    wall.data.materials.append(material)


def linear(colour: str) -> tuple[float, float, float]:
    """Return the linear values of a colour ``#rrggbb``."""
    values = [int(colour.lstrip("#")[k : k + 2], 16) / 255.0 for k in (0, 2, 4)]
    return tuple(v / 12.92 if v <= 0.04045 else ((v + 0.055) / 1.055) ** 2.4 for v in values)


def render(given: argparse.Namespace) -> None:
    """Render the scene by Cycles on the CPU, without noise, and write the picture."""
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.seed = given.samples, True, 1
    scene.cycles_curves.shape, scene.cycles_curves.subdivisions = "THICK", 2
    scene.render.resolution_x, scene.render.resolution_y = given.size
    scene.view_settings.view_transform = "AgX"
    scene.view_settings.look = "AgX - Medium High Contrast"
    jpeg = given.picture.suffix.lower() in (".jpg", ".jpeg")
    scene.render.image_settings.file_format = "JPEG" if jpeg else "PNG"
    scene.render.image_settings.quality = 88
    scene.render.filepath = str(given.picture.resolve())
    bpy.ops.render.render(write_still=True)


if __name__ == "__main__":
    main(sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else sys.argv[1:])
