# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarn generation: from stitch faces to yarn curves (Yuksel et al. 2012, sections 4 and 6.2).

The stub file ``__init__.pyi`` lists the public names and their modules. A module is imported when one of its names is
used first, so that the command line reads the defaults of ``YarnFinish`` without an import of SciPy.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
