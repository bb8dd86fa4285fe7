# SPDX-License-Identifier: Apache-2.0
"""The answerer that asks a language model, and what it needs: providers, prompts, replies, tools, deadlines.

Imports langchain when used.
"""

__all__ = ()
