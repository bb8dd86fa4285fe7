# SPDX-License-Identifier: Apache-2.0
"""All states that a mission can come into, and the steps between them, none made twice.

Imports `engine`, `guards`, `mission`, `prove.abstraction`, `prove.analysis`, `prove.environment`, `prove.limits`,
`prove.state_graph`, `prove.stimulus` and `states`.
"""

__all__ = ()
