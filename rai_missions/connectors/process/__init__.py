# SPDX-License-Identifier: Apache-2.0
"""A process of its own for what may hang, crash or take memory: a model, a recogniser, a voice.

`guard` is the program that is started: it forks, the child does the work, and the parent watches its memory and ends
everything that descends from it. `life` is our end of one such process. `frames` is what goes over the pipes: nothing
of what comes back is believed.

Imports `connectors`, and the modules of the root.
"""

from __future__ import annotations

__all__ = ()
