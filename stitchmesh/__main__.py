# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Entry point of ``python -m stitchmesh``, which runs the command line."""

import sys

from stitchmesh.cli.main import main

sys.exit(main())
