# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The control of how increases are made, on the pages that make stitches."""

from __future__ import annotations

from collections.abc import Callable

from stitchmesh.app.controls.controls import Control, Controls
from stitchmesh.mesh.shaping_stitches import Increase

WORDS: dict[Increase, str] = {
    "m1": "make one (m1l, m1r)",
    "kfb": "knit front and back",
    "lifted": "lifted, from the loop below",
    "yo": "yarn over, with a hole",
}
"""Forms of increases, in words."""


def increase_choice(controls: Controls, chosen: Increase, take: Callable[[Increase], object]) -> Control:
    """Make the control; its values are ``WORDS``.

    Args:
        controls: the controls of the page.
        chosen: the form that is chosen first.
        take: called with another form.
    """
    forms = {words: form for form, words in WORDS.items()}
    return controls.choice(
        "Increases", "How increases are made.", tuple(forms), WORDS[chosen], lambda words: take(forms[words])
    )
