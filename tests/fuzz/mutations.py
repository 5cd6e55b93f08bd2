# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Damage to files: changes of texts, of binary files, and of parts that checksums or encodings protect.

Each function takes the generator of random numbers and the content of a file, and returns another content. The same
generator gives the same damage.
"""

from __future__ import annotations

import base64
import hashlib
import json
import re
import struct
import zlib
from collections.abc import Callable, Sequence
from functools import cache
from random import Random

Mutation = Callable[[Random, bytes], bytes]

NUMBERS = [
    b"0", b"-1", b"1", b"2", b"3", b"-0", b"7.5", b"255", b"256", b"65536", b"2147483647", b"2147483648",
    b"-2147483649",
    b"4294967295", b"99999999999", b"9223372036854775807", b"9223372036854775808", b"-9223372036854775809",
    b"18446744073709551616", b"1e30", b"1e308", b"-1e308", b"1e400", b"1e-320", b"nan", b"inf", b"-inf", b"NaN",
    b"0x10", b"1_000", "\u0663".encode(), "\u00b2".encode(), b"9" * 400, b"9" * 5000, b"", b"+", b".", b"1.", b"1e",
]  # fmt: skip
"""Texts in the place of a number."""
ODD_TEXTS = [
    b"\0", b"\xff", b"\xc3", b"\xed\xa0\x80", b"\xef\xbb\xbf", b"\r", b"\n", b"\r\n", b"\t", b"\x0b", b"\x1c",
    "\u2028".encode(), "\x85".encode(), "\u202e".encode(), b"#", b"\\", b"'", b'"', b"/", b"//", b"*", b";", b"=",
    b"<", b">", b"&", b"]]>", b"../", b"../../../../etc/passwd", b"/dev/zero", b"%s", b"{}",
]  # fmt: skip
"""Texts that are inserted."""
OPENINGS = [b"[", b"{", b"(", b"a.", b"[[", b"<a>", b"repeat (", b"\\\n", b"-", b"not ", b"{a="]
"""Beginnings that are repeated to nest deeply."""
WHOLE = [0, 1, 2, 3, 7, 8, 127, 128, 255, 256, 32767, 65535, 2**24, 2**31 - 1, 2**31, 2**32 - 1, 2**63 - 1, 2**64 - 1]
"""Numbers that are written into binary files; their negatives too."""
REAL = [float("nan"), float("inf"), -float("inf"), 0.0, -1.0, 1e30, 1e308, 1e-320]
"""Floating-point numbers that are written into binary files."""
NUMBER = re.compile(rb"[-+]?[0-9][0-9.eE+-]*")
WORD = re.compile(rb"[^\s,;=\[\](){}<>\"]+")
LONG_BASE64 = re.compile(rb"[A-Za-z0-9+/]{12,}={0,2}")
HEAD = 256
"""Number of bytes at the start of a file that are damaged more often than the others."""
LARGEST = 50_000
"""Number of bytes to which a damaged file is cut, so that repeated lines stay small."""


def mutated(random: Random, content: bytes, kinds: Sequence[Mutation]) -> bytes:
    """Return a content with up to four changes; one is the most frequent number."""
    for _ in range(random.choice((1, 1, 1, 2, 2, 3, 4) if random.random() < 0.95 else (0,))):
        content = random.choice(kinds)(random, content)[:LARGEST]
    return content


def _place(random: Random, content: bytes) -> int:
    """Return an offset, half of the time within the head."""
    return random.randrange(max(1, min(len(content), HEAD) if random.random() < 0.5 else len(content)))


def _span(random: Random, count: int) -> tuple[int, int]:
    """Return the start and the end of a part of a list; short parts are more frequent."""
    start = random.randrange(count + 1)
    return start, min(count, start + int(random.expovariate(1 / 3)) + 1)


def cut(random: Random, content: bytes) -> bytes:
    """Cut a file short."""
    return content[: random.randrange(len(content) + 1)]


def flip_bits(random: Random, content: bytes) -> bytes:
    """Flip one to eight bits."""
    changed = bytearray(content)
    for _ in range(random.choice((1, 1, 2, 8)) if content else 0):
        changed[_place(random, content)] ^= 1 << random.randrange(8)
    return bytes(changed)


def overwrite_number(random: Random, content: bytes) -> bytes:
    """Write an extreme number of one, two, four or eight bytes over the content."""
    order = random.choice("<>")
    if random.random() < 0.2:
        number = struct.pack(order + random.choice("fd"), 0.0)
        value = random.choice(REAL)
        number = struct.pack(f"{order}d", value) if len(number) == 8 or abs(value) == 1e308 else (
            struct.pack(f"{order}f", value))  # fmt: skip
    else:
        size = random.choice((1, 2, 4, 4, 8, 8))
        value = random.choice(WHOLE) * random.choice((1, 1, 1, -1))
        number = (value % 2 ** (8 * size)).to_bytes(size, "little" if order == "<" else "big")
    start = _place(random, content)
    start -= start % 4 if random.random() < 0.7 else 0
    return content[:start] + number + content[start + len(number) :]


def move_chunk(random: Random, content: bytes) -> bytes:
    """Remove, repeat, clear or move a chunk of bytes."""
    start = _place(random, content)
    end = min(len(content), start + random.choice((1, 2, 4, 8, 12, 16, 64, 512)))
    chunk = content[start:end]
    other = random.choice((b"", 2 * chunk, 50 * chunk, b"\0" * len(chunk), b"\xff" * len(chunk)))
    if random.random() < 0.2:
        place = random.randrange(len(content) + 1)
        return content[:place] + chunk + content[place:]
    return content[:start] + other + content[end:]


def replace_number(random: Random, content: bytes) -> bytes:
    """Replace a number of a text, or add to it or subtract from it."""
    found = list(NUMBER.finditer(content))
    if not found:
        return content
    match = random.choice(found)
    other = random.choice(NUMBERS)
    if random.random() < 0.3 and match[0].isdigit() and len(match[0]) < 18:
        other = str(int(match[0]) + random.choice((-2, -1, 1, 2, 100))).encode()
    return content[: match.start()] + other + content[match.end() :]


def move_lines(random: Random, content: bytes) -> bytes:
    """Remove, repeat, reverse or move some lines."""
    lines = content.split(b"\n")
    start, end = _span(random, len(lines))
    some = lines[start:end]
    other = random.choice(([], 2 * some, 300 * some, some[::-1]))
    if random.random() < 0.3:
        place = random.randrange(len(lines) + 1)
        return b"\n".join(lines[:place] + some + lines[place:])
    return b"\n".join(lines[:start] + other + lines[end:])


def move_words(random: Random, content: bytes) -> bytes:
    """Remove or repeat a word, or replace it by another word of the file."""
    found = list(WORD.finditer(content))
    if not found:
        return content
    match = random.choice(found)
    other = random.choice((b"", match[0] + b" " + match[0], (match[0] + b" ") * 200, random.choice(found)[0]))
    return content[: match.start()] + other + content[match.end() :]


def insert_text(random: Random, content: bytes) -> bytes:
    """Insert odd characters."""
    place = random.randrange(len(content) + 1)
    return content[:place] + random.choice(ODD_TEXTS) + content[place:]


def nest(random: Random, content: bytes) -> bytes:
    """Insert a beginning many times; half of the time at the place of a number."""
    opening = random.choice(OPENINGS) * random.choice((2, 40, 40, 3000, 3000, 10_000))
    found = list(NUMBER.finditer(content))
    if found and random.random() < 0.5:
        match = random.choice(found)
        return content[: match.start()] + opening + content[match.end() :]
    place = random.randrange(len(content) + 1)
    return content[:place] + opening + content[place:]


TEXT: Sequence[Mutation] = (
    cut, flip_bits, replace_number, replace_number, replace_number, move_lines, move_lines, move_words, move_words,
    insert_text, nest,
)  # fmt: skip
"""Changes of text files."""
BINARY: Sequence[Mutation] = (
    cut, flip_bits, flip_bits, overwrite_number, overwrite_number, overwrite_number, move_chunk,
)  # fmt: skip
"""Changes of binary files."""
MIXED: Sequence[Mutation] = (*TEXT, *BINARY)
"""Changes of files that hold texts and binary parts."""


def inside_base64(random: Random, content: bytes) -> bytes:
    """Change the bytes behind a text in base 64."""
    found = list(LONG_BASE64.finditer(content))
    if not found:
        return content
    match = random.choice(found)
    try:
        inner = base64.b64decode(match[0])
    except ValueError:
        return content
    return content[: match.start()] + base64.b64encode(mutated(random, inner, BINARY)) + content[match.end() :]


def inside_checkpoint(random: Random, content: bytes) -> bytes:
    """Change the header or the arrays of a checkpoint, and make the length of the header and the checksum right."""
    magic, _, rest = content[:-32].partition(b"\n")
    if len(rest) < 12 or len(content) < 60:
        return content
    version, length = struct.unpack("<IQ", rest[:12])
    header, arrays = rest[12 : 12 + length], rest[12 + length :]
    if random.random() < 0.8:
        header = mutated(random, header, random.choice((TEXT, [json_value])))
    else:
        arrays = mutated(random, arrays, BINARY)
    body = magic + b"\n" + struct.pack("<IQ", version, len(header)) + header + arrays
    return body + hashlib.sha256(body).digest()


def json_value(random: Random, content: bytes) -> bytes:
    """Replace, remove or repeat a value of a JSON text, anywhere within it."""
    try:
        tree = json.loads(content)
    except (ValueError, RecursionError):
        return content
    holder = {"": tree}
    key: str | int = ""
    inner: dict | list = holder
    while isinstance(inner[key], dict | list) and inner[key] and random.random() < 0.8:
        inner = inner[key]
        key = random.choice(list(inner)) if isinstance(inner, dict) else random.randrange(len(inner))
    if random.random() < 0.3 and inner is not holder:
        del inner[key]
    else:
        inner[key] = random.choice(
            [None, True, 0, -1, 1.5, 1e308, 2**31, 2**63, 10**30, "", "x", "nan", [], [[]], {}, {"": {}}, [0, 1], "<f8",
             "O", "<M8[s]", "V8", "<U100000000", "(2,3)f8", "f8,f8", "|S0", ",".join(["f8"] * 3000), [2**40, 2**40],
             [-1], [2**31, 0], [3, -1]]
        )  # fmt: skip
    return json.dumps(holder[""]).encode()


def inside_png(random: Random, content: bytes) -> bytes:
    """Change the content of the chunks of a PNG, and make their checksums right; image data may become a bomb."""
    chunks = png_chunks(content)
    if not chunks:
        return content
    number = random.randrange(len(chunks))
    name, data = chunks[number]
    if name == b"IDAT" and random.random() < 0.5:
        try:
            pixels = zlib.decompress(data)
        except zlib.error:
            pixels = b""
        data = bomb() if random.random() < 0.5 else zlib.compress(mutated(random, pixels, BINARY))
    else:
        data = mutated(random, data, BINARY)
    chunks[number] = name, data
    if random.random() < 0.2:
        chunks.insert(number, chunks[random.randrange(len(chunks))])
    parts = [struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
             for name, data in chunks]  # fmt: skip
    return content[:8] + b"".join(parts)


@cache
def bomb() -> bytes:
    """Return a thousandth of 30 MB that the method of PNG expands to them."""
    return zlib.compress(b"\0" * 30_000_000)


def png_chunks(content: bytes) -> list[tuple[bytes, bytes]]:
    """Return the names and the contents of the chunks of a PNG, up to the first damaged one."""
    chunks, start = [], 8
    while start + 12 <= len(content):
        length = int.from_bytes(content[start : start + 4], "big")
        if start + 12 + length > len(content):
            break
        chunks.append((content[start + 4 : start + 8], content[start + 8 : start + 8 + length]))
        start += 12 + length
    return chunks
