# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The servers of Dask without their pages.

By default each server also serves pages and numbers by HTTP to anyone, even if its tasks need a certificate and no
dashboard is asked for.
"""

from __future__ import annotations

from typing import Any

from distributed import Scheduler, Worker


class ClosedScheduler(Scheduler):
    """A scheduler that serves no pages."""

    def start_http_server(self, *_arguments: Any, **_options: Any) -> None:
        """Start no server for pages."""


class ClosedWorker(Worker):
    """A worker that serves no pages."""

    def start_http_server(self, *_arguments: Any, **_options: Any) -> None:
        """Start no server for pages."""
