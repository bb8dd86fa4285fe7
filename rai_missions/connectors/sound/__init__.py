# SPDX-License-Identifier: Apache-2.0
"""Sound in and out, frame by frame: devices, files, topics, and a simulated room.

Imports `connectors`, and the modules of the root.
"""

from __future__ import annotations

__all__ = ()
