# SPDX-License-Identifier: Apache-2.0
"""The dialogue: one part of it for each of sentences, orders, offers, documents, a model and speech.

Imports the other parts of `conversation`, `engine`, `mission`, `planning`, `profile` and `voice`, and the modules
of the root.
"""

__all__ = ()
