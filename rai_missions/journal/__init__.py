# SPDX-License-Identifier: Apache-2.0
"""The journal: what a run did, row by row, written ahead of its effects and read back as the same values.

Imports `connectors`, `engine`, `model` and `states`, and the modules of the root.
"""

from rai_missions.journal.codec import decode, encode
from rai_missions.journal.diff import difference
from rai_missions.journal.files import copied, free_name, make_way, set_aside
from rai_missions.journal.lock import writing_at
from rai_missions.journal.reader import Record
from rai_missions.journal.rows import MIGRATED, Blob, Confirmation, Header, JournalRow, Note, Raw, StepRow
from rai_missions.journal.verify import checked, opened, read, verify
from rai_missions.journal.writer import Journal, versions

__all__ = (
    "MIGRATED",
    "Blob",
    "Confirmation",
    "Header",
    "Journal",
    "JournalRow",
    "Note",
    "Raw",
    "Record",
    "StepRow",
    "checked",
    "copied",
    "decode",
    "difference",
    "encode",
    "free_name",
    "make_way",
    "opened",
    "read",
    "set_aside",
    "verify",
    "versions",
    "writing_at",
)  # fmt: skip
