# SPDX-License-Identifier: Apache-2.0
"""What a campaign found: its figures, what differs beyond chance, its wrong answers, and every cell as a table.

Imports `tools`, and the modules of the root.
"""

from __future__ import annotations

__all__ = ()
