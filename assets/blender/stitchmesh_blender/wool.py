# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The look of wool: a modifier of nodes that twists plies and lets fibres stand off, and a material of nodes."""

from __future__ import annotations

import math

import bpy

MODIFIER, GROUP, MATERIAL = "StitchMesh wool", "StitchMesh wool", "StitchMesh wool"
"""Names of the modifier, of its group of nodes, and of the material."""
PLIES, TURN, FIBRES = 3, 8.0, 4.0
"""Plies of a yarn, length in which they turn once, and fibres that stand off; a length is a diameter of the yarn."""
PLY_RADIUS, PLY_OFFSET = 0.56, 0.47
"""Radius of a ply, and distance of its axis from that of the yarn, over the radius of the yarn; soft plies overlap."""
FIBRE_RADIUS, FIBRE_REACH = 0.02, (1.0, 2.6)
"""Radius of a fibre, and least and largest distance of its end from the axis, over the radius of the yarn."""
YARN_RADIUS = "yarn_radius"
"""Attribute of fibres: the radius of their yarn."""
LOOKS = {"Roughness": 0.9, "Specular IOR Level": 0.2, "Sheen Weight": 0.4, "Sheen Roughness": 0.5}
"""Values of the material."""


def add_wool(yarns: bpy.types.Object, radius: float) -> None:
    """Give yarns the material and the modifier, whose settings can be changed.

    Args:
        yarns: an object of curves.
        radius: radius of the yarns in the unit of the scene; the grain of the material follows it.
    """
    material = _wool_material(radius)
    yarns.data.materials.append(material)
    modifier = yarns.modifiers.new(MODIFIER, "NODES")
    modifier.node_group = bpy.data.node_groups.get(GROUP) or _wool_group()


class _Tree:
    """A tree of nodes that is being made."""

    def __init__(self, tree: bpy.types.NodeTree) -> None:
        self.tree = tree

    def node(self, kind: str, **values: object) -> bpy.types.Node:
        """Return a new node with the given properties."""
        node = self.tree.nodes.new(kind)
        for name, value in values.items():
            setattr(node, name, value)
        return node

    def give(self, node: bpy.types.Node, **inputs: object) -> bpy.types.Node:
        """Set inputs of a node, by their identifiers, to values or to the outputs of other nodes; returns the node."""
        sockets = {socket.identifier: socket for socket in node.inputs}
        for name, value in inputs.items():
            if isinstance(value, bpy.types.NodeSocket):
                self.tree.links.new(value, sockets[name])
            else:
                sockets[name].default_value = value
        return node

    def math(self, operation: str, first: object, second: object = 0.0) -> bpy.types.NodeSocket:
        """Return the result of an operation on numbers."""
        return self.give(self.node("ShaderNodeMath", operation=operation), Value=first, Value_001=second).outputs[0]

    def vector(self, operation: str, first: object, second: object) -> bpy.types.NodeSocket:
        """Return the result of an operation on vectors; the second operand of SCALE is a number."""
        other = {"Scale" if operation == "SCALE" else "Vector_001": second}
        return self.give(self.node("ShaderNodeVectorMath", operation=operation), Vector=first, **other).outputs[0]


def _wool_group() -> bpy.types.NodeTree:
    """Return the group of nodes that makes plies and fibres of yarns."""
    group = bpy.data.node_groups.new(GROUP, "GeometryNodeTree")
    group.is_modifier = True
    face = group.interface
    face.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
    face.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    for name, kind, value, least in (
        ("Plies", "NodeSocketInt", PLIES, 1), ("Turn (diameters)", "NodeSocketFloat", TURN, 0.5),
        ("Fibres per diameter", "NodeSocketFloat", FIBRES, 0.0),
    ):  # fmt: skip
        socket = face.new_socket(name, in_out="INPUT", socket_type=kind)
        socket.default_value, socket.min_value = value, least
    tree = _Tree(group)
    start, end = tree.node("NodeGroupInput"), tree.node("NodeGroupOutput")
    joined = tree.node("GeometryNodeJoinGeometry")
    for geometry in (_fibres(tree, start), _plies(tree, start)):
        group.links.new(geometry, joined.inputs[0])
    group.links.new(joined.outputs[0], end.inputs[0])
    return group


def _plies(tree: _Tree, start: bpy.types.Node) -> bpy.types.NodeSocket:
    """Return the plies: copies of each yarn, at an angle around it that grows with the length along it.

    The plies turn a whole number of times, so that those of a closed yarn meet where it closes.
    """
    yarn, plies, turn = start.outputs[0], start.outputs[1], start.outputs[2]
    copies = tree.give(
        tree.node("GeometryNodeDuplicateElements", domain="SPLINE"), Geometry=yarn, Amount=plies
    )  # fmt: skip
    radius = tree.node("GeometryNodeInputRadius").outputs[0]
    whole = tree.node("GeometryNodeSplineLength").outputs["Length"]
    lay = tree.math("MULTIPLY", tree.math("MULTIPLY", turn, 2.0), radius)
    turns = tree.math("ROUND", tree.math("DIVIDE", whole, lay))
    place = tree.math("MULTIPLY", turns, tree.node("GeometryNodeSplineParameter").outputs["Factor"])
    angle = tree.math(
        "MULTIPLY", tree.math("ADD", place, tree.math("DIVIDE", copies.outputs[1], plies)), 2.0 * math.pi
    )
    normal = tree.node("GeometryNodeInputNormal").outputs[0]
    across = tree.vector("CROSS_PRODUCT", tree.node("GeometryNodeInputTangent").outputs[0], normal)
    out = tree.vector(
        "ADD",
        tree.vector("SCALE", normal, tree.math("COSINE", angle)),
        tree.vector("SCALE", across, tree.math("SINE", angle)),
    )
    several = tree.math("GREATER_THAN", plies, 1.0)
    offset = tree.vector("SCALE", out, tree.math("MULTIPLY", tree.math("MULTIPLY", radius, PLY_OFFSET), several))
    moved = tree.give(tree.node("GeometryNodeSetPosition"), Geometry=copies.outputs[0], Offset=offset)
    size = tree.math("SUBTRACT", 1.0, tree.math("MULTIPLY", several, 1.0 - PLY_RADIUS))
    thin = tree.give(
        tree.node("GeometryNodeSetCurveRadius"), Curve=moved.outputs[0], Radius=tree.math("MULTIPLY", radius, size)
    )
    return thin.outputs[0]


def _fibres(tree: _Tree, start: bpy.types.Node) -> bpy.types.NodeSocket:
    """Return the fibres: bent thin curves from the axis of the yarn, at equal distances and in random directions."""
    yarn, density = start.outputs[0], start.outputs[3]
    radius = tree.node("GeometryNodeInputRadius").outputs[0]
    diameter = tree.math("MULTIPLY", radius, 2.0)
    distance = tree.math("DIVIDE", diameter, tree.math("MAXIMUM", density, 1e-3))
    points = tree.give(tree.node("GeometryNodeCurveToPoints", mode="LENGTH"), Curve=yarn, Length=distance)
    known = tree.give(
        tree.node("GeometryNodeStoreNamedAttribute", data_type="FLOAT", domain="POINT"),
        Geometry=points.outputs[0], Name=YARN_RADIUS, Value=radius,
    )  # fmt: skip
    bow = tree.give(
        tree.node("GeometryNodeCurveQuadraticBezier"),
        Resolution=3, Start=(0.0, 0.0, 0.0), Middle=(0.0, 0.1, 0.75), End=(0.0, 0.75, 0.9),
    )  # fmt: skip
    turn = tree.give(
        tree.node("FunctionNodeRandomValue", data_type="FLOAT_VECTOR"), Min=(-math.pi,) * 3, Max=(math.pi,) * 3
    )
    low, high = FIBRE_REACH
    random = tree.give(tree.node("FunctionNodeRandomValue"), Min_001=low, Max_001=high, Seed=1)
    reach = next(socket for socket in random.outputs if socket.enabled)
    placed = tree.give(
        tree.node("GeometryNodeInstanceOnPoints"),
        Points=known.outputs[0], Selection=tree.math("GREATER_THAN", density, 0.0), Instance=bow.outputs[0],
        Rotation=turn.outputs[0], Scale=tree.math("MULTIPLY", radius, reach),
    )  # fmt: skip
    curves = tree.give(tree.node("GeometryNodeRealizeInstances"), Geometry=placed.outputs[0])
    thin = tree.node("GeometryNodeSetCurveRadius")
    named = tree.give(tree.node("GeometryNodeInputNamedAttribute", data_type="FLOAT"), Name=YARN_RADIUS).outputs[0]
    tree.give(thin, Curve=curves.outputs[0], Radius=tree.math("MULTIPLY", named, FIBRE_RADIUS))
    return thin.outputs[0]


def _wool_material(radius: float) -> bpy.types.Material:
    """Return a new material: matt, with sheen, with the colour of the yarn, and a surface that varies."""
    material = bpy.data.materials.new(MATERIAL)
    material.use_nodes = True
    tree = _Tree(material.node_tree)
    surface = tree.tree.nodes["Principled BSDF"]
    tree.give(surface, **{s.identifier: LOOKS[s.name] for s in surface.inputs if s.name in LOOKS})
    dye = tree.node("ShaderNodeAttribute", attribute_name="wool").outputs["Color"]
    place = tree.node("ShaderNodeTexCoord").outputs["Object"]
    blotch, grain = (
        tree.give(tree.node("ShaderNodeTexNoise"), Vector=place, Scale=1.0 / size).outputs[0]
        for size in (2.0 * radius, 0.12 * radius)
    )
    brightness = tree.math("ADD", tree.math("MULTIPLY", blotch, 0.5), 0.75)
    shade = tree.give(tree.node("ShaderNodeHueSaturation"), Value=brightness, Color=dye).outputs[0]
    bump = tree.give(tree.node("ShaderNodeBump"), Distance=0.1 * radius, Height=grain).outputs[0]
    tree.give(surface, **{"Base Color": shade, "Normal": bump})
    return material
