# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Draws a Mermaid flow chart without cycles as SVG, in layers from the top to the bottom.

The layout is that of Sugiyama, Tagawa and Toda, *Methods for visual understanding of hierarchical system structures*
(1981): each node stands one layer below the lowest node that points to it; an arrow across several layers gets a point
in each; the order in each layer follows the mean place of the neighbours, by turns downwards and upwards, and of all
orders met the one with the fewest crossings is taken.
"""

from __future__ import annotations

import re
from html import escape
from itertools import pairwise

Node = str | tuple[str, str, int]
"""A node of the chart, or the point of an arrow from one node to another in a layer."""

CHARACTER, HEIGHT, PADDING, GAP, LAYER_GAP, POINT = 7.8, 28.0, 9.0, 18.0, 40.0, 6.0
"""Width of a letter, height of a box, space within it, between boxes and between layers, width of a point [px]."""
SWEEPS = 40


def mermaid_to_svg(source: str) -> str:
    """The picture of a flow chart whose lines are ``flowchart TD``, ``name[label]`` and ``name --> other``.

    Raises:
        ValueError: a line is none of these.
    """
    labels, arrows = _read(source)
    layers, paths = _layers(sorted(labels), arrows)
    layers = _ordered(layers, paths)
    width = {node: _width(node, labels) for layer in layers for node in layer}
    x = _places(layers, paths, width)
    y = {node: 1 + number * (HEIGHT + LAYER_GAP) for number, layer in enumerate(layers) for node in layer}
    return _svg(labels, paths, x, y, width)


def _read(source: str) -> tuple[dict[str, str], list[tuple[str, str]]]:
    labels: dict[str, str] = {}
    arrows = []
    for line in source.strip().splitlines()[1:]:
        if node := re.fullmatch(r"\s*(\w+)\[(.+)\]", line):
            labels[node[1]] = node[2]
        elif arrow := re.fullmatch(r"\s*(\w+) --> (\w+)", line):
            arrows.append((arrow[1], arrow[2]))
        else:
            raise ValueError(f"flow chart: got the line {line!r}; expected 'name[label]' or 'name --> other'")
    return labels, arrows


def _layers(nodes: list[str], arrows: list[tuple[str, str]]) -> tuple[list[list[Node]], list[list[Node]]]:
    """Nodes and points layer by layer, and each arrow as the nodes and points that it runs through."""
    above: dict[str, list[str]] = {node: [a for a, b in arrows if b == node] for node in nodes}
    level: dict[str, int] = {}

    def level_of(node: str) -> int:
        if node not in level:
            level[node] = 1 + max((level_of(other) for other in above[node]), default=-1)
        return level[node]

    layers: list[list[Node]] = [[] for _ in range(1 + max(level_of(node) for node in nodes))]
    for node in nodes:
        layers[level[node]].append(node)
    paths: list[list[Node]] = []
    for a, b in arrows:
        points: list[Node] = [(a, b, number) for number in range(level[a] + 1, level[b])]
        for number, point in enumerate(points, level[a] + 1):
            layers[number].append(point)
        paths.append([a, *points, b])
    return layers, paths


def _neighbours(paths: list[list[Node]]) -> tuple[dict[Node, list[Node]], dict[Node, list[Node]]]:
    """Nodes and points directly above and directly below each."""
    above: dict[Node, list[Node]] = {}
    below: dict[Node, list[Node]] = {}
    for path in paths:
        for a, b in pairwise(path):
            below.setdefault(a, []).append(b)
            above.setdefault(b, []).append(a)
    return above, below


def _ordered(layers: list[list[Node]], paths: list[list[Node]]) -> list[list[Node]]:
    above, below = _neighbours(paths)
    best, fewest = layers, _crossings(layers, below)
    for sweep in range(SWEEPS):
        sides = above if sweep % 2 == 0 else below
        layers = [list(layer) for layer in layers]
        numbers = range(1, len(layers)) if sweep % 2 == 0 else range(len(layers) - 2, -1, -1)
        for number in numbers:
            place = {node: i for layer in layers for i, node in enumerate(layer)}
            layers[number].sort(
                key=lambda node, place=place: _mean([place[o] for o in sides.get(node, [])], place[node])
            )
        if (count := _crossings(layers, below)) < fewest:
            best, fewest = layers, count
    return best


def _mean(values: list[float] | list[int], otherwise: float) -> float:
    return sum(values) / len(values) if values else otherwise


def _crossings(layers: list[list[Node]], below: dict[Node, list[Node]]) -> int:
    count = 0
    for upper, lower in pairwise(layers):
        place = {node: i for i, node in enumerate(lower)}
        ends = [place[o] for node in upper for o in sorted(below.get(node, []), key=place.__getitem__)]
        count += sum(a > b for i, a in enumerate(ends) for b in ends[i + 1 :])
    return count


def _places(layers: list[list[Node]], paths: list[list[Node]], width: dict[Node, float]) -> dict[Node, float]:
    """Middle of each node and point [px]: near the mean of its neighbours, apart from those beside it."""
    above, below = _neighbours(paths)
    x: dict[Node, float] = {}
    for layer in layers:
        left = 0.0
        for node in layer:
            x[node] = left + width[node] / 2
            left += width[node] + GAP
    for _ in range(SWEEPS):
        for layer in layers:
            wanted = [_mean([x[o] for o in above.get(n, []) + below.get(n, [])], x[n]) for n in layer]
            x.update(zip(layer, _apart(wanted, [width[n] for n in layer]), strict=True))
    left = min(x[node] - width[node] / 2 for node in x)
    return {node: place - left + 1 for node, place in x.items()}


def _apart(wanted: list[float], widths: list[float]) -> list[float]:
    """Places in the same order that leave a gap everywhere: the mean of moving right only and of moving left only."""
    right, left = list(wanted), list(wanted)
    for i in range(1, len(wanted)):
        right[i] = max(right[i], right[i - 1] + (widths[i - 1] + widths[i]) / 2 + GAP)
        j = len(wanted) - 1 - i
        left[j] = min(left[j], left[j + 1] - (widths[j] + widths[j + 1]) / 2 - GAP)
    return [(a + b) / 2 for a, b in zip(left, right, strict=True)]


def _width(node: Node, labels: dict[str, str]) -> float:
    return CHARACTER * len(labels[node]) + 2 * PADDING if isinstance(node, str) else POINT


def _svg(
    labels: dict[str, str],
    paths: list[list[Node]],
    x: dict[Node, float],
    y: dict[Node, float],
    width: dict[Node, float],
) -> str:
    right, bottom = max(x[n] + width[n] / 2 for n in x) + 1, max(y.values()) + HEIGHT + 1
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{right:.0f}" height="{bottom:.0f}" role="img">',
        '<defs><marker id="arrow" markerWidth="8" markerHeight="8" refX="7" refY="4" orient="auto">'
        '<path d="M0,1 L7,4 L0,7 z"/></marker></defs>',
    ]
    parts += [f'<path d="{_curve(path, x, y)}" fill="none" marker-end="url(#arrow)"/>' for path in paths]
    for node, label in labels.items():
        left, top = x[node] - width[node] / 2, y[node]
        parts.append(f'<rect x="{left:.1f}" y="{top:.1f}" width="{width[node]:.1f}" height="{HEIGHT}" rx="4"/>')
        middle = f'x="{x[node]:.1f}" y="{top + 0.64 * HEIGHT:.1f}"'
        parts.append(f'<text {middle} text-anchor="middle" font-size="13">{escape(label)}</text>')
    return "".join([*parts, "</svg>"])


def _curve(path: list[Node], x: dict[Node, float], y: dict[Node, float]) -> str:
    """From the bottom of the first box to the top of the last, straight down past the boxes of the layers between."""
    text = f"M{x[path[0]]:.1f},{y[path[0]] + HEIGHT:.1f}"
    for a, b in pairwise(path):
        start, end = y[a] + HEIGHT, y[b]
        bend = (end - start) / 2
        text += f" C{x[a]:.1f},{start + bend:.1f} {x[b]:.1f},{end - bend:.1f} {x[b]:.1f},{end:.1f}"
        if b is not path[-1]:
            text += f" L{x[b]:.1f},{end + HEIGHT:.1f}"
    return text
