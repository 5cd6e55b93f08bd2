# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarn generation: from stitch faces to yarn curves (Yuksel et al. 2012, sections 4 and 6.2).

A public name is imported when it is first used. The command line therefore reads the defaults of ``finish`` without
importing SciPy.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from stitchmesh.yarngen.finish import YarnFinish
    from stitchmesh.yarngen.generate import generate_yarns, mean_stitch_width
    from stitchmesh.yarngen.loop_check.loop_linking import check_loops
    from stitchmesh.yarngen.loop_ownership import belongs_to_loop_below
    from stitchmesh.yarngen.regenerate import regenerate_yarns

_HOME = {
    "YarnFinish": "finish",
    "generate_yarns": "generate",
    "mean_stitch_width": "generate",
    "belongs_to_loop_below": "loop_ownership",
    "check_loops": "loop_check.loop_linking",
    "regenerate_yarns": "regenerate",
}
"""Name of the module that defines each public name."""

__all__ = [
    "YarnFinish",
    "belongs_to_loop_below",
    "check_loops",
    "generate_yarns",
    "mean_stitch_width",
    "regenerate_yarns",
]


def __getattr__(name: str) -> object:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
