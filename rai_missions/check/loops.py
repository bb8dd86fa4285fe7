# SPDX-License-Identifier: Apache-2.0
"""Loops of trees: what one waits for, how often it goes round, and a selector that goes round by itself."""

from __future__ import annotations

from collections.abc import Mapping

from rai_missions.check.finding import Found
from rai_missions.check.index import MissionIndex
from rai_missions.guards.guard import Guard
from rai_missions.guards.view import Site
from rai_missions.states.tree import (
    Action,
    Call,
    Check,
    Condition,
    Decision,
    Decorator,
    EternalGuard,
    FailureIsRunning,
    FailureIsSuccess,
    Inverter,
    OneShot,
    Parallel,
    Publish,
    Repeat,
    Retry,
    RunningIsFailure,
    RunningIsSuccess,
    Selector,
    Sequence,
    Set,
    SuccessIsFailure,
    SuccessIsRunning,
    TreeNode,
    Wait,
)

__all__ = ("long_loops", "lost_fallbacks", "waitless_loops")

Ends = frozenset[str]
"""How a node may be after the tick that begins it: `success`, `failure`, `running` where it takes time; with `waits`
where that depends on what may change: a key, the time, a state."""
MOST_TIMES = 10_000
ENDED = frozenset({"success", "failure"})
WAITS = frozenset({"waits"})
STATUSES: Mapping[type[TreeNode], Mapping[str, str]] = {
    Inverter: {"success": "failure", "failure": "success"},
    FailureIsSuccess: {"failure": "success"},
    SuccessIsFailure: {"success": "failure"},
    RunningIsFailure: {"running": "failure"},
    RunningIsSuccess: {"running": "success"},
}
"""What a decorator makes of the status of its child."""


def long_loops(index: MissionIndex) -> Found:
    """A loop with a number goes round 10000 times at most."""
    for node, place in index.nodes:
        times = node.num_success if isinstance(node, Repeat) else node.num_failures if isinstance(node, Retry) else 0
        if times > MOST_TIMES:
            instead = '"repeat": -1' if isinstance(node, Repeat) else "'failure_is_running'"
            yield (
                f"{place}/{node.word}",
                f"{times} rounds are more than {MOST_TIMES}; give a smaller number, or {instead} for any number",
            )


def waitless_loops(index: MissionIndex) -> Found:
    """A loop without a number has something to wait for between its rounds: a leaf that takes time, or a key."""
    for node, place in index.nodes:
        continues = _continues(node)
        if continues and isinstance(node, Decorator):
            ends = _ends(node.child, index)
            if ends <= ENDED and ends & continues:
                yield (
                    place,
                    f"'{node.word}' has nothing to wait for: each round would end at once, so no second one begins; "
                    'add {"wait_s": 1} to its child, or a check of what it waits for',
                )


def lost_fallbacks(index: MissionIndex) -> Found:
    """A selector without memory has no branch of actions behind one that takes time and begins without a check."""
    for node, place in index.nodes:
        if not isinstance(node, Selector) or node.memory:
            continue
        ends = [_ends(child, index) for child in node.selector]
        ahead = (at for at, each in enumerate(node.selector) if ends[at] == {"running"} and not _holds(each, OneShot))
        first = next(ahead, len(ends))
        for at in range(first + 1, len(ends)):
            if "success" not in ends[at] and _holds(node.selector[at], Action, Call, Decision):
                yield (
                    f"{place}/selector/{at}",
                    f"this branch never comes to its end: branch {first}, which takes time, begins again in its place "
                    'as soon as a step of it has ended; add "memory": true to the selector, or begin the other with a '
                    "check",
                )


def _holds(node: TreeNode, *kinds: type[TreeNode]) -> bool:
    """Whether it is one of these, or has one in it."""
    return any(isinstance(each, kinds) for _, each in node.paths())


def _continues(node: TreeNode) -> Ends:
    """The ends of its child after which a loop without a number begins it again; none for any other node."""
    if isinstance(node, FailureIsRunning):
        return frozenset({"failure"})
    if isinstance(node, SuccessIsRunning) or (isinstance(node, Repeat) and node.num_success < 0):
        return frozenset({"success"})
    return ENDED - {node.status} if isinstance(node, Condition) else frozenset()


def _ends(node: TreeNode, index: MissionIndex) -> Ends:
    if isinstance(node, Sequence):
        return _in_turn(node.sequence, "success", index)
    if isinstance(node, Selector):
        return _in_turn(node.selector, "failure", index)
    if isinstance(node, Parallel):
        return _together(node, index)
    if isinstance(node, EternalGuard):
        waits = frozenset() if _is_settled(node.guard, index) else WAITS
        return _ends(node.child, index) | {"failure"} | waits
    if isinstance(node, Decorator):
        return _decorated(node, _ends(node.child, index))
    return _of_leaf(node, index)


def _of_leaf(node: TreeNode, index: MissionIndex) -> Ends:
    if isinstance(node, Check):
        return ENDED if _is_settled(node.check, index) else ENDED | WAITS
    if isinstance(node, Set) and (source := node.effect().source) is not None:
        return ENDED if _lasts(source, index) else ENDED | WAITS
    at_once = isinstance(node, Publish | Set) or (isinstance(node, Wait) and node.wait_s == 0)
    return frozenset({"success" if at_once else "running"})


def _in_turn(children: tuple[TreeNode, ...], onward: str, index: MissionIndex) -> Ends:
    """One after the other, while each reports what leads on."""
    found = Ends()
    for child in children:
        ends = _ends(child, index)
        found |= ends - {onward}
        if onward not in ends:
            return found
    return found | {onward}


def _together(node: Parallel, index: MissionIndex) -> Ends:
    each = [_ends(child, index) for child in node.parallel]
    if frozenset({"failure"}) in each:
        return frozenset({"failure"})
    if any("waits" in ends for ends in each):
        return ENDED | {"running"} | WAITS
    found = frozenset({"failure"} if any("failure" in ends for ends in each) else ())
    if node.policy == "success_on_one":
        may, must = any("success" in ends for ends in each), frozenset({"success"}) in each
    else:
        wanted = each if node.policy == "success_on_all" else [each[int(number)] for number in node.policy]
        may, must = all("success" in ends for ends in wanted), all(ends == {"success"} for ends in wanted)
    return found | ({"success"} if may else set()) | (set() if must else {"running"})


def _decorated(node: Decorator, ends: Ends) -> Ends:
    """What a decorator reports; a loop that begins its child again runs."""
    if type(node) in STATUSES:
        return frozenset(STATUSES[type(node)].get(end, end) for end in ends)
    if isinstance(node, OneShot) and node.policy == "on_completion" and "running" not in ends:
        return ends - WAITS  # its first end is for good
    if isinstance(node, Condition):
        ended = {"success"} if node.status in ends else set()
        return frozenset(ended | (ends & WAITS) | ({"running"} if ends - WAITS - {node.status} else set()))
    continues = _continues(node)
    return (ends - continues) | {"running"} if ends & continues else ends


def _is_settled(guard: Guard, index: MissionIndex) -> bool:
    """Whether the value of a guard stays the same for the whole of a run."""
    site = Site("", index.mission.blackboard)
    guard.compiled(site)
    if site.clocked or site.held_guards or site.states or site.named:
        return False
    return all(_lasts(path, index) for path in site.reads)


def _lasts(path: str, index: MissionIndex) -> bool:
    name = path.partition(".")[0]
    return name not in index.mission.blackboard or name in index.lasting_keys
