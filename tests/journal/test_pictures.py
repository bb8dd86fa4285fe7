# SPDX-License-Identifier: Apache-2.0
"""A picture that a question has shown is evidence: whatever is done to its bytes afterwards is found."""

from __future__ import annotations

import sqlite3
from contextlib import closing
from pathlib import Path

from hypothesis import given, settings
from hypothesis import strategies as st

from rai_missions.image import Image
from rai_missions.journal import Header, Journal, verify
from tests.rigs.journals import shown

ENCODINGS = st.sampled_from(["rgb8", "png", "jpeg", "mono8"])
CHANGES = {
    "UPDATE blobs SET media_type = 'image/gif' WHERE rowid = ?": "is kept as 'image/gif'",
    "DELETE FROM blobs WHERE rowid = ?": "its bytes are missing",
    "UPDATE blobs SET bytes = x'00' WHERE rowid = ?": "do not have the hash",
}


@settings(deadline=None, max_examples=30)
@given(st.lists(st.tuples(ENCODINGS, st.binary(max_size=8)), min_size=1, max_size=5), st.data())
def test_verify_finds_each_picture_that_was_changed_or_taken_out(
    tmp_path_factory: object, pictures: list[tuple[str, bytes]], data: st.DataObject
) -> None:
    path = Path(tmp_path_factory.mktemp("pictures")) / "run.journal"  # type: ignore[attr-defined]
    with Journal.create(path, Header('{"format": 1, "name": "shown"}')) as journal:
        for number, (encoding, held) in enumerate(pictures, 1):
            journal.write(shown(number, Image(f"c@{number}", 2, 2, encoding, lambda held=held: held)), since=0.0)  # type: ignore[misc]
    assert verify(path) == ()
    change = data.draw(st.sampled_from(sorted(CHANGES)))
    with closing(sqlite3.connect(path)) as database, database:
        numbers = [number for (number,) in database.execute("SELECT rowid FROM blobs")]
        database.execute(change, (data.draw(st.sampled_from(numbers)),))
    (fault,) = verify(path)
    assert fault.place.startswith("picture ") and CHANGES[change] in fault.sentence


def test_a_picture_in_another_shape_is_of_another_type(tmp_path: Path) -> None:
    path = tmp_path / "run.journal"
    with Journal.create(path, Header('{"format": 1, "name": "shown"}')) as journal:
        journal.write(shown(1, Image("c@1", 2, 3, "rgb8", lambda: b"18 bytes of a row")), since=0.0)
    with closing(sqlite3.connect(path)) as database, database:
        database.execute("UPDATE blobs SET media_type = replace(media_type, 'width=2', 'width=3')")
    (fault,) = verify(path)
    assert "width=3; height=3" in fault.sentence and "row 1 has it as" in fault.sentence
