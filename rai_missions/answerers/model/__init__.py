# SPDX-License-Identifier: Apache-2.0
"""The answerer that asks a language model, and what it needs: providers, prompts, replies, tools, deadlines.

Imports `check`, `connectors`, `embodiment`, `engine`, `mission`, `profile` and `tools`, and the modules of the root.
"""

__all__ = ()
