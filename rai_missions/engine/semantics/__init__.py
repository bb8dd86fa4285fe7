# SPDX-License-Identifier: Apache-2.0
"""The semantics: functions over a `Program` and a `RunState`, which do what an event does.

A step begins and ends in `stepping`. `events` finds who receives an event; `macrostep` takes transitions until none is
enabled; `completion` is what finals, lists and invariants do; `running` starts, informs and ends activities; `timing`
is what time does. `commands` are pause, stop, resume and cancel, `handover` and `hold` who has control, and what waits
for it. `short_way` makes the same steps where little happens.

Imports `engine.activities`, `engine.compiled`, `guards`, `mission` and `states`, and the modules of the root.
"""

__all__ = ()
