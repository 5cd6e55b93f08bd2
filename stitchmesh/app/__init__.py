# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The application in the browser: it shows and calls the stages, and holds no physics and no topology."""
