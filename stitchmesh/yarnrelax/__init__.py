# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Physical relaxation of yarns (Leaf 2018, section 3; Yuksel 2012, section 6.3).

The stub file ``__init__.pyi`` lists the public names and their modules. A module is imported when one of its names is
used first, so that the command line reads the names of materials without an import of Warp.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
