# SPDX-License-Identifier: Apache-2.0
"""True for true and for unknown: `{"possible": guard}`, for transitions that protect."""

from __future__ import annotations

from collections.abc import Callable

from rai_missions.guards.analysis import Sources
from rai_missions.guards.guard import Guard, GuardOrKey
from rai_missions.guards.view import Site, Test, Truth
from rai_missions.model import AnyOf

__all__ = ("Possible",)


class Possible(Guard, word="possible"):
    """True where the guard is true or unknown; never unknown itself."""

    possible: AnyOf[Guard]
    """The guard that must not be false."""

    def __init__(self, possible: GuardOrKey) -> None: ...

    def compile(self, site: Site) -> Test:
        inner = self.possible.compiled(site)
        return lambda view: inner(view) is not False

    def rests(self, sources: Sources, *, wanted: bool = True) -> bool:
        return not wanted and self.possible.rests(sources, wanted=False)

    def noticed(self, *, wanted: bool = True) -> frozenset[str]:
        return frozenset(self.possible.fading()) if wanted else frozenset()

    def after_jump(self, active: Callable[[str], Truth], *, restarted: bool) -> Truth:
        return self.possible.after_jump(active, restarted=restarted)

    def words(self) -> str:
        return f"possibly {self.possible.words()}"
