# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""``python -m stitchmesh``."""

import sys

from stitchmesh.cli.main import main

sys.exit(main())
