# SPDX-License-Identifier: Apache-2.0
"""A model that is named by text, asked in a process of its own.

`guard` is the program that is started: it forks, the child becomes the `worker` that holds the model, and the parent
watches its memory and ends everything that descends from it. `life` is the engine's end of one such process, `model`
the model that is asked, whichever process it lives in now. `frames` and `words` are what goes over the pipes: the
engine believes nothing of what comes back.

Imports `connectors`, and the modules of the root.
"""

from __future__ import annotations

__all__ = ()
