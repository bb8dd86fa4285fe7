# SPDX-License-Identifier: Apache-2.0
"""What others see of a run that was recorded: topics, schemas that Foxglove reads, pictures, and times."""

from __future__ import annotations

import base64
import json
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator

from rai_missions.agents.mission import RunConfig, prepare
from rai_missions.connectors.connector import Message, Reply, Report
from rai_missions.connectors.local import LocalConnector
from rai_missions.image import Image
from rai_missions.recording import RecordedConnector, Recording, journal_of
from rai_missions.recording.schemas import described
from rai_missions.replay.replay import replay
from rai_missions.runtime.clock import SimulatedClock
from tests.recording.kept import LAMP, ReadRecording, kept, robot

pytest.importorskip("mcap")

PUBLISHED = {
    "foxglove.CompressedImage": {"timestamp": "object", "frame_id": "string", "data": "base64", "format": "string"},
    "foxglove.RawImage": {
        "timestamp": "object", "frame_id": "string", "width": "integer", "height": "integer", "encoding": "string",
        "step": "integer", "data": "base64",
    },
    "foxglove.Log": {
        "timestamp": "object", "level": "oneOf", "message": "string", "name": "string", "file": "string",
        "line": "integer",
    },
}  # fmt: skip
"""The required fields of Foxglove's own schemas (foxglove-sdk, schemas/jsonschema), and what each is."""
PIXELS = bytes(range(12))
PNG = b"\x89PNG not really"
ROBOT = robot("local", services={"horn": {"service": "/horn", "type": "std_srvs/srv/Trigger"}})


class Stage:
    """A world that plays a script: at each instant, what is published."""

    period_s = 0.5

    def __init__(self, connector: LocalConnector, script: dict[float, tuple[str, Any]]) -> None:
        self.at, self._connector, self._script = 0.0, connector, script

    def step(self) -> None:
        self.at += self.period_s
        if self.at in self._script:
            topic, data = self._script[self.at]
            self._connector.publish(topic, "", data)


SCRIPT: dict[float, tuple[str, Any]] = {
    0.5: ("/battery", {"percentage": 0.9, "cell_voltage": [], "header": {"frame_id": "base"}}),
    1.0: ("/camera", {"header": {"frame_id": "eye"}, "data": Image("camera@1", 2, 2, "rgb8", PIXELS)}),
    1.5: ("/camera", {"header": {"frame_id": "eye"}, "data": Image("camera@2", 2, 2, "png", lambda: PNG)}),
    2.0: ("/speech", {"data": '{"kind": "log"}'}),
    2.5: ("/battery", {"percentage": 0.4}),
    3.0: ("/battery", {"percentage": 0.1}),
}


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> ReadRecording:
    path = tmp_path_factory.mktemp("run") / "run.mcap"
    stages: list[Stage] = []
    connector = LocalConnector(now=lambda: stages[0].at)
    connector.start()
    stages.append(Stage(connector, SCRIPT))
    words: dict[str, Any] = {"connector": connector, "clock": SimulatedClock(stages[0]), "record": path}
    with prepare(RunConfig(LAMP, ROBOT, **words)) as prepared:
        assert prepared.runner.run().outcome == "aborted"
        assert prepared.recording is not None
    assert prepared.recording.summary is not None and prepared.recording.summary.dropped == {}
    with journal_of(path) as replayed:
        assert replay(replayed.path).holds
    return kept(path)


def test_every_message_in_json_is_what_its_schema_reports(run: ReadRecording) -> None:
    for topic, schemas in run.schemas.items():
        for (name, encoding, text), message in zip(schemas, run.messages[topic], strict=True):
            assert encoding == "jsonschema" and json.loads(text)["title"] == name
            Draft202012Validator(json.loads(text)).validate(message)


def foxglove_reads(schema: dict[str, Any], place: str) -> None:
    """Foxglove's rules for a schema in JSON (studio, packages/mcap-support, parseJsonSchema)."""
    assert schema["type"] == "object", place
    for name, field in schema["properties"].items():
        if "oneOf" in field:
            assert all(isinstance(each["const"], int) for each in field["oneOf"])
        elif field["type"] == "object":
            foxglove_reads(field, f"{place}.{name}")
        elif field["type"] == "array":
            assert field["items"]["type"] in ("object", "string", "number", "integer", "boolean"), f"{place}.{name}"
            if field["items"]["type"] == "object":
                foxglove_reads(field["items"], f"{place}.{name}")
        else:
            assert field["type"] in ("string", "number", "integer", "boolean"), f"{place}.{name}"
            assert field.get("contentEncoding") in (None, "base64")


def test_every_schema_is_one_that_foxglove_reads(run: ReadRecording) -> None:
    for topic, schemas in run.schemas.items():
        for _, _, text in schemas:
            foxglove_reads(json.loads(text), topic)


@pytest.mark.parametrize(
    "sample",
    [{}, {"a": None}, {"a": []}, {"a": [[1]]}, {"a": [1, "b"]}, {"a": {"b": [{"c": 1}]}}, {"a": [1.0, 2]}, {"": True}],
    ids=json.dumps,
)
def test_a_schema_by_example_is_one_that_foxglove_reads_and_the_example_fits(sample: dict[str, Any]) -> None:
    schema = json.loads(described("anything", sample).text)
    foxglove_reads(schema, "anything")
    Draft202012Validator(schema).validate(sample)


def test_foxgloves_own_schemas_have_the_fields_that_it_publishes(run: ReadRecording) -> None:
    every = [each for schemas in run.schemas.values() for each in schemas]
    found = {name: json.loads(text) for name, _, text in every if name in PUBLISHED}
    assert found.keys() == PUBLISHED.keys()
    for name, fields in PUBLISHED.items():
        properties = found[name]["properties"]
        kinds = {
            word: "oneOf" if "oneOf" in each else each.get("contentEncoding", each.get("type"))
            for word, each in properties.items()
        }
        assert kinds == fields
        assert properties["timestamp"]["properties"].keys() == {"sec", "nsec"}
    assert [each["title"] for each in found["foxglove.Log"]["properties"]["level"]["oneOf"]] == [
        "UNKNOWN",
        "DEBUG",
        "INFO",
        "WARNING",
        "ERROR",
        "FATAL",
    ]


def test_a_picture_is_one_that_foxglove_shows(run: ReadRecording) -> None:
    raw, compressed = sorted(run.messages["/camera"], key=lambda each: "format" in each)
    assert base64.b64decode(raw.pop("data")) == PIXELS
    assert {**raw, "timestamp": 0} == {
        "timestamp": 0,
        "frame_id": "eye",
        "width": 2,
        "height": 2,
        "encoding": "rgb8",
        "step": 6,
    }
    assert base64.b64decode(compressed["data"]) == PNG and compressed["format"] == "png"


def test_what_the_robot_reports_is_there_as_it_was_received(run: ReadRecording) -> None:
    assert [each["percentage"] for each in run.messages["/battery"]] == [0.9, 0.4, 0.1]
    assert run.schemas["/battery"][0][0] == "sensor_msgs/msg/BatteryState"
    assert run.messages["/speech"] == [{"data": '{"kind": "log"}'}]


def test_the_steps_state_what_was_left_entered_and_why(run: ReadRecording) -> None:
    steps = [step for step in run.messages["/rai_missions/steps"] if step["entered"]]
    moves = [(step["exited"], step["entered"], step["outcome"]) for step in steps]
    assert moves == [([], ["on"], ""), (["on"], ["dim"], ""), (["dim"], ["off"], "aborted")]
    dim = steps[1]
    assert dim["event"] | {"data": 0} == {"name": "battery", "kind": "write", "at": 2.5, "number": 0, "data": 0}
    assert {"place": "/states/on/transitions/0", "value": "false"} in dim["guards"]
    assert {"place": "/states/on/transitions/1", "value": "true"} in dim["guards"]


def test_the_status_has_one_text_for_the_state(run: ReadRecording) -> None:
    assert [each["state"] for each in run.messages["/rai_missions/status"]][-3:] == ["on", "dim", "off"]
    assert run.messages["/rai_missions/status"][-1]["mode"] == "aborted"


def test_the_blackboard_has_a_number_where_it_can_be_plotted(run: ReadRecording) -> None:
    writes = run.messages["/rai_missions/blackboard"]
    assert [(each["at"], each["number"]) for each in writes if each["key"] == "battery"] == [
        (0.5, 0.9),
        (2.5, 0.4),
        (3.0, 0.1),
    ]
    assert [each["number"] for each in writes if each["key"] == "count"][-1] == 1
    assert [each["text"] for each in writes if each["key"] == "speech"] == ['{"kind": "log"}']
    assert all("number" not in each for each in writes if each["key"] in ("speech", "camera"))


def test_the_log_has_a_line_a_step_with_its_end_as_an_error(run: ReadRecording) -> None:
    lines = run.messages["/rai_missions/log"]
    assert len(lines) == len(run.messages["/rai_missions/steps"])
    assert lines[-1]["message"] == "3.00 s  battery · dim → off · aborted: 'off' was reached"
    assert (lines[-1]["level"], lines[0]["level"], lines[-1]["file"]) == (4, 2, "lamp")


def test_a_message_has_the_time_of_day_and_the_time_of_the_run(run: ReadRecording) -> None:
    began = int(run.metadata["rai_missions"]["began_ns"])
    assert [(published - began) / 1e9 for _, published in run.times["/battery"]] == [0.5, 2.5, 3.0]
    assert all(0 <= logged - began < 30e9 for logged, _ in run.times["/battery"])


def test_the_metadata_reports_which_run_it_was(run: ReadRecording) -> None:
    words = run.metadata["rai_missions"]
    assert (words["mission"], words["robot"], words["format"]) == ("lamp", "a lamp", "1")
    assert "python" in json.loads(words["versions"]) and len(words["run"]) == 12
    assert json.loads(run.metadata["rai_missions/end"]["dropped"]) == {}


def test_calls_and_goals_are_kept_with_their_ends(tmp_path: Path) -> None:
    inner = LocalConnector(now=lambda: 0.0)
    recording = Recording.create(tmp_path / "run.mcap", mission=LAMP, about={}, now=lambda: 0.0)
    connector = RecordedConnector(inner, recording)
    assert not connector.running
    connector.start()
    connector.serve("/horn", "", lambda request: {"success": True, "loud": float("nan"), "raw": b"\x01"})
    replies: list[Reply] = []
    reports: list[Report] = []
    connector.call("/horn", "", {"for_s": 1}, on_reply=replies.append)
    connector.send_goal("/go", "", {}, goal_id="g1", on_report=reports.append)
    connector.find_goal("/go", "", goal_id="g0", on_report=reports.append)
    connector.stop()
    recording.close()
    assert (replies[0].outcome, *(each.status for each in reports)) == ("succeeded", "rejected", "lost")
    calls, goals = (kept(tmp_path / "run.mcap").messages[f"/rai_missions/{name}"] for name in ("calls", "goals"))
    assert calls[0] | {"seconds": 0} == {
        "service": "/horn",
        "request": '{"for_s": 1}',
        "seconds": 0,
        "outcome": "succeeded",
        "why": "",
        "data": {"success": True, "loud": "nan", "raw": "AQ=="},
    }
    reported = [(each["action"], each["goal_id"], each["said"]) for each in goals]
    assert reported == [("/go", "g1", "rejected"), ("/go", "g0", "lost")], (
        "a run that continues asks for the goals before it"
    )


def test_a_topic_that_two_listen_to_is_kept_once(tmp_path: Path) -> None:
    inner = LocalConnector(now=lambda: 0.0)
    inner.start()
    recording = Recording.create(tmp_path / "run.mcap", mission=LAMP, about={}, now=lambda: 0.0)
    connector = RecordedConnector(inner, recording)
    received: list[Message] = []
    first = connector.subscribe("/battery", "", received.append)
    connector.subscribe("/battery", "", received.append)
    inner.publish("/battery", "", {"percentage": 0.5})
    first()
    inner.publish("/battery", "", {"percentage": 0.4})
    recording.close()
    assert len(received) == 3
    assert [each["percentage"] for each in kept(tmp_path / "run.mcap").messages["/battery"]] == [0.5, 0.4]


def test_a_time_that_is_none_does_not_harm_a_recording(tmp_path: Path) -> None:
    recording = Recording.create(tmp_path / "run.mcap", mission=LAMP, about={}, now=lambda: 0.0)
    for at in (float("nan"), float("inf"), -1e12, 1e30):
        recording.received(Message("/battery", {"at": str(at)}, at), "")
    assert recording.close().messages == 4
