# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Uploads of browsers are bounded in size and number, and belong to the browser that began them."""

from __future__ import annotations

import pytest

from stitchmesh.app.page_messages import LARGEST_UPLOAD, MOST_UPLOADS, PART, UploadGuard


@pytest.fixture
def uploads() -> UploadGuard:
    return UploadGuard()


def test_an_upload_sends_no_more_than_it_announced(uploads):
    assert uploads.may_start("a", 1, "b", PART + 2, 2)
    assert uploads.may_go_on("a", 1, "b", PART) and uploads.may_go_on("a", 1, "b", 2)
    assert not uploads.may_go_on("a", 1, "b", 1)
    assert uploads.may_start("a", 1, "b", 10, 1) and not uploads.may_go_on("a", 1, "b", 11)
    assert not uploads.may_go_on("a", 1, "b", 1)


@pytest.mark.parametrize(("size", "parts"), [(-1, 0), (-1, 1), (10, 0), (10, 2), (0, 1), (PART + 1, 1)])
def test_an_upload_has_the_number_of_parts_of_its_size(uploads, size, parts):
    assert not uploads.may_start("a", 1, "b", size, parts)


def test_the_largest_upload_is_the_one_that_is_stated(uploads):
    assert uploads.may_start("a", 1, "b", LARGEST_UPLOAD, LARGEST_UPLOAD // PART)
    assert not uploads.may_start("c", 1, "b", LARGEST_UPLOAD + 1, LARGEST_UPLOAD // PART + 1)


def test_no_other_browser_or_control_goes_on_with_an_upload(uploads):
    assert uploads.may_start("a", 1, "b", 10, 1) and not uploads.may_start("a", 2, "b", 10, 1)
    assert not uploads.may_go_on("a", 2, "b", 1) and not uploads.may_go_on("a", 1, "c", 1)
    assert uploads.may_go_on("a", 1, "b", 10)


def test_a_browser_that_leaves_makes_room_for_other_uploads(uploads):
    assert uploads.may_start("empty", 7, "b", 0, 0)
    assert all(uploads.may_start(str(number), 7, "b", 10, 1) for number in range(MOST_UPLOADS))
    assert not uploads.may_start("more", 8, "b", 10, 1)
    uploads.forget(7)
    assert uploads.may_start("more", 8, "b", 10, 1)
