# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The readers of files, each with small undamaged files, the changes that suit its format, and the errors it raises."""

from __future__ import annotations

import base64
import dataclasses
import io
import struct
import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import fuzz_mutations as damage
import numpy as np

import stitchmesh as sm
from stitchmesh.errors import FileError, MeshError, ParameterError, PatternError, YarnError
from stitchmesh.io import read_mesh, read_stitches, read_yarns, write_mesh, write_stitches, write_yarns
from stitchmesh.io.any_file import read_any
from stitchmesh.io.yarns import BCC_CURVES
from stitchmesh.lattice import Lattice
from stitchmesh.mesh import Mesh, StitchMesh
from stitchmesh.yarn import YarnSet

Seeds = Callable[[Path], Sequence[bytes]]
"""Function that returns undamaged files; it may write into the folder that it gets."""
ROOT = Path(__file__).resolve().parent.parent


@dataclass(frozen=True)
class Reader:
    """A function that reads files, and what is needed to damage its files."""

    suffix: str
    read: Callable[[Path], Any]
    seeds: Seeds
    kinds: Sequence[damage.Mutation] = damage.TEXT
    """Changes of the files."""
    errors: tuple[type[Exception], ...] = (FileError,)
    """Errors that the reader may raise for a damaged file."""
    has_own_process: bool = False
    """Whether the library reads in a process of its own, so that its end is a ``FileError``; ``read`` does not."""
    may_reserve: bool = False
    """Whether memory may be reserved that is never written, so that a system that refuses it makes a ``FileError``."""


def cube() -> Mesh:
    """Return a cube with an open side, of quads and two triangles."""
    vertices = [[x, y, z + x / 3] for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    return Mesh.from_polygons(np.array(vertices), [[0, 1, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6]])


def small_yarns(periodic: bool = False) -> YarnSet:
    """Return a closed and an open yarn, or a closed yarn on a lattice."""
    angle = np.linspace(0, 2 * np.pi, 7)[:-1]
    ring = np.stack([np.cos(angle), np.sin(angle), 0.1 * np.cos(2 * angle)], axis=1)
    if periodic:
        yarns = YarnSet.from_curves([ring, ring + np.array([0, 0, 3])], closed=[True, True], radius=0.1)
        lattice = Lattice([[5.0, 0, 0], [0, 4.0, 0]])
        return dataclasses.replace(yarns, lattice=lattice, lattice_step=np.zeros((2, 2), int))
    return YarnSet.from_curves([ring, ring[:4] * 1.5], closed=[True, False], radius=[0.1, 0.2])


def small_fabric() -> StitchMesh:
    """Return a flat fabric of six stitches above a cast-on row."""
    return sm.pattern_mesh(sm.read_pattern("rib1x1"), 2, 1, stitch_width=0.8, stitch_height=0.5)


def _written(write: Callable[..., None], *values: Any, suffix: str, **options: Any) -> Callable[[Path], list[bytes]]:
    """Return a function that writes each value to a file and returns the contents."""

    def contents(folder: Path) -> list[bytes]:
        found = []
        for value in values:
            path = folder / f"seed{suffix}"
            write(path, value() if callable(value) else value, **options)
            found.append(path.read_bytes())
            path.unlink()
        return found

    return contents


def _files(*names: str) -> Callable[[Path], list[bytes]]:
    return lambda folder: [(ROOT / name).read_bytes() for name in names]


def _joined(*parts: Callable[[Path], Sequence[bytes]]) -> Callable[[Path], list[bytes]]:
    return lambda folder: [content for part in parts for content in part(folder)]


def _ascii_ply(folder: Path) -> list[bytes]:
    head = b"ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    head += b"property uchar red\nelement face 2\nproperty list uchar int vertex_index\nend_header\n"
    return [head + b"0 0 0 9\n1 0 0 9\n1 1 0.5 9\n0 1 0 9\n3 0 1 2\n3 0 2 3\n"]


def _ascii_stl(folder: Path) -> list[bytes]:
    corners = [([0, 0, 0], [1, 0, 0], [1, 1, 0]), ([0, 0, 0], [1, 1, 0], [0, 1, 0.5])]
    lines = ["solid two"]
    for triangle in corners:
        lines += ["  facet normal 0 0 1", "    outer loop"]
        lines += [f"      vertex {x} {y} {z}" for x, y, z in triangle] + ["    endloop", "  endfacet"]
    return ["\n".join([*lines, "endsolid two", ""]).encode()]


def _vtp_variants(folder: Path) -> list[bytes]:
    """Return a polyline and a polygon in each encoding of the format."""
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.5]], "<f4")
    modes = ("ascii", "binary", "zlib", "appended")
    return [_vtp(points, cells, mode) for cells in ("Lines", "Polys") for mode in modes]


def _vtp(points: np.ndarray, cells: str, mode: str) -> bytes:
    blocks: list[bytes] = []

    def array(name: str, kind: str, values: np.ndarray, columns: int = 1) -> str:
        """Return the XML of an array; appended ones go to the blocks."""
        head = f'<DataArray type="{kind}" Name="{name}" NumberOfComponents="{columns}"'
        raw = values.tobytes()
        if mode == "ascii":
            return f'{head} format="ascii">{" ".join(map(str, values.ravel().tolist()))}</DataArray>'
        if mode == "appended":
            offset = sum(map(len, blocks))
            blocks.append(struct.pack("<I", len(raw)) + raw)
            return f'{head} format="appended" offset="{offset}"/>'
        packed = zlib.compress(raw)
        sizes = struct.pack("<4I", 1, len(raw), 0, len(packed)) if mode == "zlib" else struct.pack("<I", len(raw))
        body = base64.b64encode(sizes) + base64.b64encode(packed) if mode == "zlib" else base64.b64encode(sizes + raw)
        return f'{head} format="binary">{body.decode()}</DataArray>'

    compressor = ' compressor="vtkZLibDataCompressor"' if mode == "zlib" else ""
    text = "".join([
        f'<?xml version="1.0"?>\n<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" '
        f'header_type="UInt32"{compressor}>\n<PolyData><Piece NumberOfPoints="4" NumberOfVerts="0" ',
        f'NumberOfLines="{int(cells == "Lines")}" NumberOfStrips="0" NumberOfPolys="{int(cells == "Polys")}">\n',
        "<PointData>", array("radius", "Float64", np.full(4, 0.1)), "</PointData>\n<Points>",
        array("Points", "Float32", points, 3), f"</Points>\n<{cells}>", array("connectivity", "Int64", np.arange(4)),
        array("offsets", "Int64", np.array([4])), f"</{cells}>\n</Piece></PolyData>\n",
    ])  # fmt: skip
    data = b'<AppendedData encoding="raw">\n_' + b"".join(blocks) + b"\n</AppendedData>\n"
    return text.encode() + (data if mode == "appended" else b"") + b"</VTKFile>\n"


def _hdf5_links(folder: Path) -> list[bytes]:
    """Return files of yarns with compressed, chunked, virtual, external, linked and very large datasets."""
    import h5py

    found = []
    for kind in ("compressed", "external link", "external data", "soft link", "virtual", "bomb", "empty", "huge"):
        path = folder / "seed.h5"
        write_yarns(path, small_yarns())
        with h5py.File(path, "r+") as file:
            points = file["points"][()]
            del file["points"]
            if kind == "compressed":
                file.create_dataset("points", data=points, compression="gzip", chunks=(4, 3))
            elif kind == "external link":
                file["points"] = h5py.ExternalLink("../../../../etc/passwd", "/points")
            elif kind == "external data":
                file.create_dataset("points", points.shape, "f8", external=[("/etc/passwd", 0, points.nbytes)])
            elif kind == "soft link":
                file["points"] = h5py.SoftLink("/points")
            elif kind == "virtual":
                layout = h5py.VirtualLayout(points.shape, "f8")
                layout[:] = h5py.VirtualSource("/etc/passwd", "points", points.shape)
                file.create_virtual_dataset("points", layout)
            elif kind == "bomb":
                file.create_dataset("points", data=np.zeros((3_000_000, 3)), compression="gzip", chunks=(1_000_000, 3))
            elif kind == "empty":
                file.create_dataset("points", data=h5py.Empty("f8"))
            else:
                file.create_dataset("points", (2**40, 3), "f8", chunks=(1000, 3))
        found.append(path.read_bytes())
    return found


def _labeling(folder: Path) -> list[bytes]:
    return _written(sm.write_labeling, lambda: sm.start_labeling(cube()), suffix=".h5")(folder)


def _read_labeling(path: Path) -> object:
    return sm.read_labeling(path)


def _checkpoint(folder: Path) -> list[bytes]:
    """Return the checkpoint of a relaxation, made by hand; the states of solvers have the same form."""
    from stitchmesh.yarnrelax.checkpoint import CheckpointState, write_state
    from stitchmesh.yarnrelax.convergence import Assessment

    class Held:
        def numpy(self) -> np.ndarray:
            return np.arange(18.0, dtype=np.float32).reshape(6, 3)

    last = Assessment(0.5, {"stretch": 1.0})
    entry = {"iteration": 1, "seconds": 0.1, "residual": 0.5, "energies": {"stretch": 1.0}}
    state = CheckpointState(5, 0.5, last, [entry], 0.1, 3, 1.0, np.inf, {"good_points": Held()})  # type: ignore[list-item]
    return _written(lambda path, value: write_state(path, {"yarns": "1"}, value), state, suffix=".smc")(folder)


def _read_state(path: Path) -> object:
    from stitchmesh.yarnrelax.checkpoint import read_state

    return read_state(path, {"yarns": "1"})


def _frame(folder: Path) -> list[bytes]:
    """Return the file of a frame of mixed yarns and triangles."""
    from stitchmesh.mixed.output.frames import Frame, Frames

    points = np.arange(12.0).reshape(4, 3)
    Frames(folder).add(Frame(0.5, points, points, points[:, :2], np.zeros(2, dtype=np.int64), np.ones(4)))
    return [next(folder.rglob("0000.smc")).read_bytes()]


def _read_frame(path: Path) -> object:
    from stitchmesh.mixed.output.frames import read_frame

    return read_frame(path)


def _read_checkpoint_yarns(path: Path) -> object:
    from stitchmesh.yarnrelax.checkpoint_yarns import checkpoint_yarns

    return checkpoint_yarns(path, YarnSet.from_curves([np.arange(18.0).reshape(6, 3)], closed=[True], radius=0.1))


def _usd(suffix: str) -> Reader:
    def seeds(folder: Path) -> list[bytes]:
        """Return yarns in this suffix, and for text also a layer that names files outside its folder."""
        linked = small_yarns(), dataclasses.replace(small_yarns(), colour=[1, 0])
        found = _written(write_yarns, *linked, suffix=suffix)(folder)
        if suffix == ".usda":
            head = b"#usda 1.0\n(\n    subLayers = [@../../../../etc/passwd@, @/dev/zero@]\n)\n"
            prim = b'def Xform "yarns"'
            found.append(head + found[0].partition(b")\n")[2])
            found.append(found[0].replace(prim, prim + b" (references = @/etc/passwd@)"))
        return found

    kinds = damage.TEXT if suffix == ".usda" else damage.BINARY
    return Reader(suffix, _read_usd, seeds, kinds, (FileError, YarnError, ParameterError), has_own_process=True)


def _read_usd(path: Path) -> object:
    """Do in this process what ``read_yarns`` does in a child, whose start takes longer than the reading."""
    from stitchmesh.io.yarn_formats.usd_curves import curves_of_stage
    from stitchmesh.io.yarns import yarns_of_usd

    return yarns_of_usd(curves_of_stage(path))


def _png(folder: Path) -> list[bytes]:
    """Return charts as pictures: with a palette, in true colours, interlaced, with text, and small ones."""
    from PIL import Image, PngImagePlugin

    pixels = np.array([[0, 1, 0, 1], [1, 0, 1, 0], [0, 0, 1, 1]], np.uint8)
    palette = Image.fromarray(pixels, "P")
    palette.putpalette([255, 255, 255, 40, 40, 40])
    text = PngImagePlugin.PngInfo()
    text.add_text("stitchmesh chart", "row 1: K P", zip=True)
    found = []
    deep = Image.fromarray(pixels.astype(np.uint16) * 40_000)
    modes = [palette, *(palette.convert(mode) for mode in ("RGB", "RGBA", "1", "LA")), deep]
    for image in modes:
        content, options = io.BytesIO(), {"pnginfo": text} if image.mode == "RGB" else {}
        image.save(content, format="PNG", **options)
        found.append(content.getvalue())
    return found


def _read_chart(name: str) -> Callable[[Path], object]:
    def read(path: Path) -> object:
        return sm.read_chart(name, path.read_bytes())

    return read


def _resolved(path: Path) -> object:
    return sm.resolve_pattern(path)


def _read_recipe(path: Path) -> object:
    return sm.read_recipe(path)


def _read_scene(path: Path) -> object:
    return sm.read_scene(path)


def _read_panels(path: Path) -> object:
    from stitchmesh.mixed.cloth.panel_file import read_panels

    return read_panels(path)


def _read_cloth_material(path: Path) -> object:
    from stitchmesh.mixed.triangles.material_file import read_material

    return read_material(path)


def _read_crossing_materials(path: Path) -> object:
    return sm.CrossingMaterial.read(path, "jersey")


def _read_textured(path: Path) -> object:
    from stitchmesh.mixed.cloth.textured_obj import read_textured_obj

    return read_textured_obj(path)


def _edits(folder: Path) -> list[bytes]:
    return [
        b'{"edit": "change_stitch", "arguments": {"faces": [1, 2], "stitch": "P"}}\n'
        b'{"edit": "split_course_edge", "arguments": {"side": 9}}\n{"edit": "insert_row", "arguments": {"face": 3}}\n'
    ]


def _read_edits(path: Path) -> object:
    from stitchmesh.editing.log import read_log

    return read_log(path)


def _steps(folder: Path) -> list[bytes]:
    first = b'{"step": "start_at_edge", "arguments": {"edge": [3, 2]}}\n'
    return [first + b'{"step": "flip_row", "arguments": {"face": 1}}\n']


def _read_steps(path: Path) -> object:
    return sm.read_label_steps(path)


def _read_history(path: Path) -> object:
    from stitchmesh.io.history import read_history

    return read_history(path)


def _read_faces(path: Path) -> object:
    from stitchmesh.selection.selected_faces import read_faces

    return read_faces(path)


def _read_edge_settings(path: Path) -> object:
    from stitchmesh.tessellate.edge_file import read_edge_settings

    return read_edge_settings(path)


def _meshes(suffix: str, kinds: Sequence[damage.Mutation], *seeds: Seeds, may_reserve: bool = False) -> Reader:
    own = _written(write_mesh, cube, suffix=suffix)
    return Reader(suffix, read_mesh, _joined(own, *seeds), kinds, (FileError, MeshError), may_reserve=may_reserve)


XML = (*damage.MIXED, *[damage.inside_base64] * 4)
CHECKPOINT = (*damage.BINARY, *[damage.inside_checkpoint] * 20)
PNG = (*damage.BINARY, *[damage.inside_png] * 14)
YARN_ERRORS = (FileError, ParameterError)
"""Errors of yarns: a radius that cannot be estimated is a ``ParameterError``."""
PATTERN_ERRORS = (FileError, PatternError, ParameterError)
"""Errors of charts: a chart that is too large is a ``ParameterError``."""
PATTERNS = [f"assets/patterns/{name}.knit" for name in ("rib2x2", "eyelet-lace", "seed")]
WEAVES = [f"assets/patterns/{name}.weave" for name in ("satin-2x3", "double-plain-stitched", "orthogonal-interlock")]
RECIPES = ["examples/hat.toml", "examples/sock.toml", "examples/sweater.toml"]
SCENES = [f"examples/mixed/{name}.toml" for name in ("swinging", "sleeve", "loops", "pulled")]
CLOTH_MATERIALS = ["examples/mixed/jersey/cloth.toml", "examples/mixed/materials/jersey.toml"]
YARN_MATERIALS = ["examples/mixed/materials/garment-yarns.toml"]

READERS: dict[str, Reader] = {
    "obj mesh": _meshes(".obj", damage.TEXT),
    "off": _meshes(".off", damage.TEXT),
    "ply": _meshes(".ply", damage.MIXED, _ascii_ply),
    "stl": _meshes(".stl", damage.MIXED, _ascii_stl),
    "vtp": Reader(".vtp", read_any, _joined(_written(write_yarns, small_yarns, suffix=".vtp"), _vtp_variants),
                  XML, (FileError, MeshError, ParameterError)),
    "vtk": _meshes(".vtk", damage.MIXED, may_reserve=True),
    "vtu": _meshes(".vtu", XML),
    "msh": _meshes(".msh", damage.MIXED, may_reserve=True),
    "medit": _meshes(".mesh", damage.TEXT),
    "glb": _meshes(".glb", damage.MIXED),
    "bcc": Reader(".bcc", read_yarns, _joined(*(_written(write_yarns, small_yarns, suffix=".bcc", curve=curve)
                                                for curve in BCC_CURVES)), damage.BINARY, YARN_ERRORS),
    "obj yarns": Reader(".obj", read_yarns, _written(write_yarns, small_yarns, suffix=".obj"), errors=YARN_ERRORS),
    "pyp": Reader(".pyp", read_yarns, _written(write_yarns, small_yarns(True), suffix=".pyp"), errors=YARN_ERRORS),
    "usda": _usd(".usda"),
    "usdc": _usd(".usdc"),
    "hdf5 yarns": Reader(".h5", read_yarns, _joined(
        _written(write_yarns, small_yarns, small_yarns(True), suffix=".h5"), _hdf5_links), damage.BINARY),
    "hdf5 stitches": Reader(".h5", read_stitches, _written(write_stitches, small_fabric, suffix=".h5"), damage.BINARY),
    "hdf5 labels": Reader(".h5", _read_labeling, _labeling, damage.BINARY),
    "smobj": Reader(".smobj", read_stitches, _written(write_stitches, small_fabric, suffix=".smobj")),
    "checkpoint": Reader(".smc", _read_state, _checkpoint, CHECKPOINT, (FileError, ParameterError)),
    "checkpoint yarns": Reader(".smc", _read_checkpoint_yarns, _checkpoint, CHECKPOINT),
    "frame": Reader(".smc", _read_frame, _frame, CHECKPOINT),
    "recipe": Reader(".toml", _read_recipe, _files(*RECIPES)),
    "scene": Reader(".toml", _read_scene, _files(*SCENES)),
    "panels": Reader(".toml", _read_panels, _files("examples/mixed/panels/sleeve.toml")),
    "cloth material": Reader(".toml", _read_cloth_material, _files(*CLOTH_MATERIALS)),
    "yarn materials": Reader(".toml", _read_crossing_materials, _files(*YARN_MATERIALS),
                             errors=(FileError, ParameterError)),
    "textured obj": Reader(".obj", _read_textured, lambda folder: [
        b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n"]),
    "pattern": Reader(".knit", _resolved, _files(*PATTERNS), errors=PATTERN_ERRORS),
    "chart": Reader(".knit", _read_chart("chart.knit"), _files(*PATTERNS), errors=PATTERN_ERRORS),
    "chart text": Reader(".txt", _read_chart("chart.txt"), lambda folder: [b"KPKP\nPKPK\n", b"0011\n1100\n"],
                         errors=PATTERN_ERRORS),
    "weave": Reader(".weave", _resolved, _files(*WEAVES), errors=PATTERN_ERRORS),
    "weave chart": Reader(".weave", _read_chart("chart.weave"), _files(*WEAVES), errors=PATTERN_ERRORS),
    "png chart": Reader(".png", _read_chart("chart.png"), _png, PNG, PATTERN_ERRORS),
    "png weave": Reader(".weave.png", _resolved, _png, PNG, PATTERN_ERRORS),
    "edits": Reader(".jsonl", _read_edits, _edits),
    "labeling steps": Reader(".jsonl", _read_steps, _steps),
    "history": Reader(".csv", _read_history, lambda folder: [b"iteration,seconds,residual,bend_erg\n1,0.5,0.1,2.5\n"]),
    "faces": Reader(".txt", _read_faces, lambda folder: [b"1, 2, 3 # faces\n7 8\n"]),
    "edges": Reader(".txt", _read_edge_settings, lambda folder: [b"4,7=12\n3, 8\n# marked\n5,6 = 3\n"],
                    errors=(FileError, ParameterError)),
}  # fmt: skip
"""Readers by name."""
