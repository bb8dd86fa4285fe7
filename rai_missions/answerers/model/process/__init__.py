# SPDX-License-Identifier: Apache-2.0
"""A model that is named by text, asked in a process of its own.

`worker` is what the process does: it holds the model. `life` is the engine's end of one such process, `model` the model
that is asked, whichever process it lives in now, and `words` is what goes over the pipes. The process itself, its guard
and its frames are `connectors.process`.

Imports `connectors`, and the modules of the root.
"""

from __future__ import annotations

__all__ = ()
