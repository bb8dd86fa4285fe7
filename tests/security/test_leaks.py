# SPDX-License-Identifier: Apache-2.0
"""Secrets of every kind, reported by everybody who can state anything, are in nothing that comes out of this program.

Rule: who knows a secret here reports it wherever words are taken: a model, its provider, servers, exceptions.
"""

from __future__ import annotations

import io
import json
import logging
import sys
import threading
import urllib.error
import urllib.request
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from langchain_core.messages import AIMessage
from pydantic import SecretStr

from rai_missions.agents.mission import RunConfig, prepare
from rai_missions.answerers.test_models import DoubleModel, call
from rai_missions.cli.main import main
from rai_missions.cli.output import redacted_output
from rai_missions.cli.progress import Lines
from rai_missions.cli.run.live_page import RunPage
from rai_missions.connectors.connector import Message, Report
from rai_missions.connectors.local import LocalConnector
from rai_missions.errors import ConnectorError
from rai_missions.mission.files import dump
from rai_missions.mission.mission import Mission
from rai_missions.node import MissionNode
from rai_missions.node.transport import Carrier
from rai_missions.profile import Robot
from rai_missions.redaction import Redaction, logger
from rai_missions.replay.replay import replay
from tests.node.scenes import Client
from tests.rigs.journals import steps_of
from tests.security.test_secrets import texts
from visualize import difference, draw, draw_difference, draw_review
from visualize.live import LivePage, PageAddress
from visualize.notebook import show

VARIABLES = {
    "STRANGERS_API_KEY": "canary-key-4b1d", "HF_TOKEN": "canary-token-77aa", "BROKER_PASSWORD": 'canary "pass" 9c',
    "HTTPS_PROXY": "http://robot:canary%2Dproxy-31ef@proxy:3128/", "THE_SECRET": "canary/secret+e0",
    "TLS_PASSPHRASE": "canary-phrase-é1",
}  # fmt: skip
OF_MODEL = {"type": "canary-by-type-73d1", "header": "canary-in-a-header-05", "shape": "sk-proj-Qk3mQ9vT7wXyB2nC5dF8hJ"}
OF_ROBOT = (
    *(value for name, value in VARIABLES.items() if name != "HTTPS_PROXY"),
    "canary-proxy-31ef",
    OF_MODEL["type"],
)
LEAK = " ".join((*OF_ROBOT, OF_MODEL["header"]))
ALL = " ".join((LEAK, OF_MODEL["shape"], VARIABLES["HTTPS_PROXY"]))
"""What a model reports: of it no one needs to know that it is a secret."""
CANARIES = ("canary", OF_MODEL["shape"])

ASKED = {"options": {"stay": {}, "leave": {}}, "ask": ["agent"], "attempts": 8, "deadline_s": 60, "fallback": "leave"}
MISSION = Mission.model_validate(
    {
        "name": "tongues", "initial": "ask", "events": ["signal"],
        "blackboard": {"text": {"type": "string", "source": "robot"}, "kept": {"type": "string", "source": "mission"}},
        "states": {
            "ask": {
                "decision": {"question": "What now?", "evidence": ["text"], **ASKED},
                "transitions": [{"on": "stay", "to": "post"}, {"on": "leave", "to": "post"}],
            },
            "post": {"call": "post", "timeout_s": 5, "transitions": [{"on": ["succeeded", "failed"], "to": "break"}]},
            "break": {"call": "break", "timeout_s": 5, "transitions": [{"on": ["succeeded", "failed"], "to": "go"}]},
            "go": {
                "action": "go", "timeout_s": 5, "entry": [{"say": "{text}"}, {"log": "{text}"}, {"publish": "news"}],
                "transitions": [{"on": ["succeeded", "failed"], "to": "over"}],
            },
            "over": {"final": "aborted"},
        },
    }
)  # fmt: skip
STRING, TRIGGER = "std_msgs/msg/String", "std_srvs/srv/Trigger"
ROBOT = Robot.model_validate(
    {
        "name": "loose",
        "connector": {"kind": "local"},
        "blackboard": {"text": {"topic": "/text", "type": STRING, "field": "data"}},
        "events": {"signal": {"topic": "/signal", "type": STRING}},
        "services": {name: {"service": f"/{name}", "type": TRIGGER} for name in ("post", "break")},
        "topics": {"say": {"topic": "/spoken", "type": STRING}, "news": {"topic": "/broken", "type": STRING}},
        "actions": {"go": {"action": "/go", "type": "nav2_msgs/action/Spin"}},
    }
)


class Loose(DoubleModel):
    """A chat model with keys of its own, whose provider reports them too."""

    key: SecretStr = SecretStr(OF_MODEL["type"])
    default_headers: Mapping[str, str] = {"Authorization": f"Bearer {OF_MODEL['header']}"}
    asked: int = 0

    def reply_to(self, messages: list[Any]) -> Any:
        self.asked += 1
        if self.asked == 1:
            raise RuntimeError(f"401, no such key: {ALL}")
        if self.asked == 2:
            return AIMessage(ALL, tool_calls=[call(OF_MODEL["shape"], "1", words=ALL, **{"canary-key-4b1d": 1})])
        if self.asked == 3:
            return json.dumps({"option": ALL, "why": ALL})
        return json.dumps({"option": "stay", "why": ALL, "reason": ALL, "parameters": {ALL: ALL}})


class Loud(LocalConnector):
    """A robot whose servers state what they should not; what is published to others is kept."""

    def __init__(self) -> None:
        super().__init__()
        self.received: list[str] = []

    def publish(self, topic: str, type_name: str, message: Mapping[str, Any]) -> None:
        if topic == "/broken":
            raise ConnectorError(f"no way to {LEAK}")
        if topic not in ("/text", "/signal"):
            self.received.append(repr((topic, message)))
        super().publish(topic, type_name, message)

    def stop(self) -> None:
        super().stop()
        raise OSError(f"still connected as {LEAK}")

    def accept(self, goal_id: str, goal: Any, report: Callable[[Report], None]) -> None:
        report(Report(goal_id, "accepted", {}))
        report(Report(goal_id, "feedback", {"words": LEAK}))
        report(Report(goal_id, "failed", {"words": [LEAK, {LEAK: LEAK}]}, LEAK))

    def cancel(self, goal_id: str) -> None:
        """It has ended."""

    def open(self) -> None:
        def broken(_: Any) -> Any:
            raise RuntimeError(f"a server that prints {LEAK}")

        self.start()
        self.serve("/post", TRIGGER, lambda _: {"success": False, "message": LEAK})
        self.serve("/break", TRIGGER, broken)
        self.offer("/go", "nav2_msgs/action/Spin", self)


@pytest.fixture
def robot(monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture) -> Iterator[Loud]:
    for name, value in VARIABLES.items():
        monkeypatch.setenv(name, value)
    caplog.set_level(logging.DEBUG)
    connector = Loud()
    connector.open()
    over = threading.Event()

    def speak() -> None:
        while not over.wait(0.05):
            connector.publish("/signal", STRING, {"data": LEAK})
            connector.publish("/text", STRING, {"data": f"here is {LEAK}"})

    speaker = threading.Thread(target=speak)
    speaker.start()
    yield connector
    over.set()
    speaker.join()


def assert_tight(left: Mapping[str, bytes | str]) -> None:
    found = {}
    for name, reported in left.items():
        data = reported.encode() if isinstance(reported, str) else reported
        found |= {
            (name, each): data[max(0, at - 200) : at + 60] for each in CANARIES if (at := data.find(each.encode())) >= 0
        }
    assert found == {}


def files(folder: Path) -> dict[str, bytes]:
    return {path.name: b"".join(texts(path)) for path in folder.iterdir() if path.is_file()}


def log_of(caplog: pytest.LogCaptureFixture) -> str:
    """The log as it is written, and what other handlers would make of its records."""
    return caplog.text + "".join(repr((each.msg, each.args, each.exc_info)) for each in caplog.records)


def test_nothing_that_a_run_writes_or_shows_holds_a_secret(
    robot: Loud, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    shown = io.StringIO()
    lines = Lines(MISSION, shown, verbose=True)
    journal = tmp_path / "run.journal"
    setting = RunConfig(
        MISSION,
        ROBOT,
        model=Loose(),
        connector=robot,
        journal=journal,
        record=tmp_path / "run.mcap",
        on_step=lines.step,
        on_status=lines.status,
    )
    with prepare(setting) as prepared:
        result = prepared.runner.run()
        lines.end(result)
    assert result.outcome == "aborted" and result.steps > 8
    steps = steps_of(journal)
    assert [name for step in steps for name in step.entered] == ["ask", "post", "break", "go", "over"]
    assert replay(journal).holds, "what was hidden was hidden before it became a step"
    draw_review(MISSION, tmp_path / "page.html", [journal])
    for form in ("dot", "mmd", "md", "svg"):
        draw(MISSION, tmp_path / f"picture.{form}", steps=steps)
    changed = difference(MISSION, MISSION)
    for form in ("html", "md", "json"):
        draw_difference(changed, tmp_path / f"difference.{form}")
    left = files(tmp_path) | {"terminal": shown.getvalue(), "result": repr(result), "steps": repr(steps)}
    assert {"run.journal", "run.mcap", "page.html", "picture.svg", "difference.html"} <= left.keys()
    assert "[hidden]" in shown.getvalue() and b"[hidden]" in left["page.html"]
    notebook = show(MISSION, steps)
    left |= {"notebook": f"{notebook!r} {notebook._repr_svg_()} {notebook._repr_markdown_()}", "log": log_of(caplog)}
    assert_tight(left)


def test_nothing_that_a_node_reports_on_the_graph_holds_a_secret(
    robot: Loud, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    setting = RunConfig(MISSION, ROBOT, model=Loose(), connector=robot, journal=tmp_path / "run.journal")
    node = MissionNode(setting, "loose", managed=False, carrier=Carrier(robot, True, False), operator=False)
    node.run()
    try:
        with prepare(node.joined(setting)) as prepared:
            node.attend(prepared.runner).run()
    finally:
        node.conclude()
        node.stop()
    reported = "\n".join(robot.received)
    assert "status" in reported and "diagnostics" in reported and "[hidden]" in reported
    assert_tight({"node": reported, "log": log_of(caplog)})


def test_a_run_that_cannot_be_begun_by_a_node_reports_why_without_secrets(
    robot: Loud, caplog: pytest.LogCaptureFixture, tmp_path: Path
) -> None:
    def broken() -> Path:
        raise RuntimeError(f"no journal for {' '.join(VARIABLES.values())}")

    setting = RunConfig(MISSION, ROBOT, connector=robot, journal=tmp_path / "run.journal")
    node = MissionNode(setting, "loose", carrier=Carrier(robot, True, False), operator=False, journals=broken)
    node.run()
    client = Client(robot, node.name.path)
    try:
        client.activate()
        reported = repr((client.call("start"), client.command(command="start")))
    finally:
        node.stop()
    assert "[hidden]" in reported
    assert_tight({"replies": reported, "node": "\n".join(robot.received), "log": log_of(caplog)})


def test_nothing_that_the_live_page_is_sent_holds_a_secret(
    robot: Loud, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    page = LivePage(PageAddress(port=0))
    setting = RunConfig(MISSION, ROBOT, model=Loose(), connector=robot, journal=tmp_path / "run.journal")
    watch = RunPage(page, setting, operator=False)
    received: dict[str, bytes] = {}

    def ask(path: str, data: bytes | None = None) -> None:
        headers = {"x-mission-token": page.token, "content-type": "application/json"}
        request = urllib.request.Request(f"{page.address}{path}", data=data, headers=headers)
        try:
            with urllib.request.build_opener(urllib.request.ProxyHandler({})).open(request, timeout=60) as reply:
                received[path] = reply.read()
        except urllib.error.HTTPError as refused:
            with refused:
                received[path] = refused.read()

    def look(runner: Any) -> Any:
        viewer = threading.Thread(target=ask, args=("events",))
        viewer.start()
        ask("mission")
        ask("orders", json.dumps({"command": "post", "event": LEAK, "by": LEAK}).encode())
        result = runner.run()
        page.stop()
        viewer.join()
        return result

    try:
        with prepare(watch.config) as prepared:
            watch.run(prepared, look)
    finally:
        page.stop()
    assert b"[hidden]" in received["events"] and b"over" in received["mission"]
    assert_tight({**received, "log": log_of(caplog), **files(tmp_path)})


def test_no_command_prints_a_secret_whatever_goes_wrong(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for name, value in VARIABLES.items():
        monkeypatch.setenv(name, value)
    monkeypatch.chdir(tmp_path)
    dump(MISSION, tmp_path / "mission.json")
    words_of_all = " ".join((*VARIABLES.values(), OF_MODEL["shape"]))
    leaks = f"raise ValueError({words_of_all!r})"
    provider = "from langchain_core.language_models import BaseChatModel\nclass ChatLoose(BaseChatModel):\n"
    (tmp_path / "langchain_loose.py").write_text(f"{provider}    def __init__(self, **_):\n        {leaks}\n")
    (tmp_path / "guards.py").write_text(leaks)
    (tmp_path / "broken.py").write_text(leaks)
    (tmp_path / "named.py").write_text(f"def mission():\n    {leaks}\n")
    (tmp_path / f"{OF_MODEL['shape']}.json").write_text("{")
    monkeypatch.syspath_prepend(tmp_path)
    for words in (
        ["run", "mission.json", "--model", "loose:x", "--no-operator"],
        ["check", "broken.py"],
        ["check", "named.py"],
        ["check", "mission.json", "--guards", "guards.py"],
        ["check", f"{OF_MODEL['shape']}.json"],
        ["replay", "canary-token-77aa"],
        ["draw", "named.py"],
        ["diff", "named.py", "mission.json"],
        ["prove", "named.py"],
        ["run", "named.py"],
        ["watch", "canary-token-77aa"],
        ["prove", "mission.json"],
        ["diff", "mission.json", "canary-token-77aa"],
        ["world", "canary-token-77aa"],
        ["gate", "--file", VARIABLES["HF_TOKEN"]],
    ):
        with suppress(SystemExit):
            assert main(words) == (0 if words[0] == "prove" and words[1] == "mission.json" else 2), words
        printed = capsys.readouterr()
        assert printed.out or printed.err
        assert_tight({" ".join(words): printed.out + printed.err})


@example("\r", "canary-key-4b1d", "")
@given(st.text(), st.sampled_from([*VARIABLES.values(), "http://stranger:canary-pass@host/"]), st.text())
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_words_on_a_terminal_command_it_nothing_and_report_no_secret(
    monkeypatch: pytest.MonkeyPatch, before: str, secret: str, after: str
) -> None:
    out, err = io.StringIO(), io.StringIO()
    with monkeypatch.context() as patched:
        for name, value in VARIABLES.items():
            patched.setenv(name, value)
        patched.setattr(sys, "stdout", out)
        patched.setattr(sys, "stderr", err)
        with redacted_output(controls=False):
            sys.stdout.write(before + "\x1b]0;title\x07\x9b2J\u202e" + secret + after)
            sys.stderr.writelines([before, secret + after])
        patched.undo()
    for reported in (out.getvalue(), err.getvalue()):
        assert "canary" not in reported
        assert all(letter in "\t\n" or not (ord(letter) < 32 or 127 <= ord(letter) < 160) for letter in reported)
        assert not set("\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069") & set(reported)


def test_a_message_of_numbers_is_passed_on_as_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("STRANGERS_API_KEY", "canary-key-4b1d")
    scan = {"ranges": [0.5] * 1000, "frame": "laser"}
    clean = Redaction().known(scan)
    assert clean == scan and clean["ranges"] is scan["ranges"]
    assert Message("/scan", clean, 0.0).data == scan


def test_a_logger_that_is_made_later_reports_no_secret_either(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setenv("STRANGERS_API_KEY", "canary-key-4b1d")
    made = logger(f"rai_missions.made_later_{id(caplog)}")
    try:
        raise ValueError("canary-key-4b1d")
    except ValueError:
        made.exception("it answered %s", "canary-key-4b1d")
    assert "made_later" in caplog.text and "canary" not in caplog.text


@pytest.mark.parametrize("before", [0, 0.5, True])
def test_a_secret_after_a_number_is_hidden_too(monkeypatch: pytest.MonkeyPatch, before: object) -> None:
    monkeypatch.setenv("STRANGERS_API_KEY", "canary-key-4b1d")
    assert "canary" not in repr(Redaction().known({"text": [before, "canary-key-4b1d"]}))


def test_data_that_is_deeper_than_any_message_ends_no_run(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("STRANGERS_API_KEY", "canary-key-4b1d")
    deep: Any = "canary-key-4b1d"
    for _ in range(5_000):
        deep = [deep]
    assert "canary" not in repr(Redaction().known({"data": deep}))
