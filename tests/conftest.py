# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Settings of all tests: each worker of pytest-xdist has a core, so kernels run on one thread unless a test says so."""

import os

from stitchmesh.compute.threads import VARIABLE

os.environ.setdefault(VARIABLE, "1")
