# SPDX-License-Identifier: Apache-2.0
"""The pure engine: functions over a program and a run's state, behind `Chart`; what an event does is a Step.

`chart` is the door, `state` all that a run remembers, `step` what an event has done, as a value. `compiled` is the
mission made ready, `semantics` what an event does to a run, `activities` what states run, and `trees` ticks trees.

Imports `guards`, `mission`, `model`, `planning` and `states`, and the modules of the root.
"""

from rai_missions.engine.chart import Chart
from rai_missions.engine.compiled.program import Named
from rai_missions.engine.snapshot import Snapshot

__all__ = ("Chart", "Named", "Snapshot")
