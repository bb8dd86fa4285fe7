# SPDX-License-Identifier: Apache-2.0
"""Who a robot is: its description, pictures, build and documents, and what it can look up in them.

Imports the modules of the root only.
"""

from rai_missions.embodiment.identity import Identity
from rai_missions.embodiment.library import Library, NearestPassages
from rai_missions.embodiment.passage import DocumentPassage, FoundPassages
from rai_missions.embodiment.urdf import Body

__all__ = ("Body", "DocumentPassage", "FoundPassages", "Identity", "Library", "NearestPassages")
