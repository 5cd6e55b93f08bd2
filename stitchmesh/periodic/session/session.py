# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Live swatches: a session relaxes a swatch in the background, takes changes meanwhile, and provides frames.

Leaf et al. 2018, section 7.2: the user changes settings, and the swatch moves smoothly from its current state to the
new settings. A change that arrives before an earlier change is complete replaces the earlier change. The user can also
stop the relaxation, make single steps, start it again, and return to the first state.
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
from stitchmesh.yarnrelax import YarnMaterial
from stitchmesh.yarnrelax.stepwise_loop import INTERVAL


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
        iterations_per_frame: int = INTERVAL,
        stopped: bool = False,
        **options: Any,
    ) -> None:
        """Generate the swatch as the first frame, and start its relaxation; ``swatch`` describes other arguments.

        Args:
            pattern: a pattern or a weave, its name, or the path of its file.
            material: material of the yarn.
            quality: a preset or a ``Quality``.
            device: device of the kernels.
            iterations_per_frame: number of iterations between two frames.
            stopped: whether the relaxation waits for ``start`` or ``step``.
            options: fields of ``SwatchOptions``. A knit with friction moves as a preview without friction. It is then
                let go off the needles in one piece of work, and other sessions wait meanwhile.

        Raises:
            StitchMeshError: an error of ``swatch``, except for the errors of the relaxation.
        """
        self._settings = SwatchSettings(pattern, material, SwatchOptions(**options), quality_named(quality))
        self._first_settings, self._requested_at = self._settings, time.perf_counter()
        self._condition = threading.Condition()
        self._iterations_per_frame = _checked_count("iterations per frame", iterations_per_frame)
        device_named(device)
        self._changed = self._restart = self._closed = False
        self._stopped, self._steps, self._since_frame, self._quiet = stopped, 0, 0, stopped
        self._swatch = LiveSwatch(
            self._settings, device, self._requested_at, stopped=stopped, is_interrupted=self._is_interrupted
        )
        self._frame = self._swatch.frame
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

    @property
    def stopped(self) -> bool:
        """Whether the relaxation waits for ``start`` or ``step``."""
        return self._stopped

    @property
    def iterations_per_frame(self) -> int:
        """Number of iterations between two frames.

        The yarns are assessed every 20 iterations. Near rest they are assessed after each Newton step, which is not
        divided and may have more iterations than a frame. A frame between two assessments shows yarns whose energy has
        not been checked yet, with the residual and the energy of the last assessment.
        """
        return self._iterations_per_frame

    @iterations_per_frame.setter
    def iterations_per_frame(self, count: int) -> None:
        self._iterations_per_frame = _checked_count("iterations per frame", count)

    def start(self) -> None:
        """Let a stopped relaxation continue; returns at once.

        Raises:
            ParameterError: the session is closed.
        """
        with self._condition:
            self._check_open("start")
            self._stopped, self._steps = False, 0
            self._wake()

    def stop(self) -> None:
        """Stop the relaxation; returns at once.

        The iterations that run now are completed, at most up to the next assessment, and a last frame shows them.
        Settings can still change, but nothing relaxes before ``start`` or ``step``.

        Raises:
            ParameterError: the session is closed.
        """
        with self._condition:
            self._check_open("stop")
            self._stopped, self._steps = True, 0
            self._wake()

    def step(self, frames: int = 1, timeout: float | None = None) -> Frame:
        """Stop the relaxation, do the iterations of some frames, wait for them, and return the last frame.

        The first step of a running session completes its present frame. Nothing is iterated if the swatch is at rest.

        Args:
            frames: number of frames, each of ``iterations_per_frame`` iterations.
            timeout: longest time to wait [s]; None waits without limit.

        Raises:
            ParameterError: the session is closed, or the number is less than 1.
            SolverError: the iterations do not end in this time, or the session was closed before.
            Exception: the ``error`` of the frame.
        """
        with self._condition:
            self.request_steps(frames)
            return self._wait_until_quiet("the step did not end", timeout)

    def request_steps(self, frames: int = 1) -> None:
        """Stop the relaxation, and do the iterations of some frames, as ``step``; returns at once.

        Args:
            frames: number of frames, in addition to frames that were requested and are not made yet.

        Raises:
            ParameterError: the session is closed, or the number is less than 1.
        """
        _checked_count("step", frames)
        with self._condition:
            self._check_open("step")
            self._steps = frames + (self._steps if self._stopped else 0)
            self._stopped = True
            self._wake()

    def set(self, **changes: Any) -> None:
        """Change settings of the swatch; returns at once.

        Equal settings change nothing. An error that appears only when the swatch is generated or relaxed, such as a
        chart that cannot be read, is the ``error`` of a frame.

        Args:
            changes: arguments of ``swatch``: pattern, material, quality, and the fields of
                ``SwatchOptions``; or ``solver`` for another solver of the same quality.

        Raises:
            ParameterError: there is no such argument, it cannot change, a value is out of bounds, or the session is
                closed.
        """
        with self._condition:
            self._check_open("change")
            settings = self._settings.changed(**changes)
            # a file of the same name may contain another pattern now
            if "pattern" not in changes and settings == self._settings:
                return
            self._request(settings, restart=False)

    def restart(self) -> None:
        """Generate the swatch again and relax it from the generated yarns, as ``swatch`` does; returns at once.

        A stopped session shows the generated yarns and stays stopped.

        Raises:
            ParameterError: the session is closed.
        """
        with self._condition:
            self._check_open("restart")
            self._request(self._settings, restart=True)

    def reset(self) -> None:
        """Return to the settings and to the yarns with which the session began; returns at once.

        A stopped session stays stopped.

        Raises:
            ParameterError: the session is closed.
        """
        with self._condition:
            self._check_open("reset")
            self._request(self._first_settings, restart=True)

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
            SolverError: the relaxation does not end in this time, or the session is stopped or was closed before.
            Exception: the ``error`` of the frame.
        """
        with self._condition:
            frame = self._wait_until_quiet("the swatch did not come to rest", timeout)
            if not self._swatch.idle:
                raise SolverError("session: the swatch did not come to rest: it is stopped; start it first")
            return frame

    def close(self) -> None:
        """End the relaxation after the current assessment interval; the newest frame stays available."""
        with self._condition:
            self._closed = True
            self._condition.notify_all()
        self._worker.join()
        atexit.unregister(self.close)

    def _check_open(self, request: str) -> None:
        if self._closed:
            raise ParameterError(f"session: got a {request} after the session was closed; start another session")

    def _request(self, settings: SwatchSettings, *, restart: bool) -> None:
        """Give settings to the worker, in place of earlier settings that it has not taken yet."""
        self._restart = restart or (self._changed and self._restart)
        self._settings, self._requested_at, self._changed = settings, time.perf_counter(), True
        self._wake()

    def _wake(self) -> None:
        """Wake the worker, so that it sees the request."""
        self._quiet = False
        self._condition.notify_all()

    def _wait_until_quiet(self, what: str, timeout: float | None) -> Frame:
        """Wait until there is nothing to do, and return the newest frame.

        Raises:
            SolverError: there is something to do after this time, or the session was closed before.
            Exception: the ``error`` of the frame.
        """
        self._condition.wait_for(lambda: self._closed or self._quiet, timeout)
        if not self._quiet:
            late = f"not within {timeout} s; wait longer, or use the frames"
            raise SolverError(f"session: {what}: {'the session was closed before' if self._closed else late}")
        if self._frame.error is not None:
            raise self._frame.error
        return self._frame

    def _work(self) -> None:
        """Take changes and relax until the session is closed; wait while there is nothing to do."""
        while True:
            with self._condition:
                self._condition.wait_for(lambda: self._closed or not self._quiet)
                if self._closed:
                    return
                task = self._next_task()
            try:
                task()
            except Exception as error:  # any error reaches the user as the error of a frame
                self._swatch.halt(error)
            with self._condition:
                self._frame = self._swatch.frame
                self._quiet = not self._changed and self._has_nothing_to_do() and not self._frame.report["running"]
                self._condition.notify_all()

    def _next_task(self) -> Callable[[], None]:
        """Return the next task: to take a change, to iterate, or to make the last frame before a stop."""
        self._swatch.stopped = self._stopped and self._steps == 0
        if self._changed:
            self._changed = False
            self._since_frame = 0  # the change makes a frame of its own, from which iterations are counted
            return partial(self._swatch.take, self._settings, self._requested_at, restart=self._restart)
        if not self._has_nothing_to_do():
            return self._advance
        # a step that is requested from now on has frames of its own
        return partial(self._make_frame, ends_step=False) if self._frame.report["running"] else lambda: None

    def _is_interrupted(self) -> bool:
        """Return whether the session must do other work before it lets the knit go."""
        return self._closed or self._changed or (self._stopped and self._steps == 0)

    def _has_nothing_to_do(self) -> bool:
        """Whether the swatch is at rest, or stopped with a frame of its state."""
        if self._swatch.idle:
            self._steps = 0
            return True
        return self._stopped and self._steps == 0

    def _advance(self) -> None:
        """Iterate for a part of a frame; other sessions and relaxations wait meanwhile."""
        with alone():
            left = self._iterations_per_frame - self._since_frame
            self._since_frame += self._swatch.advance(max(left, 1))
            if self._since_frame >= self._iterations_per_frame or self._swatch.idle:
                self._make_frame()

    def _make_frame(self, *, ends_step: bool = True) -> None:
        """Make a frame of the current state; it ends a step, unless the step was requested after a pending change."""
        with self._condition:
            if ends_step and not self._changed:
                self._steps = max(self._steps - 1, 0)
            self._swatch.stopped = self._stopped and self._steps == 0
        self._swatch.publish()
        self._since_frame = 0


def _checked_count(name: str, count: int) -> int:
    """Return a count.

    Raises:
        ParameterError: the count is less than 1.
    """
    if count < 1:
        raise ParameterError(f"{name}: got {count}; expected at least 1")
    return count
