# SPDX-License-Identifier: Apache-2.0
"""Which worker runs which tests, also after one of them has died.

Rule: what a dead worker has ended is not given out again. xdist's own scheduler gives out all that it had; a unit in
which nothing is left to run never ends, and a worker that waits for its end waits for ever
(https://github.com/pytest-dev/pytest-xdist/issues/1378).
"""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
from xdist.scheduler import LoadScopeScheduling  # type: ignore[import-untyped, unused-ignore]

__all__ = ("ByFile", "shared")

AHEAD = 4
"""Tests that a worker has: one that runs, the next, without which it begins none, and two so that it waits for none."""
FEW = 100
"""Units left with which no worker gets more than it needs, so that none of them has two slow ones at the end."""


def shared(path: Path) -> Path | None:
    """The file or the folder whose tests share something that is made once, such as a browser; None where none is."""
    rig = path.with_name("conftest.py")
    texts = {each: each.read_text(encoding="utf-8") for each in (path, rig) if each.exists()}
    if "from tests.rigs.sources import" in texts[path]:
        return path.with_name("rigs") / "sources.py"
    if 'scope="package"' in texts.get(rig, ""):
        return path.parent
    return (
        path if any(f'scope="{scope}"' in text for text in texts.values() for scope in ("module", "session")) else None
    )


class ByFile(LoadScopeScheduling):  # type: ignore[misc, unused-ignore]
    """One worker runs all tests of a file or folder that share something; the others go to anyone who is free.

    Marks of xdist's own do not do it: it hides the group in a test's name, where newer versions of pytest do not look.
    """

    def __init__(self, config: pytest.Config, log: Any) -> None:
        super().__init__(config, log)
        self.root = config.rootpath
        self.together: dict[str, str] = {}

    def _split_scope(self, nodeid: str) -> str:
        file = nodeid.partition("::")[0]
        if file not in self.together:
            self.together[file] = str(shared(self.root / file) or "")
        return self.together[file] or nodeid

    def remove_node(self, node: Any) -> str | None:
        """Give out again what a worker that died had left, but for the test in which it died: that one has failed."""
        units = self.assigned_work[node].items()
        left = {name: {test: False for test, ended in unit.items() if not ended} for name, unit in units}
        died_in = next((test for unit in left.values() for test in unit), None)
        self.assigned_work[node] = {}
        super().remove_node(node)
        for unit in left.values():
            unit.pop(died_in, None)
        self.workqueue.update({name: unit for name, unit in left.items() if unit})
        for other in self.assigned_work:
            if other in self.registered_collections:
                self._reschedule(other)
        return died_in

    def mark_test_complete(self, node: Any, item_index: int, duration: float = 0.0) -> None:
        """Forget a unit that is over: what a worker has left is counted at the end of each test, over all its units."""
        super().mark_test_complete(node, item_index, duration)
        name = self._split_scope(self.registered_collections[node][item_index])
        if all(self.assigned_work[node][name].values()):
            del self.assigned_work[node][name]

    def _assign_work_unit(self, node: Any) -> None:
        """Give a worker a unit; one that is dead, whose end is received next, leaves it with all that it had."""
        with suppress(OSError):
            super()._assign_work_unit(node)

    def _reschedule(self, node: Any) -> None:
        """Two tests at least, where there are: a worker begins one only once it knows the next."""
        ahead = AHEAD if len(self.workqueue) > FEW else 2
        while self.workqueue and not node.shutting_down and self._pending_of(self.assigned_work[node]) < ahead:
            self._assign_work_unit(node)
        super()._reschedule(node)
