# SPDX-License-Identifier: Apache-2.0
"""A browser that reads the pages as a user does; where there is none, its tests are skipped.

Rule: a page that raises an error, opens a dialog or asks for another address fails its test.
"""

from __future__ import annotations

import os
import shutil
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

PATIENCE = 30_000
"""Milliseconds, on a machine that is busy with much else."""
BROWSERS = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
"""What draws no window of its own comes first: it takes half the processor time."""

Launch = Callable[..., Any]
Open = Callable[..., Any]
Look = Callable[..., Any]


@pytest.fixture(scope="package")
def launch() -> Iterator[Launch]:
    """Starts the system's own browser with more flags; for this folder: no other test may run a loop meanwhile."""
    playwright = pytest.importorskip("playwright.sync_api", reason="no Playwright: pip install '.[browser]'")
    found = next((path for name in BROWSERS if (path := shutil.which(name))), None)
    if found is None:
        pytest.skip("no browser is here (on Debian: apt-get install chromium-headless-shell)")
    with playwright.sync_playwright() as running:
        flags = [*(["--no-sandbox"] if os.geteuid() == 0 else []), "--disable-dev-shm-usage"]
        yield lambda *more: running.chromium.launch(executable_path=found, args=[*flags, *more])


@pytest.fixture(scope="package")
def browser(launch: Launch) -> Iterator[Any]:
    """The one that most tests share."""
    started = launch()
    yield started
    started.close()


@pytest.fixture
def opened(browser: Any, tmp_path: Path) -> Iterator[Open]:
    """Opens the bytes of a page in a window of its own, at an address within it."""
    contexts: list[Any] = []
    wrong: list[str] = []

    def open_page(page: bytes, at: str = "", **more: Any) -> Any:
        path = tmp_path / f"page{len(contexts)}.html"
        path.write_bytes(page)
        context = browser.new_context(**{"viewport": {"width": 1400, "height": 900}, "offline": True, **more})
        contexts.append(context)
        window = context.new_page()
        window.set_default_timeout(PATIENCE)
        window.on("pageerror", lambda error: wrong.append(str(error)))
        window.on("dialog", lambda dialog: (wrong.append(dialog.message), dialog.dismiss()))
        window.on("request", lambda asked: wrong.append(asked.url) if not is_ours(asked.url, path) else None)
        window.goto(f"{path.as_uri()}{at}")
        window.wait_for_selector("html[data-ready]", state="attached")
        return window

    yield open_page
    for context in contexts:
        context.close()
    assert wrong == []


@pytest.fixture
def look(browser: Any) -> Iterator[Look]:
    """Opens a page's address in a window of its own; an error, a dialog or another address fails the test."""
    yield from looking(browser)


def looking(browser: Any) -> Iterator[Look]:
    """What opens pages in this browser, and then judges what they did."""
    contexts: list[Any] = []
    wrong: list[str] = []

    def open_page(page: Any, **more: Any) -> Any:
        context = browser.new_context(**{"viewport": {"width": 1400, "height": 900}} | more)
        contexts.append(context)
        window = context.new_page()
        window.set_default_timeout(PATIENCE)
        window.on("pageerror", lambda error: wrong.append(str(error)))
        window.on("dialog", lambda dialog: (wrong.append(dialog.message), dialog.dismiss()))
        window.on("request", lambda asked: wrong.append(asked.url) if not asked.url.startswith(page.address) else None)
        window.on(
            "console", lambda reported: wrong.append(reported.text) if "Content Security" in reported.text else None
        )
        window.goto(page.url)
        window.wait_for_selector("html[data-ready=yes]", state="attached")
        return window

    yield open_page
    for context in contexts:
        context.close()
    assert wrong == []


def until(window: Any, condition: str) -> None:
    """Waits for what holds in a page; its policy lets no string be read as a script, so it is asked from outside."""
    end = time.monotonic() + PATIENCE / 1000
    while not window.evaluate(condition):
        assert time.monotonic() < end, condition
        window.wait_for_timeout(10)


def is_ours(url: str, path: Path) -> bool:
    return url.startswith(("data:image/png;", "data:image/jpeg;")) or url.partition("#")[0] == path.as_uri()


def assert_accessible(window: Any) -> None:
    """Axe finds no violation in what a page shows now."""
    axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="no axe: pip install '.[browser]'").Axe()
    found = axe.run(window).response["violations"]
    assert [(each["id"], [node["html"][:120] for node in each["nodes"][:3]]) for each in found] == []
