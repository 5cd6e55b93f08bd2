# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Scripts that run in the browser, and the code that installs them there.

Viser has no colours for single faces, no hints on buttons and no clicks on pieces of HTML. The script ``bridge.js``
adds them through hooks of viser's own client, so the version of viser is fixed.
"""
