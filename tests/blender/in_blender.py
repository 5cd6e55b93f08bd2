# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Use the installed add-on as a script does, and print what it made as JSON. A Python with the module bpy runs this.

    python in_blender.py FOLDER_OF_THE_ADD_ON MESH.obj PROGRAM OUT.json
"""

from __future__ import annotations

import json
import os
import sys
import traceback
from pathlib import Path

import bpy
import numpy as np
from mathutils import Euler, Matrix, Vector


def main(addon: str, mesh: str, program: str, out: str) -> None:
    import addon_utils  # bpy puts its folder on the path

    bpy.ops.wm.read_factory_settings(use_empty=True)
    sys.path.insert(0, addon)
    addon_utils.enable("stitchmesh_blender", default_set=True)
    bpy.context.preferences.addons["stitchmesh_blender"].preferences.program = program
    bpy.context.scene.unit_settings.scale_length = 0.1
    bpy.ops.wm.obj_import(filepath=mesh, global_scale=0.1)
    garment = bpy.context.selected_objects[0]
    bpy.context.view_layer.objects.active = garment
    turn = Euler((0.3, 0.2, 0.5)).to_matrix().to_4x4()
    garment.matrix_world = Matrix.Translation((10.0, 20.0, 3.0)) @ turn @ garment.matrix_world
    settings = bpy.context.scene.stitchmesh
    settings.stitch_width = 8.0
    states = [list(bpy.ops.stitchmesh.knit())]
    yarns = next(thing for thing in bpy.data.objects if thing.type == "CURVES")
    yarns.data.materials[0].roughness = 0.125
    states.append(list(bpy.ops.stitchmesh.knit()))
    bpy.context.view_layer.update()
    yarns = [thing for thing in bpy.data.objects if thing.type == "CURVES"]
    found = {
        "states": states,
        "objects": [thing.type for thing in bpy.data.objects],
        "curves": len(bpy.data.hair_curves),
        "boxes": [box(garment), box(yarns[0])],
        "attributes": {a.name: [a.domain, len(a.data)] for a in yarns[0].data.attributes},
        "yarns": len(yarns[0].data.curves),
        "length": float(lengths(yarns[0].data).max()),
        "materials": [[material.name, material.roughness] for material in yarns[0].data.materials],
    }
    depsgraph = bpy.context.evaluated_depsgraph_get()
    found["drawn"] = len(yarns[0].evaluated_get(depsgraph).data.curves)
    garment.location.x += 5.0
    bpy.context.view_layer.update()
    found["moved"] = [box(garment), box(yarns[0])]
    settings.pattern = "no-such-pattern"
    try:
        bpy.ops.stitchmesh.knit()
    except RuntimeError as error:
        found["error"] = str(error)
    found["after_error"] = [thing.type for thing in bpy.data.objects]
    Path(out).write_text(json.dumps(found))


def box(thing: bpy.types.Object) -> list[list[float]]:
    data = thing.data
    name = "co" if thing.type == "MESH" else "position"
    items = data.vertices if thing.type == "MESH" else data.points
    numbers = np.empty(3 * len(items), dtype=np.float32)
    items.foreach_get(name, numbers)
    placed = np.array([thing.matrix_world @ Vector(place) for place in numbers.reshape(-1, 3)])
    return [placed.min(axis=0).tolist(), placed.max(axis=0).tolist()]


def lengths(data: bpy.types.Curves) -> np.ndarray:
    numbers = np.empty(len(data.points), dtype=np.float32)
    data.attributes["length"].data.foreach_get("value", numbers)
    return numbers


if __name__ == "__main__":
    try:
        main(*sys.argv[1:])
    except BaseException:
        traceback.print_exc()
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(0)  # the module bpy can wait for ever when Python ends after an exception
