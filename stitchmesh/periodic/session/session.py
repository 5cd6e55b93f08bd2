# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Live swatches: a session relaxes a swatch in the background, takes changes meanwhile, and provides frames.

Leaf et al. 2018, section 7.2: the user changes settings, and the swatch moves smoothly from its current state to the
new settings. A change that arrives before an earlier change is complete replaces the earlier change.
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
from stitchmesh.periodic.resolve_pattern import Source
from stitchmesh.periodic.session.frames import Frame
from stitchmesh.periodic.session.incremental_relaxation import LiveSwatch
from stitchmesh.periodic.session.settings import SwatchSettings
from stitchmesh.periodic.swatch_options import SwatchOptions
from stitchmesh.quality import DEFAULT_QUALITY, Quality, quality_named
from stitchmesh.yarnrelax import RelaxCell, YarnMaterial


class SwatchSession:
    """A swatch that relaxes in its own thread; all methods may be called from any thread.

    A session is closed by ``close``, at the end of a ``with`` block, or at the end of the program.
    """

    def __init__(
        self,
        pattern: FilePath | Source,
        *,
        material: YarnMaterial | None = None,
        quality: str | Quality = DEFAULT_QUALITY,
        device: str | None = None,
        relax_cell: bool | RelaxCell = False,
        **options: Any,
    ) -> None:
        """Generate the swatch, which is the first frame, and start its relaxation; arguments as for ``swatch``.

        Raises:
            StitchMeshError: as for ``swatch``, except for the errors of the relaxation.
        """
        self._settings = SwatchSettings(pattern, material, relax_cell, SwatchOptions(**options))
        self._requested_at = time.perf_counter()
        device_named(device)
        self._swatch = LiveSwatch(self._settings, quality_named(quality), device, self._requested_at)
        self._frame = self._swatch.frame
        self._condition = threading.Condition()
        self._changed = self._restart = self._idle = self._closed = False
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
        """Change settings of the swatch; returns at once.

        Equal settings change nothing. An error that appears only when the swatch is generated or relaxed, such as a
        chart that cannot be read, is the ``error`` of a frame.

        Args:
            changes: arguments of ``swatch``: pattern, material, relax_cell, and the fields of ``SwatchOptions``.

        Raises:
            ParameterError: there is no such argument, it cannot change, a value is out of bounds, or the session is
                closed.
        """
        with self._condition:
            self._check_open()
            settings = self._settings.changed(**changes)
            # a file of the same name may contain another pattern now
            if "pattern" not in changes and settings == self._settings:
                return
            self._request(settings, restart=False)

    def restart(self) -> None:
        """Generate the swatch again and relax it from the generated yarns, as ``swatch`` does; returns at once.

        Raises:
            ParameterError: the session is closed.
        """
        with self._condition:
            self._check_open()
            self._request(self._settings, restart=True)

    def wait_for_frame(self, timeout: float | None = None, *, after: int | None = None) -> Frame | None:
        """Wait for a frame that is newer than a given frame, and return the newest frame.

        Args:
            timeout: longest time to wait [s]; None waits without limit.
            after: number of the given frame; None for the newest frame at the time of the call.

        Returns:
            The newest frame; None if no newer frame arrives in this time, or if the session is closed.
        """
        with self._condition:
            seen = self._frame.number if after is None else after
            self._condition.wait_for(lambda: self._closed or self._frame.number > seen, timeout)
            return self._frame if self._frame.number > seen else None

    def wait_until_rest(self, timeout: float | None = None) -> Frame:
        """Wait until all changes are made and the relaxation has ended, and return the frame of that state.

        If the iterations of the quality are used up before the swatch has converged, ``at_rest`` in the report of the
        frame is False.

        Args:
            timeout: longest time to wait [s]; None waits without limit.

        Raises:
            SolverError: the relaxation does not end in this time, or the session was closed before.
            Exception: the ``error`` of the frame.
        """
        with self._condition:
            self._condition.wait_for(lambda: self._closed or self._idle, timeout)
            if not self._idle:
                late = f"not within {timeout} s; wait longer, or use the frames"
                why = "the session was closed before" if self._closed else late
                raise SolverError(f"session: the swatch did not come to rest: {why}")
            if self._frame.error is not None:
                raise self._frame.error
            return self._frame

    def close(self) -> None:
        """End the relaxation after the current assessment interval; the newest frame stays available."""
        with self._condition:
            self._closed = True
            self._condition.notify_all()
        self._worker.join()
        atexit.unregister(self.close)

    def _check_open(self) -> None:
        if self._closed:
            raise ParameterError("session: got a change after the session was closed; start another session")

    def _request(self, settings: SwatchSettings, *, restart: bool) -> None:
        """Give settings to the worker, in place of earlier settings that it has not taken yet."""
        self._restart = restart or (self._changed and self._restart)
        self._settings, self._requested_at, self._changed, self._idle = settings, time.perf_counter(), True, False
        self._condition.notify_all()

    def _work(self) -> None:
        """Take changes and relax until the session is closed; wait while there is nothing to do."""
        while True:
            with self._condition:
                self._condition.wait_for(lambda: self._closed or not self._idle)
                if self._closed:
                    return
                task = self._next_task()
                self._changed = False
            try:
                task()
            except Exception as error:  # any error reaches the user as the error of a frame
                self._swatch.halt(error)
            with self._condition:
                self._frame = self._swatch.frame
                self._idle = self._swatch.idle and not self._changed
                self._condition.notify_all()

    def _next_task(self) -> Callable[[], None]:
        """Return the next task: to take a change, or to iterate for one assessment interval."""
        if self._changed:
            return partial(self._swatch.take, self._settings, self._requested_at, restart=self._restart)
        return self._advance

    def _advance(self) -> None:
        """Iterate for one assessment interval; other sessions and relaxations wait meanwhile."""
        with alone():
            self._swatch.advance()
