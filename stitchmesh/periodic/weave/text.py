# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The text language of weaves.

    text    = { "weave" string | "source" string | "colours" string | threads } ( matrix | layers )
    matrix  = a line of 0 and 1 for each weft, from the top; 1 where it passes over the warp
    layers  = "layer 1:" matrix { "layer" number ":" matrix } { stitch }       from the front to the back
    stitch  = "stitch" ( "warp" yarn "over" "weft" yarn | "weft" yarn "over" "warp" yarn )
    yarn    = layer "." number                                                 both from 1, from the top or the left
    threads = ( "wefts" | "warps" ) ( "layer" | "radius" | "spacing" | "length" | "colour" ) ":" number { number }

A matrix alone describes the whole fabric. Layers lie one behind another, and a stitch binds two layers: it brings a
yarn over a crossing yarn of a layer in front of its own layer. The numbers of threads apply to all wefts from the top
or to all warps from the left, and repeat if there are fewer numbers than yarns; yarns of equal layers alternate.
Radius, spacing and length are factors. A list of colours in quotes, such as ``colours "cream, navy"``, gives the colour
of each colour number. Blanks between the signs of a matrix are ignored, and a comment runs from # to
the end of the line.

Layers of cloth, each with its own wefts and warps, become one matrix (``stack_layers``). The yarns of all layers are
distributed evenly over the repeat; the yarns of equal layers alternate. The spacing of each yarn is smaller, so that
each layer alone has the spacing of a single cloth.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import PatternError
from stitchmesh.mesh import IntArray
from stitchmesh.mesh.palette import colour_text
from stitchmesh.patterns.language.parse import quoted_palette, quoted_text
from stitchmesh.patterns.language.tokens import END, Line, TextPlace, Token, split_lines
from stitchmesh.periodic.weave.weave import Thread, Weave

STATEMENTS = "weave, source, colours, layer, stitch, wefts, warps or a line of 0 and 1"
PROPERTIES = {"layer": int, "radius": float, "spacing": float, "length": float, "colour": int}
"""Properties of a thread, and the type of their numbers."""
MOST_CROSSINGS = 4_000_000
"""Largest number of crossings in one repeat, as in an image."""
_COUNT = re.compile(r"\d{1,6}", re.ASCII)
_NUMBER = re.compile(r"\d+(\.\d*)?([eE][-+]?\d+)?|\.\d+([eE][-+]?\d+)?", re.ASCII)
_YARN = re.compile(r"(\d{1,6})\.(\d{1,6})", re.ASCII)


@dataclass(frozen=True)
class WrittenWeave:
    """The content of a text about a weave, before the weave is checked; its fields are the fields of ``Weave``."""

    matrix: tuple[tuple[int, ...], ...]
    wefts: tuple[Thread, ...]
    warps: tuple[Thread, ...]
    name: str
    source: str
    palette: tuple[tuple[int, int, int], ...]
    places: tuple[TextPlace, ...] = ()
    """Place of each row of the matrix in the text; empty if there is no text yet."""


def parse_weave(text: str, name: str = "weave") -> Weave:
    """Read a weave from its text.

    Args:
        text: a text in the language that the docstring of this module describes.
        name: the name of the text in messages, and the name of the weave if the text gives none.

    Raises:
        PatternError: the text does not describe a valid weave; the message gives the line, the column, what was found
            and what was expected.
    """
    written = parse_written_weave(text, name)
    try:
        return Weave(written.matrix, written.wefts, written.warps, written.name, written.source, written.palette)
    except PatternError as error:
        raise PatternError(f"{name}: {error}", row=error.row) from None


def parse_written_weave(text: str, name: str = "weave") -> WrittenWeave:
    """Read a weave from its text, whether or not the fabric hangs together.

    Args:
        text: a text in the language that the docstring of this module describes.
        name: the name of the text in messages, and the name of the weave if the text gives none.

    Raises:
        PatternError: a statement cannot be read; the message gives the line and the column.
    """
    return _WeaveParser(name).parse(split_lines(text, name))


def format_weave(weave: Weave | WrittenWeave) -> str:
    """Write a weave with its whole matrix as text, so that ``parse_weave(format_weave(weave)) == weave``.

    The fabric need not hang together. The lines of the matrix are the last lines of the text.
    """
    lines = [f'weave "{weave.name}"', f'source "{weave.source}"']
    if weave.palette:
        lines.append(f'colours "{", ".join(map(colour_text, weave.palette))}"')
    for kind, threads in (("wefts", weave.wefts), ("warps", weave.warps)):
        for attribute in PROPERTIES:
            values = [getattr(thread, attribute) for thread in threads]
            if any(value != getattr(Thread(), attribute) for value in values):
                lines.append(f"{kind} {attribute}: {' '.join(_shortest_repeat(attribute, values))}")
    lines += ["".join(str(sign) for sign in row) for row in weave.matrix]
    return "\n".join(lines) + "\n"


def _shortest_repeat(attribute: str, values: list[float]) -> list[str]:
    """Return the shortest list of numbers whose repetition gives all values."""
    lengths = [count for count in range(1, len(values) + 1) if len(values) % count == 0]
    shortest = next(count for count in lengths if values == values[:count] * (len(values) // count))
    if attribute == "layer":
        return [str(value + 1) for value in values[:shortest]]
    return [str(int(value)) if value == int(value) else repr(float(value)) for value in values[:shortest]]


class _WeaveParser:
    """Parser of the statements of a text, one after another."""

    def __init__(self, file: str) -> None:
        self.file = file
        self.names = {"weave": file.replace('"', "'"), "source": ""}
        self.palette: tuple[tuple[int, int, int], ...] = ()
        self.layers: list[list[list[int]]] = []
        self.places: list[list[TextPlace]] = []
        self.layered = False
        self.stitches: list[_Stitch] = []
        self.threads: dict[tuple[str, str], list[Token]] = {}

    def parse(self, lines: list[Line]) -> WrittenWeave:
        """Read all statements."""
        for line in lines:
            if line.text.strip():
                self._statement(line)
        end = lines[-1].place if lines else TextPlace(self.file, 1, 1)
        if not self.layers or not self.layers[-1]:
            raise end.error("got the end of a weave without a matrix; expected a line of 0 and 1 for each weft")
        rows, columns = sum(map(len, self.layers)), sum(len(layer[0]) for layer in self.layers)
        if rows * columns > MOST_CROSSINGS:
            expected = f"expected at most {MOST_CROSSINGS} crossings of all layers"
            raise end.error(f"got {rows} wefts and {columns} warps; {expected}, leave layers out")
        stack = stack_layers([np.array(layer, dtype=np.bool_) for layer in self.layers])
        for stitch in self.stitches:
            stitch.bind(stack)
        wefts, warps = (self._threads(kind, stack) for kind in ("wefts", "warps"))
        places = tuple(self.places[layer][number] for layer, number in stack.wefts.tolist())
        names = self.names["weave"], self.names["source"]
        return WrittenWeave(_signs(stack.over), wefts, warps, *names, self.palette, places)

    def _statement(self, line: Line) -> None:
        tokens = line.tokens()
        word = tokens[0].text.lower()
        if word[0].isdigit():
            self._matrix_line(line)
        elif word in self.names:
            self.names[word] = quoted_text(tokens)
        elif word == "colours":
            self.palette = quoted_palette(tokens)
        elif word == "layer":
            self._next_layer(tokens)
        elif word == "stitch":
            self.stitches.append(_Stitch(tokens))
        elif word in ("wefts", "warps"):
            self._read_threads(word, tokens)
        else:
            raise tokens[0].unexpected(STATEMENTS)

    def _matrix_line(self, line: Line) -> None:
        signs = []
        for column, sign in enumerate(line.text):
            if sign not in "01" and not sign.isspace():
                raise line.at(column).error(f"got {sign!r}; expected 1 (weft over) or 0 (warp over)")
            if not sign.isspace():
                signs.append(int(sign))
        if not self.layers:
            self._begin_layer()
        matrix = self.layers[-1]
        if matrix and len(signs) != len(matrix[0]):
            found = f"got {len(signs)} numbers where the first line has {len(matrix[0])}"
            raise line.place.error(f"{found}; expected one for each warp")
        matrix.append(signs)
        self.places[-1].append(line.place)

    def _next_layer(self, tokens: list[Token]) -> None:
        number = len(self.layers) + 1
        if self.layers and not self.layered:
            raise tokens[0].unexpected("no layer after a matrix without a layer; begin with layer 1:")
        if self.layers and not self.layers[-1]:
            raise tokens[0].unexpected(f"a line of 0 and 1 for each weft of layer {number - 1}")
        if tokens[1].text != str(number):
            raise tokens[1].unexpected(f"{number}, as layers are numbered from the front")
        _expect(tokens, 2, ":", expected="':'")
        _expect(tokens, 3, END, expected="the matrix of the layer on the lines below")
        self.layered = True
        self._begin_layer()

    def _begin_layer(self) -> None:
        self.layers.append([])
        self.places.append([])

    def _read_threads(self, kind: str, tokens: list[Token]) -> None:
        attribute = tokens[1].text.lower()
        if attribute not in PROPERTIES:
            raise tokens[1].unexpected(", ".join(PROPERTIES))
        if (kind, attribute) in self.threads:
            raise tokens[1].unexpected(f"the {attribute} of {kind} only once")
        _expect(tokens, 2, ":", expected="':'")
        if tokens[3].text == END:
            raise tokens[3].unexpected(f"a number for each of the {kind}")
        for token in tokens[3:-1]:
            _value(token, attribute)
        self.threads[kind, attribute] = tokens[3:-1]

    def _threads(self, kind: str, stack: Stack) -> tuple[Thread, ...]:
        threads = stack.threads(kind)
        for (owner, attribute), tokens in self.threads.items():
            if owner != kind:
                continue
            if len(threads) % len(tokens):
                expected = f"as many as there are {kind}, or a divisor of that number"
                raise tokens[0].place.error(f"got {len(tokens)} numbers for {len(threads)} {kind}; expected {expected}")
            values = [_value(token, attribute) for token in tokens] * (len(threads) // len(tokens))
            changes: list[dict[str, Any]] = [{attribute: value} for value in values]
            threads = tuple(replace(thread, **change) for thread, change in zip(threads, changes, strict=True))
        return threads


class _Stitch:
    """A statement that binds two layers."""

    def __init__(self, tokens: list[Token]) -> None:
        self.kind, self.yarn = _named_yarn(tokens, 1, ("warp", "weft"))
        _expect(tokens, 3, "over")
        other = "weft" if self.kind == "warp" else "warp"
        self.other = _named_yarn(tokens, 4, (other,))[1]
        _expect(tokens, 6, END)

    def bind(self, stack: Stack) -> None:
        """Bring the first yarn over the second yarn."""
        wefts, warps = (self.yarn, self.other) if self.kind == "weft" else (self.other, self.yarn)
        weft, warp = _place(stack.wefts, "weft", wefts), _place(stack.warps, "warp", warps)
        behind = int(stack.wefts[weft, 0] - stack.warps[warp, 0]) * (1 if self.kind == "weft" else -1)
        if behind <= 0:
            raise self.yarn.unexpected("a yarn of a layer behind the layer of the other yarn")
        stack.over[weft, warp] = self.kind == "weft"


def _named_yarn(tokens: list[Token], index: int, kinds: tuple[str, ...]) -> tuple[str, Token]:
    """Read the kind and the number of a yarn from two tokens."""
    _expect(tokens, index, *kinds)
    if not _YARN.fullmatch(tokens[index + 1].text):
        raise tokens[index + 1].unexpected(f"layer and number of a {tokens[index].text.lower()}, such as 2.1")
    return tokens[index].text.lower(), tokens[index + 1]


def _place(places: IntArray, kind: str, token: Token) -> int:
    """Return the index of a yarn among all yarns of its kind."""
    layer, number = (int(part) for part in token.text.split("."))
    found = np.flatnonzero((places == [layer - 1, number - 1]).all(axis=1))
    if not len(found):
        counts = np.bincount(places[:, 0])
        existing = ", ".join(f"{index}.1 to {index}.{count}" for index, count in enumerate(counts, start=1))
        raise token.unexpected(f"a {kind} of the weave: {existing}")
    return int(found[0])


def _signs(over: NDArray[np.bool_]) -> tuple[tuple[int, ...], ...]:
    return tuple(tuple(row) for row in over.astype(int).tolist())


def _expect(tokens: list[Token], index: int, *words: str, expected: str = "") -> None:
    token = tokens[index]
    if token.text.lower() not in words:
        raise token.unexpected(expected or " or ".join(words))


def _value(token: Token, attribute: str) -> float:
    if PROPERTIES[attribute] is int:
        least = 1 if attribute == "layer" else 0
        if not _COUNT.fullmatch(token.text) or int(token.text) < least:
            raise token.unexpected(f"the number of a {attribute}, from {least}")
        return int(token.text) - least
    if not _NUMBER.fullmatch(token.text) or not 0.0 < float(token.text) < float("inf"):
        raise token.unexpected(f"a positive factor of the {attribute}, such as 1.5")
    return float(token.text)


@dataclass(frozen=True, eq=False)
class Stack:
    """Layers of cloth one behind another, before stitches bind them."""

    over: NDArray[np.bool_]
    """Whether each weft passes over each warp, shape (wefts, warps)."""
    wefts: IntArray
    """Layer of each weft, and its number in that layer from 0, shape (wefts, 2)."""
    warps: IntArray
    """Layer of each warp, and its number in that layer from 0, shape (warps, 2)."""

    def threads(self, kind: str) -> tuple[Thread, ...]:
        """Return the threads of ``wefts`` or ``warps``, evenly spaced."""
        place: IntArray = getattr(self, kind)
        spacing = float(np.bincount(place[:, 0]).max() / len(place))
        return tuple(Thread(layer=int(layer), spacing=spacing) for layer in place[:, 0])


def stack_layers(layers: Sequence[NDArray[np.bool_]]) -> Stack:
    """Combine layers of cloth to one matrix.

    Args:
        layers: for each layer from the front, whether each of its wefts passes over each of its warps, shape
            (wefts, warps).
    """
    wefts = _distribute([len(layer) for layer in layers])
    warps = _distribute([layer.shape[1] for layer in layers])
    over = wefts[:, None, 0] < warps[None, :, 0]
    for index, layer in enumerate(layers):
        rows, columns = np.flatnonzero(wefts[:, 0] == index), np.flatnonzero(warps[:, 0] == index)
        over[np.ix_(rows, columns)] = layer
    return Stack(over, wefts, warps)


def _distribute(counts: Sequence[int]) -> IntArray:
    """Return the layer and number of the yarns of several layers in their order across the repeat, shape (n, 2)."""
    places = [(Fraction(2 * number + 1, 2 * count), layer, number)
              for layer, count in enumerate(counts) for number in range(count)]  # fmt: skip
    return np.array([(layer, number) for _, layer, number in sorted(places)])
