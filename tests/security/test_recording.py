# SPDX-License-Identifier: Apache-2.0
"""A recording is packed, and a little of it may unpack to very much: that is refused before it fills a disk."""

from __future__ import annotations

import json
import tempfile
from pathlib import Path

import pytest
from mcap.writer import CompressionType, Writer

from rai_missions.cli.main import main
from rai_missions.errors import DefinitionError
from rai_missions.journal import verify
from rai_missions.journal.rows import GENESIS, chained
from rai_missions.recording import journal_of
from rai_missions.recording import mcap_reader as reading
from rai_missions.recording.encoder import JOURNAL_TOPIC
from rai_missions.recording.recording import FORMAT


def packed(path: Path, rows: int, length: int, topic: str = JOURNAL_TOPIC) -> Path:
    """A recording of rows under good hashes, each with so many equal letters."""
    with path.open("wb") as stream:
        writer = Writer(stream, compression=CompressionType.ZSTD)
        writer.start(profile="", library="rai_missions")
        writer.add_metadata("rai_missions", {"format": FORMAT})
        channel = writer.register_channel(topic, "json", writer.register_schema("row", "jsonschema", b"{}"))
        before = GENESIS
        for number in range(rows):
            content = json.dumps({"text": "x" * length, "data": None})
            before = chained(before, number, "note", content)
            row = {"row": number, "kind": "note", "content": content, "hash": before}
            writer.add_message(channel, number, json.dumps(row).encode(), number, number)
        writer.finish()
    return path


@pytest.mark.parametrize("topic", [JOURNAL_TOPIC, "/elsewhere"])
def test_a_recording_that_unpacks_to_very_much_is_refused_before_it_is_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, topic: str
) -> None:
    file = packed(tmp_path / "bomb.mcap", 20, 1_000_000, topic)
    assert file.stat().st_size < 20_000
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    for name in ("MOST_ROWS_BYTES", "MOST_UNPACKED"):
        monkeypatch.setattr(reading, name, 3_000_000)
    monkeypatch.setattr(reading, "UNPACKED_RATIO", 100)
    with pytest.raises(DefinitionError, match="unpacks to"), journal_of(file):
        pass
    assert main(["replay", str(file)]) == 2
    assert list(tmp_path.iterdir()) == [file]


def test_a_recording_of_a_common_size_is_unpacked_whatever_its_ratio(tmp_path: Path) -> None:
    with journal_of(packed(tmp_path / "plain.mcap", 5, 1_000_000)) as found:
        assert [fault.place for fault in verify(found.path)] == ["row 0"], "it has no header, and is whole but for that"
