# SPDX-License-Identifier: Apache-2.0
"""Sound to text to sound: turns of speech, recognisers, voices, and the echo of our own voice.

Frames come from a connector to sound. An `ear`, a recogniser and a voice live in a process each (`process`, `worker`):
one that crashes or hangs is named and started again, and takes nothing along. `turns` and `spoken_text` are pure.

Rule: nothing here knows of missions, orders or roles. A transcript is what a person may have uttered, and no more.

Imports `connectors`, and the modules of the root.
"""

from __future__ import annotations

__all__ = ()
