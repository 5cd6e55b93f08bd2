# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Start of the application: from the command to its address, and to the first picture in an open browser.

The browser is Chromium, which draws in software; the time of the server is printed by itself, also as processor time,
which depends less on other work of the machine.
"""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from statistics import median

from playwright.sync_api import Browser

from benchmarks.table import Rows
from tests.app.browser import started_browser

ADDRESS = re.compile(r"http://127\.0\.0\.1:\d+/\S*")
SIZE = {"width": 1280, "height": 800}
DRAWN = """() => {
  const state = window.__viserMutable;
  if (!state || !state.scene || !state.canvas || state.messageQueue.length) return false;
  const opacity = state.canvas.style.opacity;
  const triangles = window.__viserTestpoints.rendererInfo.render.triangles;
  return triangles > 100 && (opacity === "" || parseFloat(opacity) >= 1);
}"""
"""Whether the mesh is drawn: the scene has more triangles than its background, and is not faded any more."""


def app_start(mesh: Path, /) -> Rows:
    """Start the application several times, and print the medians."""
    with started_browser() as browser:
        times = [one_start(browser, mesh) for _ in range(5)]
    listening, drawn, processor = (median(column) for column in zip(*times, strict=True))
    yield f"{mesh.stem}: address after {listening:.2f} s, first picture after {drawn:.2f} s"
    yield f"processor time until the address: {processor:.2f} s"
    slowest = [max(column) for column in zip(*times, strict=True)]
    yield f"medians of {len(times)} starts; the slowest: {slowest[0]:.2f} s and {slowest[1]:.2f} s"


def one_start(browser: Browser, mesh: Path) -> tuple[float, float, float]:
    """Start the application once.

    Returns:
        The times after which its address and its first picture appeared, and its processor time until the address [s].
    """
    with tempfile.TemporaryDirectory() as folder:
        options = ["--project", f"{folder}/project", "--port", "0", "--no-browser"]
        command = [sys.executable, "-m", "stitchmesh", "app", str(mesh), *options]
        began = time.perf_counter()
        process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        try:
            address = address_of(process)
            listening, processor = time.perf_counter() - began, processor_time(process.pid)
            page = browser.new_page(viewport=SIZE)
            page.goto(address)
            page.wait_for_function(DRAWN, timeout=60_000)
            drawn = time.perf_counter() - began
            page.close()
        finally:
            process.send_signal(signal.SIGINT)
            process.wait(timeout=30)
    return listening, drawn, processor


def processor_time(process: int) -> float:
    """Return the processor time that a process has taken so far [s]; Linux tells it in ticks."""
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def address_of(process: subprocess.Popen[str]) -> str:
    """Return the address that the program prints."""
    assert process.stdout is not None
    for line in process.stdout:
        if found := ADDRESS.search(line):
            return found[0]
    raise SystemExit("the application ended before it printed its address")
