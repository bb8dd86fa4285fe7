# SPDX-License-Identifier: Apache-2.0
"""Secrets taken out of what comes from outside: texts, logs, and what is cut to a length.

Imports nothing of ours but how errors are worded.
"""

__all__ = ()
