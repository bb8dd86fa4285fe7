# SPDX-License-Identifier: Apache-2.0
"""What can happen to a mission in a state: reports, answers, orders, and time.

Imports `engine`, `guards`, `mission`, `prove.abstraction`, `prove.analysis`, `prove.stimulus` and `states`, and the
modules of the root.
"""

__all__ = ()
