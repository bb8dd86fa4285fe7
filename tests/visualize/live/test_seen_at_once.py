# SPDX-License-Identifier: Apache-2.0
"""Who opens the page while a step is made, and not reported yet, sees that step: now or right after."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

import pytest

from rai_missions.agents.mission import RunConfig, prepare
from rai_missions.cli.run.live_page import RunPage
from rai_missions.event import Event
from rai_missions.runtime.lifecycle import Status
from rai_missions.runtime.run_options import RunObserver
from rai_missions.runtime.runner import Runner
from tests.node.scenes import mission
from tests.visualize.live.stage import Viewer, until
from visualize.live import LivePage, PageAddress

pytest.importorskip("uvicorn", reason="no server: pip install '.[watch]'")


@pytest.mark.parametrize(
    ("order", "is_it", "shown"),
    [
        (lambda run: run.pause(), lambda status: status.mode == "paused", lambda seen: seen.get("mode") == "paused"),
        (lambda run: run.post(Event("ask")), lambda status: "asking" in status.active, lambda seen: seen["questions"]),
        (lambda run: run.control("operator"), lambda status: status.control == "operator",
         lambda seen: seen.get("control") == "operator"),
    ],
)  # fmt: skip
def test_a_step_that_is_made_as_the_page_is_opened_is_shown(
    order: Callable[[Runner], object], is_it: Callable[[Status], bool], shown: Callable[[Any], object]
) -> None:
    page, viewers = LivePage(PageAddress(port=0)), list[Viewer]()

    def open_page(status: Status) -> None:
        if is_it(status) and not viewers:
            viewers.append(Viewer(page))
            until(lambda: viewers[0].seen.get("run"), "the page shows the run")

    watch = RunPage(page, RunConfig(mission()))
    watch.config = watch.config.observed_by(RunObserver(None, open_page))
    with prepare(watch.config) as prepared:
        thread = threading.Thread(target=lambda: watch.run(prepared, lambda runner: runner.run()))
        thread.start()
        try:
            until(lambda: page.serves and prepared.runner.view.mode == "running", "it runs")
            order(prepared.runner)
            until(lambda: viewers and shown(viewers[0].seen), "the step is shown")
        finally:
            prepared.runner.kill()
            thread.join(30)
            for viewer in viewers:
                viewer.cut()
            page.stop()
