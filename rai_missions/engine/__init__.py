# SPDX-License-Identifier: Apache-2.0
"""The pure chart: SCXML's rules, activities, time and completion, layer by layer.

Imports `guards`, `mission` and `states`, and the modules of the root.
"""

from rai_missions.engine.chart import NOT_STARTED, Chart, Snapshot
from rai_missions.engine.state import Named

__all__ = ("NOT_STARTED", "Chart", "Named", "Snapshot")
