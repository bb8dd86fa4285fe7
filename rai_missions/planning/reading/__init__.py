# SPDX-License-Identifier: Apache-2.0
"""Requests in free words, read into goals by rules; what is not sure is asked back, what is forbidden is refused.

Imports `model` and the modules of the root.
"""

from rai_missions.planning.reading.answer import chosen, read_answer
from rai_missions.planning.reading.grounding import is_said, unsaid
from rai_missions.planning.reading.model_schema import goal_parameters
from rai_missions.planning.reading.read import language_of, read_request, reading_data, reading_of
from rai_missions.planning.reading.reading import RequestReading

__all__ = (
    "RequestReading",
    "chosen",
    "goal_parameters",
    "is_said",
    "language_of",
    "read_answer",
    "read_request",
    "reading_data",
    "reading_of",
    "unsaid",
)
