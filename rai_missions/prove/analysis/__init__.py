# SPDX-License-Identifier: Apache-2.0
"""What can be read of a mission before it runs: what it compares, what it looks at again, where it goes round.

Imports `engine`, `guards`, `mission`, `model`, `planning`, `prove.state_graph` and `states`, and the modules
of the root.
"""

__all__ = ()
