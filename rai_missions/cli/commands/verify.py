# SPDX-License-Identifier: Apache-2.0
"""`rai-missions verify`."""

from __future__ import annotations

from rai_missions.cli.command import JournalFile, command

__all__ = ("verify",)


@command(only_reads=True)
def verify(journal: JournalFile) -> int:
    """Check that a journal is as it was written, and that it is of a run.

    Args:
        journal: A journal or a recording (.mcap).

    Exit status:
        0 it is intact, 1 it was altered, or a person played it (try), 2 the input is at fault

    Example:
        rai-missions verify run.journal
    """
    from rai_missions.cli.inputs import warn
    from rai_missions.journal import Record
    from rai_missions.journal import verify as faults_in
    from rai_missions.recording import journal_of

    with journal_of(journal) as found:
        warn(found.warning)
        faults = faults_in(found.path)
        for fault in faults:
            print(fault if fault.place else f"{journal}: {fault.sentence}")
        if faults:
            return 1
        with Record(found.path) as record:
            if record.header.played:
                print("intact, played: no evidence")
                return 1
            print(f"intact; its last row has the hash {record.seal}")
    return 0
