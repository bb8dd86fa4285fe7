# SPDX-License-Identifier: Apache-2.0
"""The MQTT connector keeps the contract in the modes that it has, on a real broker."""

from __future__ import annotations

import importlib.util
import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rai_missions.connectors.connector import Connector, Message, Reply, Report
from rai_missions.connectors.contract import Inbox, check_connector
from rai_missions.connectors.hri.connector import FROM_HUMAN, VOICE_COMMANDS, HRIConnector
from rai_missions.connectors.mqtt.codec import decode, encode
from rai_missions.connectors.mqtt.connector import MqttConnector
from rai_missions.connectors.mqtt.names import why_no_name
from rai_missions.errors import ConnectorError, UsageError
from rai_missions.image import Image

STRING, TRIGGER = "std_msgs/msg/String", "std_srvs/srv/Trigger"
BROKER = shutil.which("mosquitto", path="/usr/sbin:/usr/local/sbin:/usr/bin:/usr/local/bin")
RULES = next(
    (each for at in ("lib", "lib/*") for each in Path("/usr").glob(f"{at}/mosquitto_dynamic_security.so")), None
)
ABSENT = [
    remedy
    for remedy, is_here in (
        ("apt-get install mosquitto", BROKER),
        ("pip install -e '.[mqtt]'", importlib.util.find_spec("paho")),
    )
    if not is_here
]
needs_broker = pytest.mark.skipif(bool(ABSENT), reason=f"no MQTT broker or client here: {' and '.join(ABSENT)}")


class Broker:
    """A mosquitto on loopback."""

    def __init__(self, folder: Path, *words: str) -> None:
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.port = free.getsockname()[1]
        self._config = folder / "mosquitto.conf"
        lines = (
            f"listener {self.port} 127.0.0.1", "allow_anonymous true", "user root", "persistence true",
            f"persistence_location {folder}/", *words,
        )  # fmt: skip
        self._config.write_text("\n".join(lines) + "\n", encoding="utf-8")
        self.start()

    def start(self) -> None:
        assert BROKER is not None
        self._process = subprocess.Popen([BROKER, "-c", str(self._config)], stderr=subprocess.DEVNULL)
        until = time.monotonic() + 30
        while True:
            try:
                socket.create_connection(("127.0.0.1", self.port), 0.2).close()
                return
            except OSError:
                assert time.monotonic() < until, "mosquitto does not answer"

    def stop(self, *, is_orderly: bool = False) -> None:
        """Die; in order it first writes down what it keeps."""
        (self._process.terminate if is_orderly else self._process.kill)()
        self._process.wait()

    def send(self, topic: str, payload: bytes, *, is_kept: bool = False) -> None:
        """Publish as another program does."""
        import paho.mqtt.publish as publish

        publish.single(topic, payload, qos=1, retain=is_kept, hostname="127.0.0.1", port=self.port)

    def keep(self, topic: str, payload: bytes) -> None:
        """Publish a message that the broker keeps for later readers."""
        self.send(topic, payload, is_kept=True)


@pytest.fixture
def broker(tmp_path: Path) -> Iterator[Broker]:
    made = Broker(tmp_path)
    yield made
    made.stop()


@pytest.fixture
def brokers(tmp_path: Path) -> Iterator[Callable[..., Broker]]:
    """Makes brokers with more words of a configuration; they end with the test, however it ends."""
    with ExitStack() as stack:

        def make(*words: str) -> Broker:
            made = Broker(tmp_path, *words)
            stack.callback(made.stop)
            return made

        yield make


@pytest.fixture
def connector(broker: Broker) -> Iterator[MqttConnector]:
    made = MqttConnector({"port": broker.port}, now=lambda: 50.0)
    made.start()
    yield made
    made.stop()


@needs_broker
def test_it_keeps_the_contract(broker: Broker) -> None:
    check_connector(lambda: MqttConnector({"port": broker.port}))


def test_it_is_a_connector_without_actions() -> None:
    connector, reports = MqttConnector(), Inbox[Report]()
    assert isinstance(connector, Connector)
    assert connector.modes == {"topics", "services"}
    connector.send_goal("/a", "", {}, goal_id="g", on_report=reports)
    connector.cancel_goal("g")
    assert [report.status for report in reports.all] == ["rejected"]
    assert "MQTT carries no actions" in reports.all[0].why
    with pytest.raises(UsageError, match="MQTT carries no actions"):
        connector.offer("/a", "", None)  # type: ignore[arg-type]


@needs_broker
def test_no_one_is_reported_at_once(connector: MqttConnector) -> None:
    replies = Inbox[Reply]()
    connector.call("/no_one", TRIGGER, {}, on_reply=replies)
    assert replies.wait(bool, "the broker knows") == [Reply("unavailable", {}, "no server offers /no_one")]


@needs_broker
def test_calls_from_many_threads_are_all_answered(connector: MqttConnector) -> None:
    replies = Inbox[Reply]()
    connector.serve("/busy", TRIGGER, lambda request: request)

    def call(name: str) -> None:
        for number in range(100):
            connector.call(f"/{name if number % 2 else 'busy'}", TRIGGER, {"n": number}, on_reply=replies)

    threads = [threading.Thread(target=call, args=(name,)) for name in ("nobody", "busy", "no_one", "busy")]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    reported = replies.wait(lambda all_: len(all_) == 400, "every call has an answer")
    assert [reply.outcome for reply in reported].count("unavailable") == 100
    assert [reply.outcome for reply in reported].count("succeeded") == 300


@needs_broker
def test_a_call_that_is_not_answered_is_timed_out(connector: MqttConnector) -> None:
    replies, asked = Inbox[Reply](), Inbox[Message]()
    connector.subscribe("/deaf/request", "", asked)
    connector.call("/deaf", TRIGGER, {}, on_reply=replies, timeout_s=0.2)
    (reply,) = replies.wait(bool, "it is given up")
    assert reply.outcome == "timed_out"


@needs_broker
def test_calls_end_with_the_broker_and_what_was_open_works_when_it_is_back(
    broker: Broker, connector: MqttConnector
) -> None:
    replies, received, asked = Inbox[Reply](), Inbox[Message](), Inbox[Message]()
    connector.subscribe("/t", STRING, received)
    connector.subscribe("/deaf/request", "", asked)
    connector.call("/deaf", TRIGGER, {}, on_reply=replies)
    asked.wait(bool, "the call is on its way")
    broker.stop()
    gone = Reply("unavailable", {}, "the MQTT broker is gone", may_have_arrived=True)
    assert replies.wait(bool, "the broker is gone") == [gone]
    broker.start()
    broker.keep("/t", encode({"data": "again"}))
    received.wait(bool, "the subscription is renewed")


@needs_broker
def test_what_was_not_delivered_is_not_delivered_later(broker: Broker) -> None:
    here, there = MqttConnector({"port": broker.port}), MqttConnector({"port": broker.port})
    replies, received, asked = Inbox[Reply](), Inbox[Message](), Inbox[Any]()

    def horn(request: Any) -> Any:
        asked(dict(request))
        return {}

    for each in (here, there):
        each.start()
    there.serve("/horn", TRIGGER, horn)
    there.subscribe("/drive", STRING, received)
    broker.stop()
    for number in range(3):
        here.call("/horn", TRIGGER, {"n": number}, on_reply=replies, timeout_s=60)
    assert {reply.outcome for reply in replies.wait(lambda all_: len(all_) == 3, "at once")} == {"unavailable"}
    with pytest.raises(ConnectorError, match="nothing can be published on /drive: the MQTT broker is gone"):
        here.publish("/drive", STRING, {"data": "forward"})
    broker.start()
    broker.keep("/drive", encode({"data": "the last"}))
    received.wait(bool, "the other is back")
    ends = Inbox[Reply]()
    until = time.monotonic() + 30
    while not any(reply.outcome == "succeeded" for reply in ends.all) and time.monotonic() < until:
        seen = len(ends.all)
        here.call("/horn", TRIGGER, {"n": "last"}, on_reply=ends)
        ends.wait(lambda all_, seen=seen: len(all_) > seen, "each call ends")  # type: ignore[misc]
    assert asked.all == [{"n": "last"}]
    assert [message.data for message in received.all] == [{"data": "the last"}]
    for each in (here, there):
        each.stop()


@needs_broker
def test_what_was_sent_before_the_end_is_delivered(broker: Broker, connector: MqttConnector) -> None:
    received, sender = Inbox[Message](), MqttConnector({"port": broker.port})
    connector.subscribe("/lights", STRING, received)
    sender.start()
    for number in range(100):
        sender.publish("/lights", STRING, {"data": str(number)})
    sender.stop()
    received.wait(lambda all_: len(all_) == 100, "the broker has all of it")


@needs_broker
def test_a_request_is_of_use_as_long_as_its_call_waits(broker: Broker, connector: MqttConnector) -> None:
    import paho.mqtt.client as mqtt

    requests, replies, is_listening = Inbox[Any](), Inbox[Reply](), Inbox[bool]()
    device = mqtt.Client(mqtt.CallbackAPIVersion.VERSION2, protocol=mqtt.MQTTv5)
    device.on_message = lambda _client, _data, message: requests(message)
    device.on_subscribe = lambda *_: is_listening(True)
    device.connect("127.0.0.1", broker.port)
    device.subscribe("/valve/request", 1)
    device.loop_start()
    is_listening.wait(bool, "the device is there")
    began = time.time()
    for timeout_s in (2.5, 0.2, 5e9, None):
        connector.call("/valve", TRIGGER, {}, on_reply=replies, timeout_s=timeout_s)
    expiries = [
        getattr(each.properties, "MessageExpiryInterval", None)
        for each in requests.wait(lambda all_: len(all_) == 4, "each is delivered")
    ]
    assert expiries == [3, 1, 0xFFFF_FFFF, None]
    ends = [dict(getattr(each.properties, "UserProperty", ())) for each in requests.all]
    assert 2.4 < float(ends[0]["expires_at"]) - began < 10 and ends[3] == {}
    device.disconnect()
    device.loop_stop()


@needs_broker
def test_a_request_that_was_given_up_is_not_served(
    broker: Broker, connector: MqttConnector, caplog: pytest.LogCaptureFixture
) -> None:
    import paho.mqtt.client as mqtt
    from paho.mqtt.packettypes import PacketTypes
    from paho.mqtt.properties import Properties

    asked, caller = Inbox[Any](), mqtt.Client(mqtt.CallbackAPIVersion.VERSION2, protocol=mqtt.MQTTv5)
    connector.serve("/horn", TRIGGER, lambda request: asked(request["by"]) or {})
    connector.subscribe("/later", "", is_served := Inbox[Message]())
    connector.publish("/later", "", {})
    is_served.wait(bool, "the broker has what was sent before")
    caller.connect("127.0.0.1", broker.port)
    caller.loop_start()
    for expires_at in (f"{time.time() - 5}", "soon", f"{time.time() + 500}"):
        properties = Properties(PacketTypes.PUBLISH)
        properties.UserProperty = ("expires_at", expires_at)
        caller.publish("/horn/request", encode({"by": expires_at}), qos=1, properties=properties)
    assert asked.wait(lambda all_: len(all_) == 2, "the others are served") == ["soon", expires_at]
    (warning,) = caplog.records
    assert warning.getMessage().startswith("a request to /horn expired 5.")
    caller.disconnect()
    caller.loop_stop()


@needs_broker
def test_a_message_that_is_more_than_the_broker_takes_is_refused_and_the_way_stays_open(
    brokers: Callable[..., Broker],
) -> None:
    broker, replies = brokers("max_packet_size 2000"), Inbox[Reply]()
    connector = MqttConnector({"port": broker.port})
    connector.start()
    connector.serve("/map", TRIGGER, lambda request: {"map": "x" * 3000} if request else {})
    with pytest.raises(ConnectorError, match=r"^/map: a message of 3\d{3} bytes; the MQTT broker takes 2000 at most$"):
        connector.publish("/map", STRING, {"data": "x" * 3000})
    for request in ({"map": "x" * 3000}, {"please": True}, {}):
        connector.call("/map", TRIGGER, request, on_reply=replies)
    reported = replies.wait(lambda all_: len(all_) == 3, "the way stays open")
    assert [each.outcome for each in reported] == ["failed", "failed", "succeeded"]
    assert all("the MQTT broker takes 2000 at most" in each.why for each in reported[:2])
    connector.stop()


@needs_broker
def test_a_request_whose_answer_has_no_room_is_logged_and_the_way_stays_open(
    brokers: Callable[..., Broker], caplog: pytest.LogCaptureFixture
) -> None:
    import paho.mqtt.client as mqtt
    from paho.mqtt.packettypes import PacketTypes
    from paho.mqtt.properties import Properties

    broker, replies, long = brokers("max_packet_size 400"), Inbox[Reply](), Properties(PacketTypes.PUBLISH)
    connector = MqttConnector({"port": broker.port})
    connector.start()
    connector.serve("/horn", TRIGGER, lambda request: {})
    long.ResponseTopic = "x" * 360
    other = mqtt.Client(mqtt.CallbackAPIVersion.VERSION2, protocol=mqtt.MQTTv5)
    other.connect("127.0.0.1", broker.port)
    other.loop_start()
    connector.call("/horn", TRIGGER, {}, on_reply=replies, timeout_s=5.0)
    replies.wait(bool, "the broker knows who serves")
    other.publish("/horn/request", b"no", qos=1, properties=long).wait_for_publish(5)
    connector.call("/horn", TRIGGER, {}, on_reply=replies, timeout_s=5.0)
    found = replies.wait(lambda all_: len(all_) == 2, "the way stays open")
    assert [each.outcome for each in found] == ["succeeded", "succeeded"]
    logged = [each.message for each in caplog.records if each.exc_info]
    assert logged == ["a message on /horn/request was not understood"]
    other.disconnect()
    other.loop_stop()
    connector.stop()


@needs_broker
def test_what_the_broker_keeps_is_no_request_and_no_news(broker: Broker) -> None:
    first, asked, own = Inbox[Message](), Inbox[Any](), Inbox[Message]()
    broker.keep("/event", encode({"x": 1}))
    broker.keep("/horn/request", encode({"n": 1}))
    connector = MqttConnector({"port": broker.port})
    connector.start()
    connector.serve("/horn", TRIGGER, lambda request: asked(request) or {})
    connector.subscribe("/event", "", first)
    first.wait(bool, "it is kept")
    second = Inbox[Message]()
    connector.subscribe("/event", "", second)
    second.wait(bool, "it is kept for each")
    broker.keep("/own", encode({"y": 1}))
    broker.stop(is_orderly=True)
    connector.subscribe("/own", "", own)
    broker.start()
    own.wait(bool, "the way is open again, and the last that is subscribed to is there")
    assert [len(each.all) for each in (first, second)] == [1, 1] and not asked.all
    broker.keep("/event", encode({"x": 2}))
    first.wait(lambda all_: len(all_) == 2, "another content is news")
    connector.stop()


@needs_broker
def test_a_sentence_that_the_broker_keeps_is_of_the_past(broker: Broker, connector: MqttConnector) -> None:
    for topic, data in ((FROM_HUMAN, {"text": "start the patrol"}), (VOICE_COMMANDS, {"data": "stop"})):
        broker.keep(topic, encode(data))
    hri, texts, words, faults = HRIConnector(connector), Inbox[str](), Inbox[str](), Inbox[Any]()
    hri.listen(FROM_HUMAN, lambda message: texts(message.text), on_fault=faults)
    hri.listen_to_voice_commands(words)
    assert "is of the past" in str(faults.wait(bool, "it is reported")[0])
    broker.send(FROM_HUMAN, encode({"text": "stop", "seq_end": True}))
    broker.send(VOICE_COMMANDS, encode({"data": "play"}))
    texts.wait(bool, "now counts")
    words.wait(bool, "now counts")
    assert (texts.all, words.all) == (["stop"], ["play"])
    hri.close()


@needs_broker
def test_a_topic_that_is_where_a_service_is_asked_is_shared(connector: MqttConnector) -> None:
    messages, replies = Inbox[Message](), Inbox[Reply]()
    close_service = connector.serve("lamp", TRIGGER, lambda request: {"is_on": True})
    close_topic = connector.subscribe("lamp/request", STRING, messages)

    connector.call("lamp", TRIGGER, {"on": True}, on_reply=replies)
    assert replies.wait(bool, "the service answers")[0].outcome == "succeeded"
    assert messages.wait(bool, "the topic is received too")[0].data == {"on": True}

    close_topic()
    connector.call("lamp", TRIGGER, {}, on_reply=replies)
    assert replies.wait(lambda all_: len(all_) == 2, "the service is still there")[1].outcome == "succeeded"

    connector.subscribe("lamp/request", STRING, messages)
    close_service()
    connector.publish("lamp/request", STRING, {"data": "on"})
    assert messages.wait(lambda all_: len(all_) == 2, "the topic is still there")[1].data == {"data": "on"}


@needs_broker
def test_who_subscribes_while_the_last_one_leaves_receives_the_topic(
    connector: MqttConnector, monkeypatch: pytest.MonkeyPatch
) -> None:
    from paho.mqtt.client import Client

    messages, unsubscribe = Inbox[Message](), Client.unsubscribe
    leave = connector.subscribe("leaves", STRING, messages)

    def unsubscribe_late(client: Client, topic: str) -> None:
        connector.subscribe("leaves", STRING, messages)
        unsubscribe(client, topic)

    monkeypatch.setattr(Client, "unsubscribe", unsubscribe_late)
    leave()
    connector.publish("leaves", STRING, {"data": "falling"})
    assert messages.wait(bool, "it is received")[0].data == {"data": "falling"}


@needs_broker
def test_two_servers_of_one_name_are_reported(broker: Broker, caplog: pytest.LogCaptureFixture) -> None:
    robots = [MqttConnector({"port": broker.port}) for _ in range(2)]
    for robot in robots:
        robot.start()
        robot.serve("/horn", TRIGGER, lambda request: {})
    client, replies = MqttConnector({"port": broker.port}), Inbox[Reply]()
    client.start()
    for number in range(1, 4):
        client.call("/horn", TRIGGER, {}, on_reply=replies)
        replies.wait(lambda all_, number=number: len(all_) == number, "the first answer counts")  # type: ignore[misc]
    client.call("/no_one", TRIGGER, {}, on_reply=replies)  # its end comes after all that was on the way
    replies.wait(lambda all_: len(all_) == 4, "each call has one end")
    assert [record.message for record in caplog.records if "two servers" in record.message] == [
        "two servers answer /horn: each request is carried out twice; give each robot its own names"
    ]
    for each in (client, *robots):
        each.stop()


@needs_broker
def test_a_reply_that_is_no_message_ends_the_call(broker: Broker, connector: MqttConnector) -> None:
    import paho.mqtt.client as paho

    def reply(device: paho.Client, _data: Any, request: paho.MQTTMessage) -> None:
        assert request.properties is not None
        to = request.properties.ResponseTopic
        del request.properties.ResponseTopic
        device.publish(to, b"ok", properties=request.properties)

    device, ready, replies = (
        paho.Client(paho.CallbackAPIVersion.VERSION2, protocol=paho.MQTTv5),
        threading.Event(),
        Inbox[Reply](),
    )
    device.on_message, device.on_subscribe = reply, lambda *_: ready.set()
    device.connect("127.0.0.1", broker.port)
    device.loop_start()
    device.subscribe("/horn/request")
    assert ready.wait(10)
    connector.call("/horn", TRIGGER, {}, on_reply=replies)
    (received,) = replies.wait(bool, "the call ends")
    assert received.outcome == "failed"
    assert received.why.startswith("the reply cannot be read: a message is no JSON")
    device.disconnect()
    device.loop_stop()


@needs_broker
def test_a_request_that_is_no_message_is_answered_and_one_without_a_sender_is_served(
    broker: Broker, connector: MqttConnector, caplog: pytest.LogCaptureFixture
) -> None:
    asked, replies = Inbox[Any](), Inbox[Reply]()
    connector.serve("/horn", TRIGGER, lambda request: asked(request) or {})
    connector.call("/horn", TRIGGER, {}, on_reply=replies)
    replies.wait(bool, "the broker knows who serves")
    for payload in (b"no", b"[]", b"{}", b"\xff"):
        broker.send("/horn/request", payload)
    broker.send("/horn/request", encode({"n": 1}))
    asked.wait(lambda all_: len(all_) == 3, "both objects are requests")
    assert not [record for record in caplog.records if record.exc_info]
    assert len([record for record in caplog.records if record.levelname == "WARNING"]) == 2


@needs_broker
@pytest.mark.parametrize(("age_s", "at"), [(0.0, 50.0), (2.0, 48.0), (3600.0, -3550.0), (-30.0, 50.0), (None, 50.0)])
def test_a_stamp_is_reported_on_the_runs_clock(connector: MqttConnector, age_s: float | None, at: float) -> None:
    received = Inbox[Message]()
    connector.subscribe("/stamped", "", received)
    begin = time.time()
    stamp = {} if age_s is None else {"header": {"stamp": begin - age_s}}
    connector.publish("/stamped", "", stamp)
    message = received.wait(bool, "it was published")[0]
    took_s = time.time() - begin if age_s is not None and age_s >= 0 else 0.0  # what is under way grows older
    assert at - took_s - 1e-3 <= message.at <= at + 1e-3


@needs_broker
def test_a_retained_message_is_as_old_as_its_stamp_and_known_for_what_it_is(
    broker: Broker, connector: MqttConnector
) -> None:
    broker.keep("/kept", encode({"header": {"stamp": {"sec": int(time.time()) - 3600, "nanosec": 0}}, "x": 1}))
    received = Inbox[Message]()
    connector.subscribe("/kept", "", received)
    message = received.wait(bool, "it is retained")[0]
    assert message.kept and message.at == pytest.approx(50 - 3600, abs=5)
    assert message.age_s == pytest.approx(3600, abs=5)


def test_without_a_broker_one_sentence_states_it() -> None:
    pytest.importorskip("paho.mqtt", reason="pip install -e '.[mqtt]'")
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        port = taken.getsockname()[1]
        with pytest.raises(ConnectorError, match=f"no MQTT broker answers at 127.0.0.1:{port}"):
            MqttConnector({"port": port}).start()


def test_a_way_that_becomes_silent_is_to_be_known_as_lost_within_seconds() -> None:
    pytest.importorskip("paho.mqtt", reason="pip install -e '.[mqtt]'")
    received = list[bytes]()
    with socket.create_server(("127.0.0.1", 0)) as listening:

        def refuse() -> None:
            client, _ = listening.accept()
            with client:
                received.append(client.recv(1000))
                client.sendall(bytes((0x20, 3, 0, 0x87, 0)))  # CONNACK of MQTT 5: not authorised
                client.recv(1000)

        threading.Thread(target=refuse, daemon=True).start()
        with pytest.raises(ConnectorError, match="does not let us in"):
            MqttConnector({"port": listening.getsockname()[1]}).start()
    after_name = received[0].index(b"MQTT") + len(b"MQTT")  # the version and the flags, then the interval in 2 bytes
    assert 0 < int.from_bytes(received[0][after_name + 2 : after_name + 4]) <= 10


def test_a_port_that_wants_tls_is_taken_for_one_at_once() -> None:
    pytest.importorskip("paho.mqtt", reason="pip install -e '.[mqtt]'")
    with socket.create_server(("127.0.0.1", 0)) as listening:

        def hang_up() -> None:
            client, _ = listening.accept()
            client.recv(1000)
            client.close()

        threading.Thread(target=hang_up, daemon=True).start()
        with pytest.raises(ConnectorError, match="it ends the connection without an answer, as one that wants TLS"):
            MqttConnector({"port": listening.getsockname()[1]}).start()


def _ruled(brokers: Callable[..., Broker], folder: Path, *may_subscribe: str) -> Broker:
    """A broker on which clients may do what is listed, and publish on `/lamp`."""
    rules = [("subscribePattern", each) for each in may_subscribe] + [("publishClientSend", "/lamp")]
    rules_file = folder / "rules.json"
    denied = dict.fromkeys(("publishClientSend", "subscribe"), False)
    acls = [{"acltype": kind, "topic": topic, "allow": True} for kind, topic in rules]
    rules_file.write_text(
        json.dumps(
            {
                "defaultACLAccess": {**denied, "publishClientReceive": True, "unsubscribe": True},
                "clients": [],
                "groups": [{"groupname": "all", "roles": [{"rolename": "any"}], "clients": []}],
                "roles": [{"rolename": "any", "acls": acls}],
                "anonymousGroup": "all",
            }
        ),
        encoding="utf-8",
    )
    return brokers(f"plugin {RULES}", f"plugin_opt_config_file {rules_file}")


@needs_broker
@pytest.mark.skipif(not RULES, reason="mosquitto is here without its plugin for access rules")
def test_what_the_access_rules_of_a_broker_refuse_is_named(
    brokers: Callable[..., Broker], tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    broker = _ruled(brokers, tmp_path, "/lamp", "rai_missions/reply/#")
    connector, replies, received = MqttConnector({"port": broker.port}), Inbox[Reply](), Inbox[Message]()
    connector.start()
    for topic in ("/battery", "/lamp"):
        connector.subscribe(topic, STRING, received)
        connector.publish(topic, STRING, {"data": "on"})
    connector.publish("/battery", STRING, {"data": "on"})
    connector.serve("/dock", TRIGGER, dict)
    connector.call("/horn", TRIGGER, {}, on_reply=replies)
    why = "the MQTT broker takes no request to /horn from us: not authorized"
    assert replies.wait(bool, "at once") == [Reply("unavailable", {}, why)]
    assert [each.topic for each in received.wait(bool, "what is allowed is carried")] == ["/lamp"]
    assert {each.getMessage() for each in caplog.records} == {
        "the MQTT broker does not let us receive /battery: not authorized",
        "the MQTT broker takes no message on /battery from us: not authorized",
        "the MQTT broker does not let us receive /dock/request: not authorized",
    }
    assert len(caplog.records) == 3
    connector.stop()


@needs_broker
@pytest.mark.skipif(not RULES, reason="mosquitto is here without its plugin for access rules")
def test_no_call_waits_for_a_reply_that_the_broker_keeps_back(brokers: Callable[..., Broker], tmp_path: Path) -> None:
    broker, replies = _ruled(brokers, tmp_path, "/lamp", "/lamp/request"), Inbox[Reply]()
    connector = MqttConnector({"port": broker.port})
    connector.start()
    connector.call("/lamp", TRIGGER, {}, on_reply=replies)
    connector.call("/lamp", TRIGGER, {}, on_reply=replies)
    ends = replies.wait(lambda all_: len(all_) == 2, "each ends at once")
    assert {each.outcome for each in ends} == {"unavailable"}
    assert all("does not let us receive rai_missions/reply/" in each.why or "to /lamp" in each.why for each in ends)
    connector.call("/lamp", TRIGGER, {}, on_reply=replies)
    assert "does not let us receive rai_missions/reply/" in replies.all[-1].why
    connector.stop()


def test_why_a_broker_ends_the_way_is_reported(caplog: pytest.LogCaptureFixture) -> None:
    pytest.importorskip("paho.mqtt", reason="pip install -e '.[mqtt]'")
    replies, is_sent = Inbox[Reply](), threading.Event()
    with socket.create_server(("127.0.0.1", 0)) as listening:

        def leave() -> None:
            client, _ = listening.accept()
            with client:
                client.recv(1000)
                client.sendall(bytes((0x20, 3, 0, 0, 0)))  # CONNACK of MQTT 5: welcome
                is_sent.wait(30)
                client.sendall(bytes((0xE0, 2, 0x8B, 0)))  # DISCONNECT: server shutting down
                while client.recv(1000):
                    pass

        threading.Thread(target=leave, daemon=True).start()
        connector = MqttConnector({"port": listening.getsockname()[1]})
        connector.start()
        connector.call("/horn", TRIGGER, {}, on_reply=replies)
        is_sent.set()
        (reply,) = replies.wait(bool, "the broker is gone")
    connector.stop()
    assert reply.why == "the MQTT broker is gone: server shutting down"
    assert any(each.message.endswith("is gone: server shutting down") for each in caplog.records)


@pytest.mark.parametrize(
    ("name", "kind", "why"),
    [
        ("/rooms/+/light", "msg", "'/rooms/+/light' is no name in MQTT: '+' and '#' mean many topics; name each "
         "by itself"),
        ("#", "srv", "'#' is no name in MQTT: '+' and '#' mean many topics; name each by itself"),
        ("", "msg", "a name of MQTT has at least one character"),
        ("a\x01b", "srv", "'a\\x01b' is no name in MQTT: U+0001 in it is no character of a text"),
        ("x" * 65_528, "msg", "x is no name in MQTT: it has more than 65527 bytes"),
        ("/dock", "action", "MQTT carries no actions, and so not /dock; compose it of services"),
        ("/grün/Tür 3", "msg", ""),
    ],
)  # fmt: skip
def test_a_name_that_mqtt_does_not_take_is_reported_with_the_reason(name: str, kind: Any, why: str) -> None:
    assert why_no_name(name, kind).endswith(why) and bool(why) == bool(why_no_name(name, kind))


def test_no_use_of_such_a_name_reaches_the_broker() -> None:
    connector, replies = MqttConnector(), Inbox[Reply]()
    for use in (
        lambda: connector.subscribe("/a/#", STRING, lambda message: None),
        lambda: connector.publish("/a/#", STRING, {"data": "x"}),
        lambda: connector.serve("/a/#", TRIGGER, lambda request: {}),
    ):
        with pytest.raises(ConnectorError, match="'/a/#' is no name in MQTT"):
            use()
    connector.call("/a/#", TRIGGER, {}, on_reply=replies)
    assert [(each.outcome, each.why) for each in replies.all] == [("failed", why_no_name("/a/#", "srv"))]


@needs_broker
@given(name=st.text(min_size=1, max_size=20))
@settings(max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_every_other_name_is_carried(connector: MqttConnector, name: str) -> None:
    if why_no_name(name, "msg") or name.startswith("$"):  # names of the broker's own
        return
    received = Inbox[Message]()
    close = connector.subscribe(name, STRING, received)
    connector.publish(name, STRING, {"data": "x"})
    assert received.wait(bool, f"{name!r} is a name")[0].topic == name
    close()


def test_an_unknown_option_is_reported_with_what_there_is() -> None:
    with pytest.raises(UsageError, match="no option 'hots'; there is: host, port"):
        MqttConnector({"hots": "x"})


@pytest.mark.parametrize("host", ["", "mqtts://broker", "robot..local", 64 * "a", None, 7])
def test_a_host_that_is_none_is_refused_before_the_start(host: Any) -> None:
    with pytest.raises(UsageError, match=r"^connector/host: .* is no host; give a name or an address, as '192"):
        MqttConnector({"host": host})


plain = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text() | st.binary(),
    lambda inner: st.lists(inner) | st.dictionaries(st.text().filter(lambda name: not name.startswith("$")), inner),
)


@given(st.dictionaries(st.text().filter(lambda name: not name.startswith("$")), plain))
def test_what_is_encoded_is_decoded(message: dict[str, Any]) -> None:
    assert decode(encode(message)) == message


def test_a_picture_travels() -> None:
    received = decode(encode({"data": Image("cam@1", 1, 1, "rgb8", lambda: b"abc")}))
    assert (received["data"], received["data"].data) == (Image("cam@1", 1, 1, "rgb8", b""), b"abc")


@pytest.mark.parametrize("payload", [b"", b"[]", b"\xff", b'{"a": {"$bytes": "*"}}', b"[" * 100_000])
def test_what_is_no_message_is_an_error(payload: bytes) -> None:
    with pytest.raises(ConnectorError):
        decode(payload)


def test_what_is_no_plain_data_is_an_error() -> None:
    with pytest.raises(ConnectorError, match="no plain data"):
        encode({"x": object()})


@needs_broker
def test_the_device_of_the_guide_is_reached(broker: Broker, connector: MqttConnector, tmp_path: Path) -> None:
    guide = (Path(__file__).parents[2] / "docs/guide/mqtt.md").read_text(encoding="utf-8")
    device = tmp_path / "greenhouse.py"
    device.write_text(guide.partition("```python\n")[2].partition("```")[0], encoding="utf-8")
    received: Inbox[Message] = Inbox(30.0)
    connector.subscribe("/humidity", "std_msgs/msg/Float64", received)
    with subprocess.Popen([sys.executable, device, str(broker.port)]) as process, ExitStack() as stack:
        stack.callback(process.kill)
        received.wait(lambda all_: len(all_) > 2, "the device publishes")
        late: Inbox[Reply] = Inbox(30.0)
        process.send_signal(signal.SIGSTOP)
        os.waitid(
            os.P_PID, process.pid, os.WSTOPPED
        )  # until then its threads run on, the longer the busier the machine
        connector.call("/valve/open", TRIGGER, {}, on_reply=late, timeout_s=0.2)
        assert late.wait(bool, "the device hangs")[0].outcome == "timed_out"
        process.send_signal(signal.SIGCONT)
        before = len(received.all)
        received.wait(lambda all_: len(all_) > before + 2, "the device publishes again")
        levels = [each.data["data"] for each in received.all]
        assert levels == sorted(levels, reverse=True), "what was given up while it hung opens no valve"
        replies: Inbox[Reply] = Inbox(30.0)
        connector.call("/valve/open", TRIGGER, {}, on_reply=replies)
        (reply,) = replies.wait(bool, "the device replies")
    assert (reply.outcome, reply.data) == ("succeeded", {"success": True, "message": ""})
    assert received.all[0].data["data"] < 0.3
