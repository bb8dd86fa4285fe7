# SPDX-License-Identifier: Apache-2.0
"""The pure engine: functions over a program and a run's state, behind `Chart`; what an event does is a Step.

Imports `guards`, `mission`, `model`, `planning` and `states`, and the modules of the root.
"""

from rai_missions.engine.chart import Chart
from rai_missions.engine.events import NOT_STARTED
from rai_missions.engine.program import Named
from rai_missions.engine.snapshot import Snapshot

__all__ = ("NOT_STARTED", "Chart", "Named", "Snapshot")
