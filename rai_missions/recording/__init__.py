# SPDX-License-Identifier: Apache-2.0
"""A run as an MCAP file: the robot's messages, the mission's steps, and its journal; for other tools and for replay.

Rule: an observer cannot harm the run. A recording never makes it wait and never ends it; what it could not keep
it counts and reports. The library mcap is known in this room only, and comes in when a recording is written or read.

Imports `connectors`, `engine`, `journal`, `mission` and `runtime`, and the modules of the root.
"""

from __future__ import annotations

from rai_missions.recording.connector import RecordedConnector, recorded
from rai_missions.recording.file import check_name, is_mcap
from rai_missions.recording.journal import JournalSource, journal_of
from rai_missions.recording.recording import Recording, Summary

__all__ = (
    "JournalSource",
    "RecordedConnector",
    "Recording",
    "Summary",
    "check_name",
    "is_mcap",
    "journal_of",
    "recorded",
)
