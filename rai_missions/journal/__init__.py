# SPDX-License-Identifier: Apache-2.0
"""The journal: what a run did, row by row, written ahead of its effects and read back as the same values."""

from rai_missions.journal.aside import free_name, make_way, set_aside
from rai_missions.journal.chain import checked, opened, read, verify
from rai_missions.journal.codec import decode, encode
from rai_missions.journal.compare import difference
from rai_missions.journal.copied import copied
from rai_missions.journal.record import Record
from rai_missions.journal.rows import MIGRATED, Blob, Confirmation, Header, Note, Raw, Row, StepRow
from rai_missions.journal.writer import Journal, versions

__all__ = (
    "MIGRATED", "Blob", "Confirmation", "Header", "Journal", "Note", "Raw", "Record", "Row", "StepRow", "checked",
    "copied", "decode", "difference", "encode", "free_name", "make_way", "opened", "read", "set_aside", "verify",
    "versions",
)  # fmt: skip
