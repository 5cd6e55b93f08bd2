# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Mesh relaxation: equalize the sizes of the stitches on a surface (Yuksel et al. 2012, section 6.1).

The stub file ``__init__.pyi`` lists the public names and their modules. A module is imported when one of its names is
used first, so that the command line reads the default options without an import of Warp.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
