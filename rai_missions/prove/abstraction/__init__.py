# SPDX-License-Identifier: Apache-2.0
"""A state of a proof: the state of a run, with what no rule can distinguish forgotten or left open.

Imports `engine`, `guards`, `mission`, `planning`, `prove.analysis` and `states`, and the modules of the root.
"""

__all__ = ()
