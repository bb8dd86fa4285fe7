# SPDX-License-Identifier: Apache-2.0
"""What a run knows in the other mission: each key's value, with its stamp.

Rule: what the robot reports is never made up, and what the run has remembered is dropped only by name.
"""

from __future__ import annotations

from collections.abc import Mapping

from rai_missions.errors import Fault
from rai_missions.keys import Key, Stamped, type_error
from rai_missions.replay.migrate.names import Naming

__all__ = ("board",)


def board(naming: Naming, known: Mapping[str, Stamped], at: float) -> tuple[dict[str, Stamped], list[Fault]]:
    """The blackboard with which the run continues.

    Args:
        naming: What everything is called.
        known: The blackboard of the run.
        at: Now, on the run's clock.
    """
    faults: list[Fault] = []
    keys = naming.now.blackboard
    carried: dict[str, Stamped] = {}
    origins: dict[str, str] = {}
    for old, entry in known.items():
        new = naming.key(old)
        if new is None:
            faults += _dropped(naming, old)
        elif new in carried:
            faults.append(
                Fault("/keys", f"'{origins[new]}' and '{old}' would both be '{new}'; drop one: \"{old}\": null")
            )
        elif new not in naming.map.values:
            carried[new], origins[new] = entry, old
            faults += _refused(naming, old, new, entry)
    found = {name: Stamped(key.initial, at) for name, key in keys.items() if key.initial is not None} | carried
    for name, value in naming.map.values.items():
        if name in keys:
            faults += _not_to_be(name, keys[name], value)
            found[name] = Stamped(value, at)
    for name, key in keys.items():
        if key.source == "argument" and name not in found:
            faults.append(Fault("/values", f"the mission now takes an argument '{name}'; give its value here"))
    return found, faults


def _dropped(naming: Naming, old: str) -> list[Fault]:
    """What the robot reports may be left out; what the run has remembered must be named."""
    if old in naming.map.keys or naming.was.blackboard[old].source == "robot":
        return []
    sentence = f"the run has a value for '{old}', and the mission now has no such key"
    return [Fault("/keys", f'{sentence}; name it, or drop it: "{old}": null')]


def _refused(naming: Naming, old: str, new: str, entry: Stamped) -> list[Fault]:
    was, now = naming.was.blackboard[old], naming.now.blackboard[new]
    if now.source == "robot" and was.source != "robot":
        sentence = f"'{new}' is what the robot reports, and '{old}' was not"
        return [Fault("/keys", f'{sentence}; drop its value: "{old}": null')]
    if why := type_error(now, entry.value):
        remedy = "drop it" if now.source == "robot" else "give another in 'values'"
        return [Fault("/keys", f"the value of '{old}' does not fit '{new}': {why}; {remedy}")]
    return []


def _not_to_be(name: str, key: Key, value: object) -> list[Fault]:
    if key.source == "robot":
        return [Fault(f"/values/{name}", f"'{name}' is what the robot reports; leave it out, it is received again")]
    if why := type_error(key, value, written=True):
        return [Fault(f"/values/{name}", why)]
    return []
