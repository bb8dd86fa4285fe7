# SPDX-License-Identifier: Apache-2.0
"""Recognisers: each is loaded in the process that holds it.

Imports `connectors`, `voice`, and the modules of the root.
"""

__all__ = ()
