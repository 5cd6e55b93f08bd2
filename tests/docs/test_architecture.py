# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The graphs of docs/architecture.md agree with the imports, and their drawings have no overlaps."""

from __future__ import annotations

import re
import sys
from itertools import pairwise

import pytest

from tests.docs.pages import DOCS

sys.path.insert(0, str(DOCS / "site_build"))

from architecture_graph import GRAPHS, PAGE, import_graph, mermaid, page_with_graphs, reduced
from mermaid_svg import mermaid_to_svg

BOX = re.compile(r'<rect x="([\d.]+)" y="([\d.]+)" width="([\d.]+)" height="([\d.]+)"')
ENDS = re.compile(r'<path d="M([\d.]+),([\d.]+) .*?([\d.]+),([\d.]+)" fill="none"')


def test_the_page_is_up_to_date():
    # `python docs/site_build/architecture_graph.py` updates the page.
    page = PAGE.read_text()
    assert page_with_graphs(page) == page


@pytest.mark.parametrize("package", GRAPHS)
def test_the_graph_keeps_the_order_of_imports(package):
    graph = import_graph(package)
    assert reduced(graph) == graph
    assert all(other in graph for others in graph.values() for other in others)


def test_an_arrow_beside_a_longer_path_is_left_out():
    graph = {"a": {"b", "c", "d"}, "b": {"c"}, "c": {"d"}, "d": set()}
    assert reduced(graph) == {"a": {"b"}, "b": {"c"}, "c": {"d"}, "d": set()}


def test_the_error_of_a_cycle_names_the_cycle():
    with pytest.raises(ValueError, match="b -> c -> b"):
        reduced({"a": {"b"}, "b": {"c"}, "c": {"b"}})


@pytest.mark.parametrize("package", GRAPHS)
def test_the_boxes_of_the_picture_do_not_overlap_and_arrows_point_downwards(package):
    source = mermaid(package)
    picture = mermaid_to_svg(source)
    boxes = sorted((float(y), float(x), float(width)) for x, y, width, _ in BOX.findall(picture))
    assert len(boxes) == source.count("[")
    for (y, x, width), (next_y, next_x, _) in pairwise(boxes):
        assert y < next_y or x + width < next_x
    arrows = ENDS.findall(picture)
    assert len(arrows) == source.count("-->")
    assert all(float(bottom) > float(top) for _, top, _, bottom in arrows)


def test_a_line_that_is_neither_node_nor_arrow_is_an_error():
    with pytest.raises(ValueError, match="got the line"):
        mermaid_to_svg("flowchart TD\n    a --- b")
