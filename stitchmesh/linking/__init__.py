# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How yarns are linked, decided in whole numbers.

Linking numbers: yarns and polygons become polylines with whole coordinates (``projection``). Two edges cross, and with
which sign, by one rule (``predicate``), which all pairs of near edges follow (``crossings``). The sums of the signs are
the certificate of yarns (``certificate``, for open yarns with ``open_yarns``) and the linking numbers of the test
curves of the loop check (``polygon_linking``).

Yarn through yarn: ``pulled_through`` deforms yarns into their later positions (``deformation_path``), finds where yarn
passes through yarn on the way (``crossings_along_path``, ``moving_edges``), and removes what cancels.
"""
