# SPDX-License-Identifier: Apache-2.0
"""The mission as it is authored: its model, its files, what files may include, its schema, its Python surface.

Imports `guards`, `model` and `states`, and the modules of the root. Runs nothing.
"""

__all__ = ()
