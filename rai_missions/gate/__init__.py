# SPDX-License-Identifier: Apache-2.0
"""The gate: a small agent where the actuators are, which lets through only what the holder of control commands.

Rule: who holds control is what the gate reports, by `lifecycle.py`'s rules, whatever another program remembers.

Imports `connectors`, `mission`, `model`, `runtime` and `states`, and the modules of the root.
"""

from rai_missions.gate.config import CommandTopic, GateWords, gate_words, read_gate
from rai_missions.gate.gate import GateAgent

__all__ = ("CommandTopic", "GateAgent", "GateWords", "gate_words", "read_gate")
