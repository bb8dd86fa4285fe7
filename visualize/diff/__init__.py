# SPDX-License-Identifier: Apache-2.0
"""What changed between two missions, by meaning: found, weighed, and shown as text, JSON, a picture or a page.

Rule: every difference of meaning gives a sentence; what may loosen a protection comes first, and where that is unclear
it counts as such.

Imports `guards`, `mission`, `model` and `states`, and the modules of the root.
"""

from visualize.diff.difference import Difference, difference

__all__ = ("Difference", "difference")
