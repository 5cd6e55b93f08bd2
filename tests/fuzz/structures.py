# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Damage that knows how a format is made: files stay whole, and state or nest far more than they hold.

As in ``mutations``, each function takes the generator of random numbers and the content of a file, and returns another
content. The same generator gives the same damage.
"""

from __future__ import annotations

import io
import json
import re
import struct
import zlib
from random import Random
from typing import Any

import numpy as np

from tests.fuzz.mutations import (
    BINARY,
    MIXED,
    NUMBER,
    TEXT,
    inside_base64,
    inside_png,
    json_value,
    mutated,
    png_chunks,
)  # fmt: skip

COUNTS = [0, 1, 2, 1000, 60_000, 10**6, 10**9, 2**31 - 1, 2**32 - 1, 2**40, 2**62]
"""Numbers of elements that are stated."""
DEPTHS = [2, 40, 490, 900, 1100, 3000, 10_000]
"""Depths of nesting."""
TIMES = [2, 50, 2000]
"""How often a part is repeated."""


def nested_json(random: Random, content: bytes) -> bytes:
    """Put lists or objects within each other, all of them closed, in the place of a number or a word of a JSON text."""
    found = list(re.finditer(rb"-?[0-9][0-9.e+-]*|\"[^\"]*\"(?!\s*:)|true|false|null", content))
    if not found:
        return content
    match, depth = random.choice(found), random.choice(DEPTHS)
    begin, end = random.choice([(b"[", b"]"), (b'{"a":', b"}"), (b'[{"":', b"}]"), (b"[[],", b"]")])
    return content[: match.start()] + depth * begin + b"0" + depth * end + content[match.end() :]


def toml_structure(random: Random, content: bytes) -> bytes:
    """Add long keys, many tables, and nested values to a TOML text."""
    depth, times = random.choice(DEPTHS), random.choice(TIMES)
    lines = random.choice([
        b"x = " + depth * b"[" + depth * b"]",
        b"x = " + min(depth, 3000) * b"{a = " + b"0" + min(depth, 3000) * b"}",
        b"[" + b".".join([b"a"] * depth) + b"]",
        b"\n".join(b"[[%s]]" % (b"b." * random.choice((0, 1, 20)) + b"c") for _ in range(times)),
        b"\n".join(b"k%d%s = 0" % (number, b".k" * (40_000 // times)) for number in range(times)),
        b'x = """' + b"\\\n" * times + b'"""',
    ])  # fmt: skip
    place = random.choice([0, len(content), content.find(b"\n[") + 1])
    return content[:place] + lines + b"\n" + content[place:]


def xml_structure(random: Random, content: bytes) -> bytes:
    """Nest, repeat or expand the elements of an XML text."""
    found = list(re.finditer(rb"<(\w+)[^<>]*?(/?)>", content))
    if not found:
        return content
    match, times = random.choice(found), random.choice(TIMES)
    name = match[1]
    kind = random.randrange(4)
    if kind == 0:
        return content[: match.start()] + times * match[0] + content[match.end() :]
    if kind == 1 and not match[2]:
        end = content.find(b"</" + name, match.end())
        inner = content[match.end() : end]
        nested = times * match[0] + inner + times * (b"</" + name + b">")
        return content[: match.start()] + nested + content[end + len(name) + 3 :]
    if kind == 2:
        levels = b"".join(b'<!ENTITY e%d "%s">' % (n + 1, b"&e%d;" % n * 10) for n in range(9))
        head = b'<!DOCTYPE x [<!ENTITY e0 "0 ">' + levels + b"]>"
        numbers = list(NUMBER.finditer(content, match.end()))
        place = random.choice(numbers).start() if numbers else match.end()
        start = content.find(b"<VTKFile")
        return content[:start] + head + content[start:place] + b"&e9;" + content[place:]
    attribute = b' NumberOf%s="%d"' % (random.choice([b"Points", b"Polys", b"Cells", b"Components"]), 10**12)
    return content[: match.end() - 1 - len(match[2])] + attribute + content[match.end() - 1 - len(match[2]) :]


def glb_structure(random: Random, content: bytes) -> bytes:
    """Change the head of a binary glTF, and make the lengths right."""
    if len(content) < 28 or not content.startswith(b"glTF"):
        return content
    length = int.from_bytes(content[12:16], "little")
    text, rest = content[20 : 20 + length], content[20 + length :]
    if random.random() < 0.5:
        text = mutated(random, text, random.choice([TEXT, [json_value], [nested_json]]))
    else:
        try:
            tree = json.loads(text)
            _change_head(random, tree)
        except (ValueError, KeyError, TypeError, AttributeError, IndexError, RecursionError):
            return content
        text = json.dumps(tree).encode()
    text += b" " * (-len(text) % 4)
    head = struct.pack("<4sII", b"glTF", 2, 20 + len(text) + len(rest))
    return head + struct.pack("<I4s", len(text), b"JSON") + text + rest


def _change_head(random: Random, tree: dict[str, Any]) -> None:
    times = random.choice(TIMES)
    accessor, view = random.choice(tree["accessors"]), random.choice(tree["bufferViews"])
    match random.randrange(12):
        case 0:  # Many nodes place one mesh.
            tree["nodes"] = [{"mesh": 0}] * times
            tree["scenes"][0]["nodes"] = list(range(times))
        case 1:  # Nodes lie within each other.
            chain = [{"children": [n + 1], "matrix": [1.0] * 16} for n in range(times)]
            tree["nodes"] = [*chain, {"mesh": 0}]
            tree["scenes"][0]["nodes"] = [0]
        case 2:  # Each node places the next one twice.
            tree["nodes"] = [{"children": [n + 1, n + 1]} for n in range(min(times, 60))] + [{"mesh": 0}]
            tree["scenes"][0]["nodes"] = [0]
        case 3:
            random.choice(tree["nodes"])["children"] = [random.randrange(len(tree["nodes"]))]
        case 4:
            accessor["count"] = random.choice([*COUNTS, -1])
        case 5:
            accessor["componentType"] = random.choice([5120, 5121, 5122, 5123, 5124, 5125, 5126, 0])
        case 6:
            accessor["sparse"] = {"count": random.choice(COUNTS), "indices": {"bufferView": 0, "componentType": 5125},
                                  "values": {"bufferView": 0}}  # fmt: skip
            if random.random() < 0.5:
                accessor.pop("bufferView", None)
        case 7:
            view[random.choice(["byteOffset", "byteLength", "byteStride"])] = random.choice([*COUNTS, -4])
        case 8:
            mesh = random.choice(tree["meshes"])
            mesh["primitives"] = mesh["primitives"] * times
            mesh["primitives"][0]["mode"] = random.randrange(8)
        case 9:
            node = random.choice(tree["nodes"])
            node[random.choice(["scale", "translation"])] = [random.choice([0.0, 1e308, -1e300, 1e-320])] * 3
            node["rotation"] = [random.choice([0.0, 1e200, 1.0])] * 4
        case 10:  # Many joints carry the points of many nodes.
            tree["skins"] = [{"joints": [random.randrange(len(tree["nodes"]))] * times}]
            for node in tree["nodes"]:
                node["skin"] = random.choice([0, 0, 1])
        case 11:  # Many targets move the points.
            mesh = random.choice(tree["meshes"])
            mesh["weights"] = [random.choice([0.0, 1.0, 1e308])] * times
            mesh["primitives"][0]["targets"] = [{"POSITION": random.randrange(len(tree["accessors"]))}] * times


def hdf5_structure(random: Random, content: bytes) -> bytes:
    """Write a dataset of an HDF5 file anew: with other chunks, filters, shapes, types or attributes.

    The file must be undamaged: the library that changes it ends the process otherwise.
    """
    import h5py

    held = io.BytesIO(content)
    try:
        with h5py.File(held, "r+", libver=random.choice(["earliest", "latest"])) as file:
            _change_dataset(random, file)
    except (OSError, RuntimeError, ValueError, KeyError, TypeError, AttributeError, OverflowError):
        return content
    return held.getvalue()


def _change_dataset(random: Random, file: Any) -> None:
    import h5py

    name = random.choice(sorted(file))
    data, kind = file[name][()], file[name].dtype
    shape = [random.choice([length, length, *COUNTS[:8]]) for length in data.shape]
    del file[name]
    match random.randrange(7):
        case 0:  # Many chunks, of which the file holds none.
            file.create_dataset(name, shape, kind, chunks=tuple(random.choice([1, 1, 7]) for _ in shape))
        case 1:
            chunks = tuple(random.choice([1, 2, 1000, 10**6]) for _ in data.shape)
            file.create_dataset(name, data.shape, kind, data, chunks=chunks, maxshape=(None,) * data.ndim,
                                **random.choice([{}, {"compression": "gzip"}, {"compression": "lzf"},
                                                 {"fletcher32": True}, {"shuffle": True},
                                                 {"scaleoffset": 3}]))  # fmt: skip
        case 2:
            file.create_dataset(name, shape, kind, chunks=True, fillvalue=1)
        case 3:
            other = random.choice([np.dtype("S1000000"), np.dtype(("f8", (1000, 1000))), np.dtype([("a", "f8")] * 1),
                                   h5py.string_dtype(), np.dtype("f2"), np.dtype("c16"), np.dtype(">i8")])  # fmt: skip
            file.create_dataset(name, data.shape, other, chunks=random.choice([None, (1,) * data.ndim]))
        case 4:
            file.create_dataset(name, data=data)
            for number in range(random.choice([1, 50])):
                file.attrs[random.choice(["format", "version", f"a{number}"])] = random.choice(
                    ["x" * 60_000, 1, [1.0] * 5000, np.zeros(0), h5py.Empty("f8"), "x", b"\xff", 2**63]
                )
        case 5:
            group = file
            for _ in range(random.choice([2, 100])):
                group = group.create_group("g")
            group[name] = data
            file[name] = random.choice([h5py.SoftLink(group.name), group, h5py.SoftLink(f"/{name}")])
        case 6:
            file.create_dataset(name, data.shape, kind, data)
            for number in range(random.choice([10, 300])):
                file[f"other {number}"] = number


def hdf5_addresses(random: Random, content: bytes) -> bytes:
    """Let a place of an HDF5 file that holds an address or a length of eight bytes hold another one of the file."""
    places = [place for place in range(0, len(content) - 8, 8)
              if 0 < int.from_bytes(content[place : place + 8], "little") < len(content)]  # fmt: skip
    if not places:
        return content
    place, other = random.choice(places), random.choice(places)
    number = random.choice([content[other : other + 8], other.to_bytes(8, "little"), place.to_bytes(8, "little")])
    return content[:place] + number + content[place + 8 :]


def png_head(random: Random, content: bytes) -> bytes:
    """State other sizes, depths or kinds in the head of a PNG, or add chunks, with right checksums."""
    chunks = png_chunks(content)
    if not chunks or len(chunks[0][1]) != 13:
        return content
    width, height, *rest = struct.unpack(">IIBBBBB", chunks[0][1])
    sizes = [width, height, 1, 3, 1000, 10_000, 65_536, 2**31 - 1, 0]
    if random.random() < 0.6:
        kinds = [random.choice([one, one, random.randrange(20)]) for one in rest]
        chunks[0] = b"IHDR", struct.pack(">IIBBBBB", random.choice(sizes), random.choice(sizes), *kinds)
    else:
        text = zlib.compress(bytes(random.choice([10, 10**6, 10**7])))
        chunks.insert(1, random.choice([
            (b"zTXt", b"stitchmesh chart\0\0" + text), (b"iTXt", b"stitchmesh chart\0\1\0\0\0" + text),
            (b"iCCP", b"p\0\0" + text), (b"acTL", bytes(8)), (b"tRNS", bytes(random.randrange(300))),
            (b"PLTE", bytes(random.randrange(900))), (b"eXIf", b"Exif\0\0II*\0" + b"\xff" * 20),
        ]))  # fmt: skip
    return content[:8] + b"".join(
        struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data)) for name, data in chunks
    )


def usd_structure(random: Random, content: bytes) -> bytes:
    """Add prims to a USD stage in text that lie within each other, name each other or one another's files."""
    times = random.choice(TIMES)
    twice = b'def "d%d"\n{\ndef "a" (references = </d%d>)\n{\n}\ndef "b" (references = </d%d>)\n{\n}\n}\n'
    doubled = b"".join(twice % (n, n + 1, n + 1) for n in range(min(times, 40)))
    added = random.choice([
        b"".join(b'def "p%d"\n{\n' % n for n in range(times)) + times * b"}\n",
        b"".join(b'def Mesh "m%d"\n{\n}\n' % n for n in range(times)),
        b'def "a" (references = </b>)\n{\n}\ndef "b" (inherits = </a>)\n{\n}\n',
        doubled + b'def BasisCurves "d%d"\n{\n}\n' % min(times, 40),
        b'def PointInstancer "i"\n{\n    int[] protoIndices = [%s]\n}\n' % b", ".join([b"0"] * times),
        b'def "v" (variants = { string s = "x" }\nprepend variantSets = "s")\n{\nvariantSet "s" = { "x" {} }\n}\n',
        b'def Mesh "n"\n{\n    point3f[] points.timeSamples = {\n%s\n    }\n}\n'
        % b",\n".join(b"%d: [(0, 0, 0)]" % n for n in range(times)),
    ])  # fmt: skip
    return content + added


JSON = (*TEXT, *[json_value] * 6, *[nested_json] * 2)
TOML = (*TEXT, *[toml_structure] * 2)
XML = (*MIXED, *[inside_base64] * 4, *[xml_structure] * 2)
HDF5 = (*BINARY, *[hdf5_addresses] * 4)
GLB = (*MIXED, *[glb_structure] * 20)
PNG = (*BINARY, *[inside_png] * 14, *[png_head] * 6)
USD = (*TEXT, usd_structure)
"""Changes of the files of each format."""
