# SPDX-License-Identifier: Apache-2.0
"""The index of an identity's documents: one SQLite file with passages, their words and their vectors.

Imports the modules of the root only.
"""

from __future__ import annotations

from rai_missions.embodiment.index.build import BuildReport, build_index
from rai_missions.embodiment.index.database import IndexReader
from rai_missions.embodiment.index.place import index_place

__all__ = ("BuildReport", "IndexReader", "build_index", "index_place")
