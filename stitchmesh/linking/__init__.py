# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How yarns are linked, and whether yarn passed through yarn, decided in whole numbers.

Linking numbers:

- ``projection`` makes polylines with whole coordinates of yarns (``yarn_samples``) and of polygons.
- ``predicate`` decides whether two edges cross, and with which sign; degenerate positions count as displaced.
- ``crossings`` applies it to all pairs of near edges.
- ``certificate`` sums the signs for all pairs of yarns and images (``pairs_of_images``), and compares the sums before
  and after a relaxation. ``open_yarns`` closes open yarns artificially.
- ``polygon_linking`` sums the signs for closed polygons, which are the test curves of the loop check.

Yarn through yarn:

- ``pulled_through`` decides which crossings of yarn through yarn remain on every deformation path.
- ``deformation_path`` moves yarns (``yarn_polylines``) into their later positions.
- ``crossings_along_path`` finds all crossings on the way, by ``moving_edges`` in ``general_position``.
- ``cancelling_crossings`` removes those that ``rings`` without yarn in them undo.
"""
