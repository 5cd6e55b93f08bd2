# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Drawing in the application: colours of a fabric, and colours and frames of yarns; time of the server, and bytes.

The first column is the processor time that the thread of the events needs until a message is ready to be sent, the
second one the bytes that the browser is sent. The third column is the time until the browser has everything on the
screen. It depends on the graphics hardware, and on what else the machine does; a browser without graphics hardware
draws in software.
"""

from __future__ import annotations

import platform
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import websockets.asyncio.server as websocket_server

from benchmarks.table import Rows
from stitchmesh.app.scene.drawing import Colours, Surface, YarnTubes
from stitchmesh.mesh.face_triangles import face_triangles
from stitchmesh.render.colour_scale import SEQUENTIAL, ColourScale
from stitchmesh.render.yarn_blocks import make_blocks
from stitchmesh.yarn.colours import row_colours
from tests.app.browser import Rig, rig_on, started_browser
from tests.gallery import tube as quad_tube
from tests.yarnrelax.stockinette import tube as yarn_tube

RUNS = 7
FACES = (260, 250)
"""Faces around and along the fabric."""
COLUMNS = ("server ms", "kB", "shown ms")
YARNS = {"100 k": (40, 208), "1 M": (130, 641)}
"""Rows and stitches of a tube of about so many control points."""
COMPLETE = """([version, name]) => {
  const found = Object.entries(window.stitchmeshYarns.report());
  return found.length > 0 && found.every(([own, one]) => own.endsWith(name) && one.waiting === 0 &&
    one.version >= version);
}"""
"""Whether all blocks of yarns are drawn, of a version and a name."""


class Counter:
    """Bytes that the server has sent."""

    def __init__(self) -> None:
        """Start at zero."""
        self.sent = 0

    @contextmanager
    def counting(self) -> Iterator[None]:
        """Count what is sent through all connections."""
        send = websocket_server.ServerConnection.send

        async def counted(connection: Any, data: Any, *arguments: Any, **options: Any) -> None:
            self.sent += len(data)
            await send(connection, data, *arguments, **options)

        websocket_server.ServerConnection.send = counted  # type: ignore[method-assign]
        try:
            yield
        finally:
            websocket_server.ServerConnection.send = send  # type: ignore[method-assign]


def measure(
    rig: Rig, counter: Counter, name: str, act: Callable[[int], None], shown: Callable[[int], None]
) -> Rows:
    """Yield the medians of some runs: milliseconds of the server, bytes, and milliseconds until it is shown."""
    rows = []
    for run in range(RUNS):
        rig.settle()
        before = counter.sent
        start = time.perf_counter()
        seconds = rig.call(timed, act, run)
        shown(run)
        rows.append((1e3 * seconds, counter.sent - before, 1e3 * (time.perf_counter() - start)))
    server, sent, whole = np.median(rows[1:], axis=0)
    yield name, f"{server:.1f}", f"{sent / 1e3:,.0f}", f"{whole:,.0f}"


def timed(act: Callable[[int], None], run: int) -> float:
    """Return the processor time of a call in this thread [s]."""
    start = time.thread_time()
    act(run)
    return time.thread_time() - start


def fabric_colours(rig: Rig, counter: Counter) -> Rows:
    """Measure the colours of a fabric."""
    mesh = quad_tube(*FACES)
    triangles, scale = face_triangles(mesh), ColourScale(SEQUENTIAL, 0.0, 1.0)
    place = np.random.default_rng(0).random(mesh.face_count)

    def drawing(run: int) -> Surface:
        colours = Colours.of(scale.of((place + 0.1 * run) % 1.0))
        index = Colours(colours.index[triangles.face], colours.palette)
        return Surface(points, triangles.corners, index)

    points = mesh.corner_position
    rig.call(rig.app.scene.look_at, points.min(axis=0), points.max(axis=0), "front")
    rig.call(rig.app.scene.show, "fabric", drawing(0))
    name = f"colours of {mesh.face_count:,} faces (no two alike)"
    yield from measure(
        rig, counter, name, lambda run: rig.app.scene.show("fabric", drawing(run)), lambda _: rig.settle()
    )
    rig.call(rig.app.scene.clear)


def yarn_frames(rig: Rig, counter: Counter, name: str, size: tuple[int, int]) -> Rows:
    """Measure colours and frames of yarns."""
    yarns = yarn_tube(*size)
    yield str(yarns)
    yield "", *COLUMNS
    first = YarnTubes(make_blocks(yarns), yarns.points, row_colours(yarns.row))
    rig.call(rig.app.scene.look_at, yarns.points.min(axis=0), yarns.points.max(axis=0), "front")
    versions, name_of_node = [0], [""]

    def shown(_: int) -> None:
        versions[0] += 1
        rig.browser_page.wait_for_function(COMPLETE, arg=[versions[0], name_of_node[0]])

    def whole(run: int) -> None:
        rig.app.scene.remove("yarns")
        rig.app.scene.show("yarns", YarnTubes(make_blocks(yarns), yarns.points, first.colours))
        versions[0] = 0
        name_of_node[0] = f"/yarns/{rig.app.scene._made}"

    def frame(run: int) -> None:
        rig.app.scene.show("yarns", YarnTubes(first.blocks, yarns.points + 0.01 * run, first.colours))

    def colour(run: int) -> None:
        rig.app.scene.show("yarns", YarnTubes(first.blocks, yarns.points, np.roll(first.colours, run, axis=0)))

    yield from measure(rig, counter, f"{name} control points, drawn anew", whole, shown)
    rig.call(rig.app.scene.show, "yarns", first)
    versions[0] = 1
    name_of_node[0] = f"/yarns/{rig.app.scene._made}"
    yield from measure(rig, counter, f"{name} control points, a frame", frame, shown)
    yield from measure(rig, counter, f"{name} control points, colours", colour, shown)
    rig.call(rig.app.scene.clear)


def drawing_latency() -> Rows:
    """Measure fabrics and yarns."""
    yield f"{platform.processor() or platform.machine()}, {platform.python_version()}"
    yield "", *COLUMNS
    counter = Counter()
    with counter.counting(), started_browser() as browser, tempfile.TemporaryDirectory() as folder:
        with rig_on(browser, Path(folder) / "project", "View") as rig:
            yield from fabric_colours(rig, counter)
            for name, size in YARNS.items():
                yield from yarn_frames(rig, counter, name, size)
