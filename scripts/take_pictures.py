# SPDX-License-Identifier: Apache-2.0
"""Takes the pictures of the documents: pages in a browser, and the same machine as `transitions` draws it.

Rule: a picture that still looks the same is left alone, so that a change of the repository is a change to be seen.
"""

from __future__ import annotations

import io
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from PIL import Image, ImageChops

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))

from benchmarks.browser import find_browser  # noqa: E402
from benchmarks.peers_draw import by_transitions  # noqa: E402
from rai_missions.mission.files import load  # noqa: E402
from visualize import draw_review, drawn, picture  # noqa: E402

FOLDER = ROOT / "docs/pictures"
SIZE = {"width": 1700, "height": 1060}
WIDTH = 1500
COLOURS = 160
"""Enough for flat areas and smooth letters; a third of the bytes."""
SAME = 0.004
"""The part of the pixels that may differ between two machines' ways to draw the same letters."""


def main() -> None:
    """Take all of them."""
    FOLDER.mkdir(exist_ok=True)
    tractor = load(ROOT / "missions/tractor/mission.json")
    keep("tractor_ours.png", drawn(picture(tractor), "png"))
    keep("tractor_transitions.png", by_transitions(tractor, "png"))
    found = find_browser()
    if found is None:
        print("no browser is here, so the pictures of the pages stay as they are (on Debian: apt-get install chromium)")
        return
    with tempfile.TemporaryDirectory() as folder, browser(found) as running:
        pages(running, Path(folder))
        keep("tractor_talk.png", talk(running, Path(folder)))


@contextmanager
def browser(program: str) -> Iterator[Any]:
    """The system's own."""
    from playwright.sync_api import sync_playwright

    flags = ["--no-sandbox"] if os.geteuid() == 0 else []
    with sync_playwright() as playwright:
        running = playwright.chromium.launch(executable_path=program, args=flags)
        yield running
        running.close()


def pages(running: Any, folder: Path) -> None:
    """The shipped missions' review pages: light, dark, through a switch, and with a run."""
    journal = folder / "tractor.journal"
    command = ["run", "missions/tractor/mission.json", "--robot", "missions/tractor/robot.sim.json", "--no-operator"]
    program = Path(sys.executable).with_name("rai-missions")
    subprocess.run([program, *command, "--speed", "max", "--journal", journal], cwd=ROOT, check=True)
    page = folder / "page.html"
    for name in ("tractor", "rosbot"):
        mission = load(ROOT / f"missions/{name}/mission.json")
        draw_review(mission, page)
        for theme in ("light", "dark"):
            keep(f"{name}_{theme}.png", shot(running, page, theme))
    draw_review(load(ROOT / "missions/tractor/mission.json"), page)
    keep("tractor_model.png", shot(running, page, "light", keys="m"))
    draw_review(load(ROOT / "missions/tractor/mission.json"), page, [journal])
    keep("tractor_run.png", shot(running, page, "light", until_answered=True))


TALKED = ("what are you doing?", "how far are you?", "stop", "why did you stop?", "resume", "cancel the mission", "no")


def talk(running: Any, folder: Path) -> bytes:
    """The live page of a run about which a person writes on it."""
    command = ["run", "missions/tractor/mission.json", "--robot", "missions/tractor/robot.sim.json", "--talk"]
    program = Path(sys.executable).with_name("rai-missions")
    more = ["--watch", "0", "--journal", folder / "talked.journal"]
    with subprocess.Popen(
        [program, *command, *more],
        cwd=ROOT,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    ) as run:
        assert run.stderr is not None
        url = next(line.split()[1] for line in run.stderr if line.startswith("watch: "))
        window = running.new_page(viewport=SIZE, color_scheme="light", reduced_motion="reduce")
        window.goto(url)
        window.wait_for_selector("[data-state=driving].active", state="attached", timeout=120_000)
        window.keyboard.press("c")
        for number, text in enumerate(TALKED, start=1):
            window.keyboard.type(text)
            window.keyboard.press("Enter")
            window.locator(f"#talk-lines .robot >> nth={number}").wait_for(timeout=30_000)
        window.wait_for_timeout(1500)
        data: bytes = window.screenshot()
        window.close()
        run.terminate()
    return data


def shot(running: Any, page: Path, theme: str, *, keys: str = "", until_answered: bool = False) -> bytes:
    """What a window shows of a page, after some keys, or where an answer was first accepted in its run."""
    context = running.new_context(viewport=SIZE, color_scheme=theme, offline=True, reduced_motion="reduce")
    window = context.new_page()
    window.goto(page.as_uri())
    window.wait_for_selector("html[data-ready]", state="attached", timeout=120_000)
    for key in f"f{keys}":
        window.keyboard.press(key)
    if until_answered:
        for _ in range(200):
            window.keyboard.press(">")
            if window.locator(".question .verdict:has-text('accepted')").count():
                break
    window.wait_for_timeout(400)
    data: bytes = window.screenshot()
    context.close()
    return data


def keep(name: str, data: bytes) -> None:
    """Store a picture with few colours, unless the stored one looks the same."""
    path, new = FOLDER / name, Image.open(io.BytesIO(data)).convert("RGB")
    if new.width > WIDTH:
        new = new.resize((WIDTH, round(new.height * WIDTH / new.width)), Image.Resampling.LANCZOS)
    small = new.quantize(COLOURS, dither=Image.Dither.NONE)
    if path.exists() and alike(Image.open(path).convert("RGB"), small.convert("RGB")):
        print(f"{name} looks the same")
        return
    small.save(path, optimize=True)
    print(f"{name} {path.stat().st_size / 1000:.0f} kB")


def alike(old: Image.Image, new: Image.Image) -> bool:
    """Whether hardly a pixel differs."""
    if old.size != new.size:
        return False
    apart = ImageChops.difference(old, new).convert("L").point(lambda value: 255 if value > 48 else 0)
    return apart.histogram()[255] <= SAME * new.width * new.height


if __name__ == "__main__":
    main()
