# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The rig of the browser tests reaches every kind of control, and notices faults."""

from __future__ import annotations

import re
from typing import Any, ClassVar

import numpy as np
import pytest

from stitchmesh.app.pages import all_pages
from stitchmesh.app.pages.page import Page
from stitchmesh.app.scene.scene import Pick
from stitchmesh.errors import ParameterError
from tests.gallery import tube


class Sampler(Page):
    """A page with one control of each kind, which remembers what it was given."""

    name: ClassVar[str] = "Project"
    hint: ClassVar[str] = "Try everything."

    def build(self) -> None:
        self.given: list[Any] = []
        controls, give = self.app.controls, self.given.append
        controls.button("Go", "Starts.", lambda: give("go"), main=True)
        controls.number("Width", "A width.", 0.8, give, least=0.1, most=5.0, step=0.1)
        controls.toggle("Arrows", "Whether arrows are shown.", False, give)
        controls.choice("Kind", "A kind.", ["plain", "purl"], "plain", give)
        controls.text("Name", "A name.", "abc", give)
        controls.slider("Gamma", "A dial.", 0.5, give, least=0.0, most=1.0, step=0.1)
        controls.buttons("Side", "A side.", ["Left", "Right"], give)
        controls.upload("Mesh", "A file.", [".obj"], lambda name, content: give((name, len(content))))
        controls.button("Save", "Sends a file.", lambda: self.app.download("a.txt", b"content"))
        controls.button("Fail", "Raises an error.", self._fail)
        controls.html('<button data-action="turn" data-value="7">Turn</button>', lambda *words: give(words))
        controls.key("Undo", "Undoes.", "Z", "ctrl", lambda: give("undo"))
        points = tube(12, 4).vertices
        self.app.scene.look_at(points.min(axis=0), points.max(axis=0))

    def picked(self, pick: Pick) -> None:
        self.given.append(pick)

    def _fail(self) -> None:
        raise ParameterError("width: got 0; expected a positive number")


@pytest.fixture
def sampler(monkeypatch, app_in_browser):
    monkeypatch.setitem(all_pages.PAGES, "Project", Sampler)
    return lambda **options: app_in_browser(page="Project", **options)


def test_each_control_is_reached(sampler, tmp_path):
    (tmp_path / "a.obj").write_bytes(b"12345678")
    with sampler() as rig:
        rig.press("Go")
        rig.type("Width", 1.2)
        rig.tick("Arrows")
        rig.choose("Kind", "purl")
        rig.type("Name", "xyz")
        rig.type("Gamma", 0.7)
        rig.press("Side", "Right")
        rig.upload(tmp_path / "a.obj")
        rig.wait_for(lambda: ("a.obj", 8) in rig.app.page.given)
        rig.act("turn", "7")
        rig.key("Control+z")
        rig.settle()
        assert rig.app.page.given == [
            "go", 1.2, True, "purl", "xyz", 0.7, "Right", ("a.obj", 8), ("turn", "7"), "undo"
        ]  # fmt: skip
        assert rig.downloaded(lambda: rig.press("Save")) == ("a.txt", b"content")


def test_a_click_arrives_at_the_point_where_the_scene_is_drawn(sampler):
    with sampler() as rig:
        point = np.array([0.5, 2.0, 2.9])
        rig.click_at(point)
        (pick,) = rig.app.page.given
        across = point - pick.ray_origin
        off = np.linalg.norm(np.cross(across, pick.ray_direction))
        assert off < 0.02  # A pixel is 0.01 cm wide at this distance.


def test_an_error_becomes_a_notice_and_no_fault(sampler):
    with sampler() as rig:
        rig.press("Fail")
        rig.wait_for_text("width: got 0; expected a positive number")
        assert any("expected a positive number" in notice for notice in rig.notices())


def test_a_fault_in_the_page_fails_the_test(sampler):
    with pytest.raises(AssertionError, match=re.escape("console: broken")), sampler() as rig:
        rig.browser_page.evaluate("() => console.error('broken')")
