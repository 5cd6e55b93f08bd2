# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Programs for knitting machines run in the interpreter of other authors, and make the same loops through loops there.

The interpreter refuses operations that a machine cannot do: crossed carriers, wrong racking, transfers to full needles.
"""

from __future__ import annotations

import pytest
from knitout_interpreter.run_knitout import run_knitout

from stitchmesh.machine_knitting import machine_program
from tests.hand_knitting.stitch_charts import chart_fabric
from tests.machine_knitting.knitout_machine import Machine
from tests.machine_knitting.test_knitout import FLAT, TUBES

CASES = [(FLAT["lace"], False), (FLAT["slips"], False), (FLAT["in turn"], False), (TUBES["narrowing"], True),
         (TUBES["rib and slips"], True), (TUBES["drawn together"], True)]  # fmt: skip


@pytest.mark.parametrize(("rows", "ring"), CASES)
def test_loops_are_drawn_through_the_same_loops(tmp_path, rows, ring):
    program = machine_program(chart_fabric(rows, ring=ring))
    (tmp_path / "p.k").write_text(program)
    _, _, graph = run_knitout(str(tmp_path / "p.k"))
    made = [entry for entry in Machine().run(program).made if entry.loop >= 0]
    number = {entry.loop: k for k, entry in enumerate(made)}
    loops = graph.sorted_loops
    assert len(loops) == len(made)
    order = {loop.loop_id: k for k, loop in enumerate(loops)}
    for loop, entry in zip(loops, made, strict=True):
        assert {order[low] for low in loop.parent_loop_ids} == {number[low] for low in entry.through}
