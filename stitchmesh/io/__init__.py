# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Files of polygon meshes, stitch meshes and yarns. Each format has a module of its own, and every write is atomic.

The stub file ``__init__.pyi`` lists the public names and their modules. A module is imported when one of its names is
used first, so that the command line can import the units of length without any file format.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
