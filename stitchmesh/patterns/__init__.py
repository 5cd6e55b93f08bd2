# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Knitting patterns: rows of stitches, the text language and the charts that describe them, and a library.

The stub file ``__init__.pyi`` lists the public names and their modules. A module is imported at the first use of one of
its names, so that the command line starts without the pattern languages.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
