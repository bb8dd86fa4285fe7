# SPDX-License-Identifier: Apache-2.0
"""What the server gives to whom, over real HTTP: the page to anybody here, a run to who has its token."""

from __future__ import annotations

import http.client
import json
import os
import socket
import ssl
import subprocess
import time
from collections.abc import Iterator
from contextlib import ExitStack, suppress
from pathlib import Path

import pytest

from rai_missions.errors import UsageError
from rai_missions.image import Image, png
from tests.visualize.live.conftest import OrderBox
from tests.visualize.live.stage import Run, Viewer, ask, until
from tests.visualize.runs import tractor
from visualize.live import LivePage, PageAddress, hub, posts
from visualize.live import timeouts as impatient

WITH_TOKEN = [("GET", "/mission"), ("GET", "/events"), ("GET", "/picture?key=camera"), ("POST", "/orders")]
PAUSE = json.dumps({"command": "pause"}).encode()
HALF_OF_A_HELLO = b"\x16\x03\x01\x02\x00\x01\x00"


def test_the_page_is_there_for_anybody_and_holds_nothing_of_the_mission(run: Run) -> None:
    for path, kind in (("/", "text/html"), ("/live.js", "text/javascript"), ("/live.css", "text/css")):
        status, headers, body = ask(run.page, "GET", path, X_Mission_Token="")
        assert (status, headers["Content-Type"].partition(";")[0]) == (200, kind)
        assert b"tractor" not in body
        assert run.page.token.encode() not in body


@pytest.mark.parametrize(("method", "path"), WITH_TOKEN)
@pytest.mark.parametrize("token", ["", "wrong", "Bearer x"])
def test_without_the_token_there_is_nothing(run: Run, method: str, path: str, token: str) -> None:
    status, _, reported = ask(run.page, method, path, PAUSE if method == "POST" else None, X_Mission_Token=token)
    assert status == 401
    assert "token is missing or wrong" in reported["why"]
    assert run.sink.orders == []


@pytest.mark.parametrize("path", ["/", "/mission", "/orders"])
@pytest.mark.parametrize(
    "host",
    ["evil.example", "evil.example:{port}", "127.0.0.1", "127.0.0.1:1", "127.0.0.1.evil.example:{port}", "", "[", ":"],
)  # fmt: skip
def test_a_name_that_is_not_ours_is_refused(run: Run, path: str, host: str) -> None:
    method, body = ("POST", PAUSE) if path == "/orders" else ("GET", None)
    status, _, reported = ask(run.page, method, path, body, Host=host.format(port=run.page.port) or " ")
    assert status in (400, 421), reported
    assert run.sink.orders == []


@pytest.mark.parametrize("host", ["127.0.0.1:{port}", "localhost:{port}", "LOCALHOST:{port}", "[::1]:{port}"])
def test_the_names_of_this_machine_are_ours(run: Run, host: str) -> None:
    assert ask(run.page, "GET", "/mission", Host=host.format(port=run.page.port))[0] == 200


@pytest.mark.parametrize(
    "headers",
    [
        {"Origin": "http://evil.example"}, {"Origin": "null"}, {"Origin": "http://127.0.0.1:1"},
        {"Origin": "https://127.0.0.1:{port}"}, {"Sec_Fetch_Site": "cross-site"}, {"Sec_Fetch_Site": "same-site"},
    ],
)  # fmt: skip
@pytest.mark.parametrize(("method", "path"), WITH_TOKEN)
def test_another_site_is_refused_even_with_the_token(run: Run, method: str, path: str, headers: dict[str, str]) -> None:
    sent = {name: value.format(port=run.page.port) for name, value in headers.items()}
    status, _, reported = ask(run.page, method, path, PAUSE if method == "POST" else None, **sent)
    assert (status, reported["why"]) == (403, "another site may not use this page")
    assert run.sink.orders == []


def test_no_other_site_is_ever_allowed_to_believe_that_it_may_ask(run: Run) -> None:
    status, headers, _ = ask(run.page, "OPTIONS", "/orders", Origin="http://evil.example", X_Mission_Token="")
    assert status == 403
    assert not [name for name in headers if name.lower().startswith("access-control")]


@pytest.mark.parametrize("path", ["/", "/mission", "/nowhere"])
def test_every_answer_forbids_to_be_framed_run_or_guessed(run: Run, path: str) -> None:
    _, headers, _ = ask(run.page, "GET", path)
    policy = headers["Content-Security-Policy"]
    for part in ("default-src 'none'", "script-src 'self'", "frame-ancestors 'none'", "require-trusted-types-for"):
        assert part in policy
    assert "unsafe" not in policy
    assert headers["X-Frame-Options"] == "DENY"
    assert headers["X-Content-Type-Options"] == "nosniff"
    assert headers["Cache-Control"] == "no-store"


def test_an_order_goes_to_the_sink_as_it_came_and_its_receipt_comes_back(run: Run) -> None:
    text = '{"command": "pause", "by": "\\u202e<b>"}'
    assert ask(run.page, "POST", "/orders", text.encode())[::2] == (200, {"success": True, "why": ""})
    run.sink.reply = (False, "it is not running")
    assert ask(run.page, "POST", "/orders", b"{")[::2] == (409, {"success": False, "why": "it is not running"})
    assert run.sink.orders == [text, "{"]


def test_an_order_that_is_too_large_or_no_json_is_not_read(run: Run) -> None:
    assert ask(run.page, "POST", "/orders", b" " * 70_000)[0] == 413
    for kind in ("text/plain", "application/x-www-form-urlencoded", "multipart/form-data"):
        assert ask(run.page, "POST", "/orders", PAUSE, Content_Type=kind)[0] == 415
    assert ask(run.page, "GET", "/orders")[0] == 405
    assert run.sink.orders == []


def test_orders_come_at_a_bounded_rate_and_a_stop_has_its_own(run: Run) -> None:
    statuses = [ask(run.page, "POST", "/orders", PAUSE)[0] for _ in range(60)]
    assert statuses[:20] == [200] * 20
    assert 429 in statuses
    assert ask(run.page, "POST", "/orders", json.dumps({"command": "e_stop"}).encode())[0] == 200


@pytest.mark.parametrize("sent", [-6.0, -3600.0, float("nan"), float("-inf")])
def test_an_order_that_was_long_on_its_way_is_not_carried_out(run: Run, sent: float) -> None:
    status, _, reported = ask(run.page, "POST", "/orders", PAUSE, X_Mission_Sent=str(time.monotonic() + sent))
    assert (status, reported["success"]) == (409, False)
    assert "orders older than 5 s are not carried out" in reported["why"]
    assert run.sink.orders == []


@pytest.mark.parametrize("command", ["e_stop", "cancel"])
def test_a_stop_and_a_cancel_are_carried_out_however_late_they_come(run: Run, command: str) -> None:
    order = json.dumps({"command": command})
    assert ask(run.page, "POST", "/orders", order.encode(), X_Mission_Sent=str(time.monotonic() - 3600))[0] == 200
    assert run.sink.orders == [order]


def test_an_order_given_by_the_clock_of_the_stream_is_carried_out(run: Run) -> None:
    viewer = Viewer(run.page)
    until(lambda: viewer.seen, "something comes")
    assert ask(run.page, "POST", "/orders", PAUSE, X_Mission_Sent=str(viewer.sent))[0] == 200
    viewer.cut()


def test_a_page_without_a_sink_only_looks(run: Run) -> None:
    with Run(run.mission) as other:
        status, _, reported = ask(other.page, "POST", "/orders", PAUSE)
        assert status == 403
        assert "only looks on" in reported["why"]
        assert ask(other.page, "GET", "/mission")[2]["acts"] is False


def test_a_picture_is_encoded_when_someone_looks_and_not_before(run: Run) -> None:
    made: list[int] = []

    def pixels() -> bytes:
        made.append(1)
        return bytes(4 * 3 * 3)

    run.write("camera", Image("camera@1", 4, 3, "rgb8", pixels))
    viewer = Viewer(run.page)
    until(lambda: "camera" in viewer.seen.get("board", {}), "the picture is reported")
    assert made == []
    for _ in range(5):
        status, headers, body = ask(run.page, "GET", "/picture?key=camera")
        assert (status, headers["Content-Type"], body) == (200, "image/png", png(4, 3, bytes(36)))
    assert made == [1]
    viewer.cut()


@pytest.mark.parametrize(
    "data",
    [
        b"<svg xmlns='http://www.w3.org/2000/svg' onload='alert(1)'/>", b"<!DOCTYPE html><script>1</script>", b"",
        b"GIF89a", b"\x89PNG",
    ],
)  # fmt: skip
def test_what_is_no_picture_by_its_first_bytes_is_not_sent(run: Run, data: bytes) -> None:
    viewer = Viewer(run.page)
    run.write("camera", Image("camera@1", 4, 3, "png", data))
    until(lambda: "camera" in viewer.seen.get("board", {}), "the picture is reported")
    status, headers, reported = ask(run.page, "GET", "/picture?key=camera")
    assert (status, headers["Content-Type"]) == (404, "application/json")
    assert reported["why"].endswith("bytes are neither PNG nor JPEG")
    viewer.cut()


@pytest.mark.parametrize(
    "query", ["", "?key=battery", "?key=nothing", "?key=camera&question=9999", "?question=x&key=camera"]
)
def test_a_picture_that_is_not_there_is_reported(run: Run, query: str) -> None:
    assert ask(run.page, "GET", f"/picture{query}")[0] == 404


@pytest.mark.parametrize(
    "request_", ["GET / HTTP/1.1\r\nHost: x\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\r\n", "\x16\x03\r\n\r\n"]
)
def test_what_a_stranger_sends_is_no_line_on_the_terminal(
    request_: str, run: Run, caplog: pytest.LogCaptureFixture
) -> None:
    with socket.create_connection(("127.0.0.1", run.page.port), timeout=30) as line:
        line.sendall(request_.encode())
        assert line.recv(100).startswith(b"HTTP/1.1 4")
    assert caplog.messages == []


@pytest.mark.parametrize(
    "sent",
    [
        b"GET / HTTP/1.1\r\n\r\n", b"nonsense\r\n\r\n", b"GET / HTTP/1.1\r\nHost: a\r\nHost: 127.0.0.1\r\n\r\n",
        b"GET /../../etc/passwd HTTP/1.1\r\nHost: localhost:{port}\r\n\r\n", b"A" * 40_000,
        b"POST /orders HTTP/1.1\r\nHost: localhost:{port}\r\nContent-Length: -1\r\n\r\n",
    ],
)  # fmt: skip
def test_what_is_no_request_of_ours_is_refused_and_the_page_continues(run: Run, sent: bytes) -> None:
    with socket.create_connection(("127.0.0.1", run.page.port), timeout=10) as line:
        line.sendall(sent.replace(b"{port}", str(run.page.port).encode()))
        reported = line.recv(200)
    assert not reported or reported.split()[1] in (b"400", b"401", b"404", b"421"), reported
    assert ask(run.page, "GET", "/mission")[0] == 200


@pytest.mark.parametrize("message", [b"", b"GET / HTTP/1.1\r\nHost: x\r\n"])
def test_who_knocks_and_sends_nothing_is_cut_off(run: Run, monkeypatch: pytest.MonkeyPatch, message: bytes) -> None:
    monkeypatch.setattr(impatient, "SPEAKS_WITHIN_S", 0.2)
    with socket.create_connection(("127.0.0.1", run.page.port), timeout=30) as line:
        line.sendall(message)
        try:
            assert line.recv(100) == b"", "the other side has hung up"
        except ConnectionResetError:
            pass
    assert ask(run.page, "GET", "/mission")[0] == 200


def test_an_order_whose_rest_never_comes_is_refused(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(posts, "COMES_WITHIN_S", 0.2)
    head = (
        f"POST /orders HTTP/1.1\r\nHost: 127.0.0.1:{run.page.port}\r\nX-Mission-Token: {run.page.token}\r\n"
        f"Content-Type: application/json\r\nContent-Length: {len(PAUSE)}\r\n\r\n"
    )
    with socket.create_connection(("127.0.0.1", run.page.port), timeout=30) as line:
        line.sendall(head.encode() + PAUSE[:-1])
        reported = line.recv(1000)
    assert reported.split()[1] == b"408", reported
    assert run.sink.orders == [] and ask(run.page, "GET", "/mission")[0] == 200


def test_a_client_that_leaves_in_the_midst_of_its_order_costs_no_traceback(
    run: Run, caplog: pytest.LogCaptureFixture
) -> None:
    head = f"POST /orders HTTP/1.1\r\nHost: 127.0.0.1:{run.page.port}\r\nX-Mission-Token: {run.page.token}\r\n"
    with socket.create_connection(("127.0.0.1", run.page.port), timeout=30) as client:
        client.sendall(f"{head}Content-Type: application/json\r\nContent-Length: 50\r\n\r\n{{".encode())
        assert ask(run.page, "GET", "/mission")[0] == 200, "its head has come by now"
    run.page.stop()
    assert caplog.records == []


HALF, UNKNOWN = b"GET / HTTP/1.1\r\nX-Mission", b"GET /mission HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n\r\n"


@pytest.mark.parametrize("message", [b"", HALF, UNKNOWN], ids=["nothing", "half a head", "no token"])
def test_connections_of_strangers_keep_no_order_out_and_are_bounded(run: Run, message: bytes) -> None:
    viewer = Viewer(run.page)
    until(lambda: viewer.seen, "something comes")
    with ExitStack() as open_:
        before = len(os.listdir("/proc/self/fd"))
        lines = []
        for _ in range(400):
            lines.append(open_.enter_context(socket.create_connection(("127.0.0.1", run.page.port), timeout=30)))
            lines[-1].sendall(message.replace(b"{port}", str(run.page.port).encode()))
        order = json.dumps({"command": "e_stop"}).encode()
        assert ask(run.page, "POST", "/orders", order)[0] == 200
        assert run.sink.orders == [order.decode()]
        taken = len(os.listdir("/proc/self/fd")) - before - len(lines)
        assert taken <= impatient.MOST_CONNECTIONS + 2, "on the side of the server, which is in this process"
    seen = len(viewer.kinds)
    until(lambda: len(viewer.kinds) > seen, "who watches is not cut off")
    viewer.cut()


def test_a_viewer_is_not_cut_off(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(impatient, "SPEAKS_WITHIN_S", 0.2)
    monkeypatch.setattr(hub, "BEAT_S", 0.3)
    viewer = Viewer(run.page)
    until(lambda: viewer.kinds.count("beat") > 2, "it is there for longer than that")
    viewer.cut()


def test_a_port_in_use_is_reported_with_a_way_out(run: Run) -> None:
    with pytest.raises(UsageError, match=rf"port {run.page.port} is in use on 127.0.0.1.*--watch PORT.*0 for any"):
        LivePage(PageAddress(port=run.page.port))


@pytest.mark.parametrize("host", ["0.0.0.0", "::", "192.0.2.1", "robot.example"])
def test_another_address_than_loopback_wants_tls(host: str) -> None:
    with pytest.raises(UsageError, match=f"on '{host}' others on the network .* --tls-cert FILE .* ssh -L"):
        LivePage(PageAddress(host, 0))


def test_an_address_that_is_not_there_or_a_certificate_that_is_none_is_reported(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="both a certificate and its key"):
        LivePage(PageAddress(port=0, certificate="a.pem"))
    with pytest.raises(UsageError, match=r"TLS cannot use .*a\.pem"):
        LivePage(PageAddress(port=0, certificate=tmp_path / "a.pem", key=tmp_path / "b.pem"))
    os.mkfifo(tmp_path / "pipe.pem")
    with pytest.raises(UsageError, match=r"TLS cannot use .*pipe\.pem: that is no regular file"):
        LivePage(PageAddress(port=0, certificate=tmp_path / "pipe.pem", key=tmp_path / "b.pem"))
    with pytest.raises(UsageError, match="there is no port 70000"):
        LivePage(PageAddress(port=70_000))


@pytest.fixture
def over_tls(tmp_path: Path) -> Iterator[Run]:
    """A run whose page is served over TLS by a certificate in `cert.pem`."""
    made = subprocess.run(
        [
            "openssl",
            "req",
            "-x509",
            "-newkey",
            "ec",
            "-pkeyopt",
            "ec_paramgen_curve:prime256v1",
            "-nodes",
            "-days",
            "1",
            "-subj",
            "/CN=localhost",
            "-addext",
            "subjectAltName=DNS:localhost,IP:127.0.0.1",
            "-keyout",
            "key.pem",
            "-out",
            "cert.pem",
        ],
        cwd=tmp_path,
        capture_output=True,
        check=False,
    )
    if made.returncode:
        pytest.skip("no openssl to make a certificate with")
    place = PageAddress(port=0, certificate=tmp_path / "cert.pem", key=tmp_path / "key.pem")
    with Run(tractor(), OrderBox(), place=place) as one:
        one.start()
        yield one


def ask_over_tls(run: Run, method: str, path: str, body: bytes | None = None, origin: str = "") -> int:
    """The status of a reply."""
    page = run.page
    trusted = ssl.create_default_context(cafile=str(page.place.certificate))
    headers = {"X-Mission-Token": page.token, "Origin": origin or f"https://127.0.0.1:{page.port}"}
    line = http.client.HTTPSConnection("127.0.0.1", page.port, context=trusted, timeout=30)
    line.request(method, path, body, {**headers, "Content-Type": "application/json"})
    answer = line.getresponse()
    answer.read()
    line.close()
    return answer.status


def test_over_tls_the_page_is_served_and_its_origin_is_https(over_tls: Run) -> None:
    page = over_tls.page
    assert page.url.startswith("https://127.0.0.1:")
    assert ask_over_tls(over_tls, "GET", "/mission") == 200
    assert ask_over_tls(over_tls, "GET", "/mission", origin=f"http://127.0.0.1:{page.port}") == 403


@pytest.mark.parametrize("message", [b"", HALF_OF_A_HELLO], ids=["nothing", "half a hello"])
def test_strangers_who_begin_no_tls_keep_no_order_out_and_are_bounded(over_tls: Run, message: bytes) -> None:
    with ExitStack() as open_:
        before, lines = len(os.listdir("/proc/self/fd")), []
        for _ in range(400):
            lines.append(open_.enter_context(socket.create_connection(("127.0.0.1", over_tls.page.port), timeout=30)))
            lines[-1].sendall(message)
        assert ask_over_tls(over_tls, "POST", "/orders", PAUSE) == 200
        assert over_tls.sink.orders == [PAUSE.decode()]
        taken = len(os.listdir("/proc/self/fd")) - before - len(lines)
        assert taken <= impatient.MOST_CONNECTIONS + 2, "on the side of the server, which is in this process"


@pytest.mark.parametrize("message", [b"", HALF_OF_A_HELLO, b"GET / HTTP/1.1\r\n\r\n"])
def test_who_begins_no_tls_is_cut_off(
    over_tls: Run, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture, message: bytes
) -> None:
    monkeypatch.setattr(impatient, "SPEAKS_WITHIN_S", 0.2)
    with socket.create_connection(("127.0.0.1", over_tls.page.port), timeout=10) as line:
        line.sendall(message)
        with suppress(ConnectionResetError):
            assert not line.recv(100).startswith(b"HTTP"), "the other side has hung up"
            assert line.recv(100) == b""
    assert ask_over_tls(over_tls, "GET", "/mission") == 200
    assert caplog.messages == []


def test_a_request_that_comes_with_the_end_of_the_handshake_is_answered(over_tls: Run) -> None:
    page = over_tls.page
    received, sent = ssl.MemoryBIO(), ssl.MemoryBIO()
    trusted = ssl.create_default_context(cafile=str(page.place.certificate))
    client = trusted.wrap_bio(received, sent, server_hostname="127.0.0.1")
    with socket.create_connection(("127.0.0.1", page.port), timeout=30) as line:
        with pytest.raises(ssl.SSLWantReadError):
            client.do_handshake()
        line.sendall(sent.read())
        while True:
            received.write(line.recv(65_536))
            with suppress(ssl.SSLWantReadError):
                client.do_handshake()
                break
        client.write(f"GET / HTTP/1.1\r\nHost: 127.0.0.1:{page.port}\r\n\r\n".encode())
        line.sendall(sent.read())
        head = b""
        while not head and (data := line.recv(65_536)):
            received.write(data)
            with suppress(ssl.SSLWantReadError):
                head = client.read(100)
    assert head.startswith(b"HTTP/1.1 200")


def test_a_viewers_token_shows_everything_and_orders_nothing(run: Run) -> None:
    seen = {"X_Mission_Token": run.page.viewer_token}
    assert run.page.viewer_token != run.page.token and run.page.viewer_url.endswith(run.page.viewer_token)
    status, _, mission = ask(run.page, "GET", "/mission", **seen)
    assert (status, mission["acts"]) == (200, False)
    assert ask(run.page, "GET", "/mission")[2]["acts"] is True
    for number, name in enumerate(("operator", "operator Mallory", "viewer", "")):
        order = json.dumps({"command": ("pause", "e_stop")[number % 2], "by": name, "role": "operator"}).encode()
        forged = {"X_Role": "operator", "X_Mission_Role": "operator", "Cookie": f"token={run.page.token}"}
        status, _, reported = ask(run.page, "POST", "/orders", order, **seen, **forged)
        assert (status, reported["why"]) == (
            403,
            "a viewer looks, and orders nothing; the operator's address is another one",
        )
    assert run.sink.orders == []


def test_both_tokens_at_once_are_none(run: Run) -> None:
    both = f"{run.page.token}, {run.page.viewer_token}"
    assert ask(run.page, "POST", "/orders", PAUSE, X_Mission_Token=both)[0] == 401
    assert run.sink.orders == []
