# SPDX-License-Identifier: Apache-2.0
"""What connects a dialogue to a run and to people: the run's status, its orders, a model, the doors, the journal.

Imports `answerers`, `connectors`, `conversation`, `embodiment`, `engine`, `guards`, `journal`, `mission`, `planning`,
`profile`, `runtime`, `states`, `tools` and `voice`, and the modules of the root.
"""

__all__ = ()
