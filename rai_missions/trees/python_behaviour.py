# SPDX-License-Identifier: Apache-2.0
"""A behaviour of the user's program while it lives: ticked next to the mission, by the owner of the clock.

Rule: what it reports reaches the mission as an Event of kind `behaviour`, and in no other way.
"""

from __future__ import annotations

from types import TracebackType
from typing import Any

from py_trees.behaviour import Behaviour

from rai_missions.engine.activities.ticker import Status
from rai_missions.errors import UsageError
from rai_missions.redaction import cut_repr, logger
from rai_missions.states.tree.behaviour import BehaviourLeaf, factory_name
from rai_missions.trees.nodes import INVALID, RUNNING, WORDS

__all__ = ("LiveBehaviour",)

log = logger(__name__)


class LiveBehaviour:
    """Made and set up when its leaf is started; `stop` when the leaf is ended, has ended, or the run is over.

    A tick that raises counts as a failure: the mission continues, and the log reports what it was. So does one after
    which the status is `INVALID`, which is what py_trees makes of an `update` that returns nothing.

    Args:
        leaf: Brings the factory.

    Raises:
        UsageError: The factory makes something else than a behaviour of py_trees.
    """

    def __init__(self, leaf: BehaviourLeaf) -> None:
        self.name = factory_name(leaf.factory)
        made: Any = leaf.factory()
        if not isinstance(made, Behaviour):
            raise UsageError(f"'{self.name}' made {cut_repr(made, 80)}; it must make a py_trees.behaviour.Behaviour")
        self._root = made
        self._root.setup_with_descendants()

    def __enter__(self) -> LiveBehaviour:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.stop()

    def tick(self) -> Status:
        """Tick it once: `running`, `success` or `failure`."""
        try:
            self._root.tick_once()
        except (Exception, SystemExit):  # whatever the user's program raises, the mission's rules decide what follows
            log.exception("the behaviour '%s' raised; it counts as a failure", self.name)
            return "failure"
        status: Status = WORDS[self._root.status]
        return "failure" if status == "invalid" else status

    def stop(self) -> None:
        """Interrupt it if it runs, and let it put away what its `setup` took."""
        if self._root.status is RUNNING:
            self._root.stop(INVALID)
        for node in self._root.iterate():
            node.shutdown()
