# SPDX-License-Identifier: Apache-2.0
"""A mission compiled: its states, moves and guards as a `Program`, which no run of it changes.

`mission` has the states in document order, `graph` which transitions can be taken together and the moves that they
make, `configuration` a set of active states with what can happen in it, and `program` all of it with the machines of
activities. `surroundings` are the hooks by which a proof watches a run.

Imports `engine.activities`, `engine.trees`, `guards`, `mission` and `states`, and the modules of the root.
"""

__all__ = ()
