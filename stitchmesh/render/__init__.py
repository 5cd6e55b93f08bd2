# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Off-screen pictures of meshes, fabrics and yarns.

The stub file ``__init__.pyi`` lists the names and their modules. A module is imported at the first use of one of its
names, because the application needs colours and packed yarns of this package, and no pictures.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
