# SPDX-License-Identifier: Apache-2.0
"""All that a chart remembers, as values: to go on from there, in another process or in another mission.

Rule: what can be worked out of the rest is worked out anew.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from rai_missions.engine.configuration import Configuration
from rai_missions.engine.snapshot_json import unpacked
from rai_missions.engine.state import Timer, TimerKey
from rai_missions.engine.step import Move
from rai_missions.engine.timing import Instants

__all__ = ("Saving", "Snapshot")

Snapshot = Mapping[str, Any]
"""All that a chart remembers, as values; `Chart.restore` goes on from there."""

VALUES = (
    "seq", "mode", "holder", "outcome", "why", "cause", "false_invariant", "_order", "_number", "_paused_at", "_queue",
    "_suspended", "_unknown", "_cancel_by", "_unbegun", "_present", "_wake", "_quick", "_listening", "taken", "_asked",
    "_held_since", "_laid_by", "_kept",
)  # fmt: skip
COPIES = ("_timers", "_frozen", "_running", "_pending", "_rounds", "_settling", "_calls")
SEEN = ("at", "board", "entered", "held", "event", "answer")
"""What guards see."""


class Saving(Instants):
    """A chart that can be put down and taken up."""

    def snapshot(self) -> Snapshot:
        """All that the run remembers, as values that later steps do not change."""
        memory = {self._graph.order[at].name: tuple(each.name for each in nodes) for at, nodes in self._memory.items()}
        return {
            **{name: getattr(self, name) for name in VALUES},
            **{name: dict(getattr(self, name)) for name in COPIES},
            "atomic": tuple(node.name for node in self._config.atomic),
            "memory": memory,
            "goals": self._ledger.saved(),
            "final": self._final.name if self._final else None,
            "at": self.view.at, "board": dict(self.view.board), "entered": dict(self.view.entered),
            "held": dict(self.view.held), "event": self.view.event, "answer": self.view.answer,
        }  # fmt: skip

    def _stand(self, saved: Snapshot) -> None:
        """Stand where a snapshot was taken; what it does not hold stays as it is."""
        nodes, view = self._graph.nodes, self.view
        for name in (*VALUES, *COPIES, *SEEN):
            if name in saved:
                value = saved[name]
                setattr(view if name in SEEN else self, name, dict(value) if isinstance(value, dict) else value)
        self._config = self._graph.configuration(nodes[name] for name in saved["atomic"])
        if not saved["atomic"]:
            self._config = self._graph.empty
        view.active = self._config.active
        self._memory = {
            nodes[name].index: tuple(nodes[each] for each in held) for name, held in saved["memory"].items()
        }
        self._ledger.restore(saved["goals"])
        for name in self._running:
            self._machine(nodes[name])
        self._final = nodes[saved["final"]] if saved["final"] else None

    def _control_of(self, key: TimerKey, timer: Timer) -> str:
        """Whose control the state of a timer needs in this mission."""
        kind, which = key
        if kind == "raise":
            return timer.control if timer.control in self._graph.controls else ""
        node = self._graph.nodes[which] if kind == "timeout" else self._graph.rows[which].source
        return node.control or ""

    def standing(self, targets: Iterable[str]) -> tuple[Configuration, list[str]]:
        """The configuration in which these states are active, and the pairs of states in it that exclude each other.

        Args:
            targets: Their names; what is inside them is entered by default.
        """
        entered = self._graph.around(self._graph.nodes[name] for name in targets)
        rivals = [
            f"'{inside[0].name}' and '{inside[1].name}'"
            for node in (self._graph.root, *entered) if node.is_compound and not node.is_parallel
            and len(inside := [each for each in node.children if each in entered]) > 1
        ]  # fmt: skip
        parents = {node.parent for node in entered}
        return self._graph.configuration(node for node in entered if node not in parents), rivals

    def broken(self) -> Iterator[tuple[str, str]]:
        """The invariants that are false now: name, and what each says."""
        return ((name, each.guard.words()) for name, each in self._invariants if each.test(self.view) is False)

    def _migrate(self, data: Mapping[str, Any]) -> None:
        """Stand where a run of another mission stood; what is new begins when the run is taken up."""
        self._stand(unpacked(data["stands"]))
        self._frozen = dict.fromkeys(self._held_controls(), self._run_at)
        self._timers = {
            key: timer._replace(control=self._control_of(key, timer)) for key, timer in self._timers.items()
        }
        clocked = {name for name, node in (*self._graph.nodes.items(), ("", self._graph.root)) if node.clocked}
        self.view.entered = {name: at for name, at in self.view.entered.items() if name in clocked}
        self._unbegun = tuple(data["begins"])
        self.effects += unpacked(data["under_way"])
        self.notes += data["notes"]
        nodes = sorted(self._config.nodes, key=lambda node: node.index)
        self.moves.append(Move((), (), tuple(node.name for node in nodes if node.state is not None), "migrate"))
