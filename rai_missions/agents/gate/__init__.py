# SPDX-License-Identifier: Apache-2.0
"""The gate: a small agent where the actuators are, which lets through only what the holder of control commands.

Rule: it takes its orders from nobody's memory. Who holds control is what the gate says, by `lifecycle.py`'s rules.
"""

from rai_missions.agents.gate.agent import GateAgent
from rai_missions.agents.gate.rules import step
from rai_missions.agents.gate.values import Gate, Terms, status_of
from rai_missions.agents.gate.words import CommandTopic, GateWords, gate_words, read_gate

__all__ = ("CommandTopic", "Gate", "GateAgent", "GateWords", "Terms", "gate_words", "read_gate", "status_of", "step")
