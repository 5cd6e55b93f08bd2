# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Live swatches: a session relaxes a swatch in the background, takes changes while it does, and hands out frames.

Leaf et al. 2018, section 7.2: the user turns dials, and the swatch as it lies moves smoothly to what they say. A change
that comes before an older one is reached takes its place.
"""

from __future__ import annotations

import atexit
import threading
import time
from collections.abc import Callable
from functools import partial
from types import TracebackType
from typing import Any

from stitchmesh.compute.device import alone, device_named
from stitchmesh.errors import ParameterError, SolverError
from stitchmesh.io.contents import FilePath
from stitchmesh.periodic.frames import Frame
from stitchmesh.periodic.session_relaxation import LiveSwatch
from stitchmesh.periodic.session_wishes import Wishes
from stitchmesh.periodic.source import Source
from stitchmesh.periodic.swatch import SwatchOptions
from stitchmesh.quality import Quality, quality_named
from stitchmesh.yarnrelax import RelaxCell, YarnMaterial


class SwatchSession:
    """A swatch that relaxes in a thread of its own; all methods may be called from any thread.

    It is closed by ``close``, at the end of a ``with`` block, or with the program.
    """

    def __init__(
        self,
        pattern: FilePath | Source,
        *,
        material: YarnMaterial | None = None,
        quality: str | Quality = "standard",
        device: str | None = None,
        relax_cell: bool | RelaxCell = False,
        **options: Any,
    ) -> None:
        """Draw the swatch, which is the first frame, and begin to relax it; arguments as ``swatch``.

        Raises:
            StitchMeshError: as for ``swatch``, but for what only a relaxation can tell.
        """
        self._wishes = Wishes(pattern, material, relax_cell, SwatchOptions(**options))
        self._asked = time.perf_counter()
        device_named(device)
        self._swatch = LiveSwatch(self._wishes, quality_named(quality), device, self._asked)
        self._frame = self._swatch.frame
        self._news = threading.Condition()
        self._changed = self._anew = self._idle = self._closed = False
        self._worker = threading.Thread(target=self._work, name="swatch session", daemon=True)
        self._worker.start()
        atexit.register(self.close)

    def __enter__(self) -> SwatchSession:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    @property
    def frame(self) -> Frame:
        """The newest frame."""
        return self._frame

    def set(self, **changes: Any) -> None:
        """Change what the swatch is to be; returns at once.

        Wishes that are as they were change nothing. What can only be told where the swatch is drawn or relaxed, such
        as that a chart cannot be read, is the ``error`` of a frame.

        Args:
            changes: arguments of ``swatch``: pattern, material, relax_cell, and the fields of ``SwatchOptions``.

        Raises:
            ParameterError: there is no such argument, it cannot change, a value is out of bounds, or the session is
                closed.
        """
        with self._news:
            self._check_open()
            wishes = self._wishes.changed(**changes)
            # a file of the same name may hold another pattern by now
            if "pattern" not in changes and wishes == self._wishes:
                return
            self._ask(wishes, anew=False)

    def restart(self) -> None:
        """Draw the swatch anew and relax it from there, as ``swatch`` does; returns at once.

        Raises:
            ParameterError: the session is closed.
        """
        with self._news:
            self._check_open()
            self._ask(self._wishes, anew=True)

    def wait_for_frame(self, timeout: float | None = None, *, after: int | None = None) -> Frame | None:
        """The newest frame, once it is newer than another.

        Args:
            timeout: longest time to wait [s]; without end where not given.
            after: number of the other frame; that of the newest where not given.

        Returns:
            None if there is none in that time, or the session is closed.
        """
        with self._news:
            seen = self._frame.number if after is None else after
            self._news.wait_for(lambda: self._closed or self._frame.number > seen, timeout)
            return self._frame if self._frame.number > seen else None

    def wait_until_rest(self, timeout: float | None = None) -> Frame:
        """The frame of the swatch at rest, once all changes are made.

        Its report says if it is not at rest, for the iterations of its quality are used up.

        Args:
            timeout: longest time to wait [s]; without end where not given.

        Raises:
            SolverError: it does not come to rest in that time, or the session was closed before.
            Exception: the ``error`` of the frame.
        """
        with self._news:
            self._news.wait_for(lambda: self._closed or self._idle, timeout)
            if not self._idle:
                why = "it was closed before" if self._closed else f"in {timeout:g} s; wait longer, or take its frames"
                raise SolverError(f"session: the swatch did not come to rest: {why}")
            if self._frame.error is not None:
                raise self._frame.error
            return self._frame

    def close(self) -> None:
        """End the relaxation, within one burst of iterations; the newest frame stays."""
        with self._news:
            self._closed = True
            self._news.notify_all()
        self._worker.join()
        atexit.unregister(self.close)

    def _check_open(self) -> None:
        if self._closed:
            raise ParameterError("session: got a change after it was closed; begin another")

    def _ask(self, wishes: Wishes, anew: bool) -> None:
        """Leave wishes for the worker, in the place of older ones that it has not taken yet."""
        self._anew = anew or (self._changed and self._anew)
        self._wishes, self._asked, self._changed, self._idle = wishes, time.perf_counter(), True, False
        self._news.notify_all()

    def _work(self) -> None:
        """Take changes and relax until closed; sleep while there is nothing to do."""
        while True:
            with self._news:
                self._news.wait_for(lambda: self._closed or not self._idle)
                if self._closed:
                    return
                turn = self._turn()
                self._changed = False
            try:
                turn()
            except Exception as error:  # whatever it is, who waits is told
                self._swatch.halt(error)
            with self._news:
                self._frame = self._swatch.frame
                self._idle = self._swatch.idle and not self._changed
                self._news.notify_all()

    def _turn(self) -> Callable[[], None]:
        """What to do next: take a change, or one burst."""
        if self._changed:
            return partial(self._swatch.take, self._wishes, self._asked, anew=self._anew)
        return self._advance

    def _advance(self) -> None:
        """One burst, in turn with others."""
        with alone():
            self._swatch.advance()
