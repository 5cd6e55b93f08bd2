# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The request to stop a running job, for example because the process got a signal."""

from __future__ import annotations


class JobStopped(Exception):
    """The user has stopped a job; its relaxation has written a checkpoint."""


class StopRequest:
    """A request to stop. A job checks it between stages and at each report of its progress."""

    def __init__(self) -> None:
        """Begin without a request."""
        self.asked = False
        """Whether the job shall stop."""

    def ask(self) -> None:
        """Ask the job to stop; returns at once, and may be called in a signal handler or in another thread."""
        self.asked = True

    def check(self) -> None:
        """Return if nobody has asked.

        Raises:
            JobStopped: somebody has asked.
        """
        if self.asked:
            raise JobStopped
