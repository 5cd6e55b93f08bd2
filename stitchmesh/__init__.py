# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""StitchMesh: from a polygon mesh of a garment to knitted, relaxed yarns.

The stub file ``__init__.pyi`` lists the public names and their modules. A module is imported when one of its names is
used first, so that ``import stitchmesh`` and the help of the command line are fast. The functions ``tessellate`` and
``render`` have the names of their packages; ``lazy_loader`` keeps an import of a package from replacing the function.
"""

import lazy_loader

__version__ = "0.1.0"

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
