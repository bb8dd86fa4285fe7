# SPDX-License-Identifier: Apache-2.0
"""What the fuzzing begins with: the shipped missions and profiles, and a run of one as journal, rows and recording."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Iterator
from pathlib import Path

from rai_missions.engine import Chart
from rai_missions.event import Event
from rai_missions.journal import Header, Journal, Raw, Record
from rai_missions.mission.files import dump
from rai_missions.mission.mission import Mission
from rai_missions.recording import Recording
from rai_missions.replay.migrate import Map, migrate

__all__ = ("LAMP", "seeds", "written_run")

ROOT = Path(__file__).parents[2]
LAMP = Mission.model_validate(
    {
        "name": "lamp",
        "blackboard": {
            "battery": {"type": "number", "source": "robot", "optional": True},
            "count": {"type": "integer", "source": "mission", "initial": 0},
        },
        "events": {"tap": {}},
        "initial": "on",
        "states": {
            "on": {
                "transitions": [
                    {"on": "tap", "do": [{"set": "count", "add": 1}, {"log": "tapped"}]},
                    {"when": {"key": "battery", "<": 0.5}, "to": "asking"},
                ]
            },
            "asking": {
                "decision": {
                    "question": "On or off?",
                    "evidence": ["battery"],
                    "options": {"stay": {}, "leave": {}},
                    "ask": ["agent"],
                    "deadline_s": 5,
                    "fallback": "leave",
                },
                "transitions": [{"on": "stay", "to": "on"}, {"on": "leave", "to": "off"}],
            },
            "off": {"final": "aborted"},
        },
    }
)
"""A small mission with a question, so that its journal is small and has one."""


def written_run(folder: Path, *, record: bool = False) -> Path:
    """The journal of a run of the lamp, and its recording next to it where one is wanted."""
    file = folder / "run.journal"
    header = Header(dump(LAMP), run="run", started="2026-01-01T00:00:00.000+00:00", versions={"format": "1"})
    recording = Recording.create(folder / "run.mcap", mission=LAMP, about={}, now=lambda: 0.0) if record else None
    journal = Journal.create(file, header, witness=recording.rows if recording is not None else None)
    chart = Chart(LAMP)
    for step in (
        chart.start(at=0.0),
        chart.send(Event("tap", at=1.0)),
        chart.write("battery", 0.4, at=2.0),
        chart.send(Event("tick", at=8.0, kind="tick")),
    ):
        journal.write(step, since=step.at)
    if recording is not None:
        recording.close(journal.path)
    journal.close()
    return file


def seeds(target: str) -> Iterator[bytes]:
    """Good input of a target."""
    if target == "mission":
        yield from (path.read_bytes() for path in sorted(ROOT.glob("missions/*/mission.json")))
        yield from (path.read_bytes() for path in sorted(ROOT.glob("tests/bad_missions/*.json")))
        yield dump(LAMP).encode()
    elif target == "profile":
        yield from (path.read_bytes() for path in sorted(ROOT.glob("missions/*/robot.*.json")))
    elif target == "identity":
        yield from (path.read_bytes() for path in sorted(ROOT.glob("missions/*/identity/*")) if _is_small(path))
        links = b"<link name='a'/><link name='b'/>"
        joint = b"<joint name='j' type='revolute'><parent link='a'/><child link='b'/></joint>"
        yield b"<robot name='r'>" + links + joint + b"</robot>"
    else:
        yield from _runs(target)


def _runs(target: str) -> Iterator[bytes]:
    with tempfile.TemporaryDirectory() as name:
        journal = written_run(Path(name), record=target == "recording")
        if target == "journal":
            yield journal.read_bytes()
        elif target == "recording":
            yield journal.with_suffix(".mcap").read_bytes()
        else:
            for each in (journal, _migrated(journal)):
                with Record(each) as record:
                    yield json.dumps([_row(raw) for raw in record.raw()]).encode()


def _migrated(journal: Path) -> Path:
    """The journal of a run that was cut short and continues in another mission: it begins with where that was."""
    cut, to = journal.with_name("cut.journal"), journal.with_name("migrated.journal")
    chart = Chart(LAMP)
    with Journal.create(cut, Header(dump(LAMP), run="run")) as written:
        for step in (chart.start(at=0.0), chart.send(Event("tap", at=1.0)), chart.write("battery", 0.4, at=2.0)):
            written.write(step, since=step.at)
    later = LAMP.written() | {"version": "2.0.0"}
    later["states"]["on"]["about"] = "It shines."
    migrate(cut, Mission.model_validate(later), Map(), to=to)
    return to


def _is_small(path: Path) -> bool:
    return path.is_file() and path.stat().st_size < 20_000


def _row(raw: Raw) -> list[object]:
    return [raw[1], json.loads(raw[2])]
