# SPDX-License-Identifier: Apache-2.0
"""Viewers come, go, stall and come back; the run does not notice, and each ends with what is so."""

from __future__ import annotations

import asyncio
import socket
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rai_missions.engine import Chart
from rai_missions.engine.trees import CompiledTrees
from rai_missions.errors import UsageError
from rai_missions.image import Image
from rai_missions.runtime.lifecycle import Lifecycle
from tests.visualize.live.stage import Run, Viewer, ask, until
from tests.visualize.live.test_scene import ACTS, play
from tests.visualize.runs import tractor
from visualize.live import RunFeed, RunScene, hub


def ends_with(viewer: Viewer, run: Run) -> None:
    until(lambda: viewer.sees(**run.whole), f"{viewer.seen} becomes {run.whole}; {viewer.error}")


def test_a_viewer_sees_what_is_so_and_each_change(run: Run) -> None:
    viewer = Viewer(run.page)
    ends_with(viewer, run)
    run.send("anomaly")
    ends_with(viewer, run)
    assert "assessing" in viewer.seen["active"]
    assert viewer.seen["steps"][-1]["taken"] == ["/states/working/states/driving/transitions/0"]
    play(run, "agent")
    ends_with(viewer, run)
    [question] = viewer.seen["questions"]
    assert question["options"][0]["name"] == "replan"
    viewer.cut()


@settings(max_examples=12, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.lists(st.one_of(ACTS, st.sampled_from(["cut", "come"])), max_size=25))
def test_whatever_is_cut_a_viewer_that_comes_back_ends_with_what_is_so(acts: list[str]) -> None:
    with Run(tractor()) as run:
        run.start()
        stays, comes = Viewer(run.page), Viewer(run.page)
        is_cut = False
        for act in acts:
            if act == "cut" and not is_cut:
                comes.cut()
                is_cut = True
            elif act == "come" and is_cut:
                comes.come()
                is_cut = False
            elif act not in ("cut", "come"):
                play(run, act)
        if is_cut:
            comes.come()
        ends_with(stays, run)
        ends_with(comes, run)
        assert comes.seen["outcome"] == stays.seen["outcome"] == (run.chart.outcome or "")
        assert comes.seen["questions"] == stays.seen["questions"]
        stays.cut()
        comes.cut()


def test_who_comes_back_soon_receives_what_was_missed_and_not_all_of_it(run: Run) -> None:
    stays, comes = Viewer(run.page), Viewer(run.page)
    ends_with(comes, run)
    comes.cut()
    run.send("anomaly")
    ends_with(stays, run)
    comes.kinds.clear()
    comes.come()
    ends_with(comes, run)
    assert "state" not in comes.kinds
    for viewer in (stays, comes):
        viewer.cut()


@pytest.mark.parametrize("last", ["", "x", "abc-5", "00000000-1", "-1", "9" * 40, "a-b-c", "٣-٣"])
def test_who_names_a_position_of_nonsense_receives_all(run: Run, last: str) -> None:
    viewer = Viewer(run.page)
    viewer.cut()
    viewer.kinds.clear()
    viewer.last = last.encode().decode("latin-1")
    viewer.come()
    until(lambda: viewer.kinds, "something comes")
    assert viewer.kinds[0] == "state"
    ends_with(viewer, run)
    viewer.cut()


def test_a_viewer_that_was_away_for_longer_than_is_kept_receives_all(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    viewer = Viewer(run.page)
    ends_with(viewer, run)
    viewer.cut()
    stays = Viewer(run.page)
    for number in range(hub.RING + 5):
        run.send("anomaly" if number % 2 else "nonsense")
        until(lambda: len(stays.seen.get("steps", [])) > 0, "it is reported")
    run._made(run.chart.write("battery", 0.6))
    viewer.come()
    ends_with(viewer, run)
    ends_with(stays, run)
    for each in (viewer, stays):
        each.cut()


@pytest.mark.long
def test_a_server_that_falls_behind_looks_again_at_the_whole(run: Run) -> None:
    viewer = Viewer(run.page)
    for number in range(5000):
        run.write("battery", 0.5 + number / 10_000)
    run.send("anomaly")
    ends_with(viewer, run)
    viewer.cut()


def test_ten_viewers_see_the_same(run: Run) -> None:
    viewers = [Viewer(run.page) for _ in range(10)]
    for act in ("obstacle", "anomaly", "agent", "replan", "pause", "resume", "cancel"):
        play(run, act)
    for viewer in viewers:
        ends_with(viewer, run)
    until(lambda: run.page.viewers == 10, "ten are counted")
    for viewer in viewers:
        viewer.cut()
    until(lambda: run.page.viewers == 0, "those who went are counted out")


def test_one_viewer_too_many_is_reported_so(run: Run) -> None:
    viewers = [Viewer(run.page) for _ in range(hub.MOST_VIEWERS)]
    until(lambda: run.page.viewers == hub.MOST_VIEWERS, "all are in")
    status, _, reported = ask(run.page, "GET", "/events")
    assert status == 503
    assert "close one" in reported["why"]
    for viewer in viewers:
        viewer.cut()


class ReadFeed(RunFeed):
    """A run that is read before it is shown, on a thread, as a journal is."""

    async def begin(self, wake: Callable[[], None]) -> RunScene:
        await asyncio.to_thread(int)
        return await super().begin(wake)


def test_viewers_that_come_while_the_run_is_read_are_counted(run: Run) -> None:
    async def come() -> list[Any]:
        watched = hub.Hub(ReadFeed(lambda: run))
        more = hub.MOST_VIEWERS + 3
        found = await asyncio.gather(*(watched.join() for _ in range(more)), return_exceptions=True)
        assert watched.viewers == hub.MOST_VIEWERS
        await watched.close()
        return found

    refused = [each for each in asyncio.run(come()) if isinstance(each, UsageError)]
    assert [str(each) for each in refused] == [f"{hub.MOST_VIEWERS} viewers watch already; close one"] * 3


def test_a_viewer_who_comes_while_the_page_closes_is_turned_away(run: Run) -> None:
    """A server that ends waits for each stream, and a new one has no end."""

    async def come_late() -> str:
        closing = hub.Hub(ReadFeed(lambda: run))
        await closing.join()
        await closing.close()
        with pytest.raises(UsageError) as refused:
            await closing.join(is_operator=True)
        return str(refused.value)

    assert asyncio.run(come_late()) == "this page is closing; the run may continue"


def test_viewers_make_room_for_the_operator_and_are_counted_apart(run: Run) -> None:
    others = [Viewer(run.page, run.page.viewer_token) for _ in range(hub.MOST_VIEWERS)]
    until(lambda: run.page.viewers == hub.MOST_VIEWERS, "all are in")
    assert run.page.operators == 0
    assert ask(run.page, "GET", "/events", X_Mission_Token=run.page.viewer_token)[0] == 503
    operator = Viewer(run.page)
    until(lambda: run.page.operators == 1, "the operator is in")
    run.send("nonsense")
    ends_with(operator, run)
    assert run.page.viewers == hub.MOST_VIEWERS
    for viewer in (operator, *others):
        viewer.cut()


def test_a_viewer_that_does_not_read_is_dropped_and_holds_no_one_up(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(hub, "MOST_WAITING", 16)
    reads = Viewer(run.page)
    with socket.create_connection(("127.0.0.1", run.page.port)) as stalled:
        stalled.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 2048)
        head = f"GET /events HTTP/1.1\r\nHost: 127.0.0.1:{run.page.port}\r\nX-Mission-Token: {run.page.token}\r\n\r\n"
        stalled.sendall(head.encode())
        until(lambda: run.page.viewers == 2, "both are in")
        number = 0
        while run.page.viewers == 2:
            number += 1
            assert number < 1000
            for _ in range(100):
                run.send("nonsense" * 40)
            until(lambda: reads.seen.get("steps", [{}])[-1].get("seq", 0) >= run.chart.seq, "the reader keeps up")
    ends_with(reads, run)
    reads.cut()


def test_without_a_viewer_nothing_is_made_of_a_step(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    def encoded(*_: Any) -> Any:
        raise AssertionError("something was made for no viewer")

    monkeypatch.setattr("visualize.live.scene.line", encoded)
    monkeypatch.setattr("visualize.live.scene.bounded", encoded)
    for act in ("obstacle", "anomaly", "agent", "replan"):
        play(run, act)
    run.write("camera", Image("camera@1", 4, 3, "rgb8", encoded))
    monkeypatch.undo()
    viewer = Viewer(run.page)
    until(lambda: "camera" in viewer.seen.get("board", {}), "who comes later sees it all")
    assert [step["event"]["name"] for step in viewer.seen["steps"]][:2] == ["start", "anomaly"]
    viewer.cut()


def test_the_end_of_the_page_is_reported(run: Run) -> None:
    viewer = Viewer(run.page)
    ends_with(viewer, run)
    run.send("kill", "command", by="operator (page)")
    run.page.stop()
    until(lambda: viewer.kinds[-1:] == ["end"], "the end comes")
    assert viewer.sees(mode="aborted", control="nobody", why="e-stop by operator (page)")
    viewer.cut()


def test_a_line_on_which_nothing_happens_is_known_to_be_alive(run: Run) -> None:
    viewer = Viewer(run.page)
    until(lambda: viewer.kinds.count("beat") >= 2, f"it beats; {viewer.kinds}")
    viewer.cut()


def test_news_that_change_nothing_do_not_keep_the_line_silent(run: Run) -> None:
    viewer = Viewer(run.page)
    ends_with(viewer, run)
    viewer.kinds.clear()

    def beats() -> bool:
        if run.feed._wake is not None:
            run.feed._wake()
        return "beat" in viewer.kinds

    until(beats, "it beats")
    viewer.cut()


def test_who_comes_later_sees_who_paused_and_whose_stop_it_was(run: Run) -> None:
    run.send("pause", "command", by="operator Anna (page)")
    viewer = Viewer(run.page)
    until(lambda: viewer.sees(mode="paused", paused_by="operator Anna (page)"), "it is seen who paused")
    viewer.cut()
    until(lambda: run.feed._wake is None, "no one looks on, and nothing is followed")
    run.send("resume", "command", by="operator")
    run.send("kill", "command", by="operator Ben (page)")
    at = run.chart.at
    run.write("battery", 0.7)
    viewer = Viewer(run.page)
    wanted = {"e_stop_by": "operator Ben (page)", "ended_at": at, "paused_by": "", "outcome": "aborted"}
    until(lambda: viewer.sees(**wanted), f"{viewer.seen} has {wanted}")
    viewer.cut()


def test_a_viewer_of_a_run_that_is_over_sees_the_one_that_follows_and_nothing_of_the_first(run: Run) -> None:
    viewer = Viewer(run.page)
    run.send("anomaly")
    run.send("kill", "command", by="operator Ben (page)")
    until(lambda: viewer.sees(outcome="aborted", e_stop_by="operator Ben (page)"), "the first is over")
    run.chart, run.mode, run.control = Chart(run.mission, ticker=CompiledTrees()), "ready", "autonomy"
    run.feed.renew()
    until(lambda: viewer.sees(outcome="", e_stop_by="", mode="ready"), f"{viewer.seen} is the second")
    assert viewer.seen["steps"] == [] and viewer.seen["active"] == []
    run.life = Lifecycle()
    run.start()
    ends_with(viewer, run)
    assert viewer.seen["mode"] == "running" and len(viewer.seen["steps"]) == 1
    viewer.cut()
