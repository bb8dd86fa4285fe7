# SPDX-License-Identifier: Apache-2.0
"""Who a robot is: its description, pictures, build and documents.

Imports the modules of the root only.
"""

from rai_missions.embodiment.identity import Identity
from rai_missions.embodiment.urdf import Body

__all__ = ("Body", "Identity")
