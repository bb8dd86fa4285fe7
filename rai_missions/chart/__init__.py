# SPDX-License-Identifier: Apache-2.0
"""The pure chart: SCXML's rules, activities, time and completion, layer by layer."""

from rai_missions.chart.chart import Chart, Snapshot
from rai_missions.chart.core import Named

__all__ = ("Chart", "Named", "Snapshot")
