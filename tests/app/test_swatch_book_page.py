# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The page of a swatch book in a real browser, opened from its folder."""

from __future__ import annotations

import pytest
from playwright.sync_api import Browser, Page, expect

import stitchmesh as sm

SIZES = [(1280, 800), (390, 844)]
"""Windows of a computer and of a telephone [pixels]."""


@pytest.fixture(scope="module")
def address(tmp_path_factory: pytest.TempPathFactory) -> str:
    """The address of a book of two patterns."""
    book = sm.SwatchBook(
        patterns=("stockinette", "linen-stitch"), relaxation="frictionless", device="cpu", stretched=False
    )
    return sm.write_book(book, tmp_path_factory.mktemp("book") / "library", workers=0, progress=False).as_uri()


def opened(browser: Browser, address: str, size: tuple[int, int], faults: list[str]) -> Page:
    page = browser.new_page(viewport={"width": size[0], "height": size[1]})
    page.on("console", lambda message: faults.append(message.text))
    page.on("pageerror", lambda error: faults.append(str(error)))
    page.goto(address)
    return page


def picture_of(page: Page) -> str:
    found: str = page.locator("#turning").evaluate("canvas => canvas.toDataURL()")
    return found


@pytest.mark.parametrize("size", SIZES)
def test_a_leaf_opens_and_its_fabric_turns(browser: Browser, address: str, size: tuple[int, int]) -> None:
    faults = list[str]()
    page = opened(browser, address, size, faults)
    expect(page.locator("#found")).to_have_text("2 patterns")
    page.locator("#search").fill("linen")
    expect(page.locator("#cards li:visible")).to_have_count(1)
    page.get_by_role("link", name="Linen").click()
    expect(page.locator("#title")).to_contain_text("Linen")
    canvas = page.locator("#turning")
    expect(canvas).to_be_visible()
    before = picture_of(page)
    canvas.focus()
    page.keyboard.press("ArrowRight")
    page.wait_for_function("before => document.getElementById('turning').toDataURL() !== before", arg=before)
    expect(page.locator("#figures")).to_contain_text("Width beside stockinette")
    assert page.locator("#chart").evaluate("image => image.complete && image.naturalWidth > 0")
    assert page.evaluate("document.documentElement.scrollWidth") <= size[0], "nothing stands beside the window"
    page.get_by_role("button", name="All patterns").click()
    expect(page.locator("#list")).to_be_visible()
    page.goto(f"{address}#stockinette")
    expect(page.locator("#title")).to_have_text("Stockinette")
    page.close()
    assert not faults
