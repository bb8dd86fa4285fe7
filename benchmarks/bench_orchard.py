# SPDX-License-Identifier: Apache-2.0
"""How fast the orchard is: physics against real time, and milliseconds a frame.

Physics is measured in CPU seconds of the whole step – autonomy, sensors, contacts, messages – while the tractor drives;
frames in wall seconds, the median of twenty, at 640x480.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable

from rai_missions.connectors.local import LocalConnector
from rai_missions.worlds import open_world

SIMULATED_S = 60.0
AIMS = {"physics": "20 x", "colour": "60 ms"}


def main() -> None:
    """Print the table."""
    rows = [("world", f"{_real_time(camera=True):.0f} x", "real time, camera on"), *_physics(), *_frames()]
    print(f"{'what':<14}{'measured':>12}  {'aim':>8}  how")
    for what, measured, how in rows:
        print(f"{what:<14}{measured:>12}  {AIMS.get(what, ''):>8}  {how}")


def _physics() -> list[tuple[str, str, str]]:
    return [("physics", f"{_real_time(camera=False):.0f} x", "real time, no pictures")]


def _real_time(*, camera: bool) -> float:
    """Simulated seconds a CPU second."""
    world = open_world("orchard", camera=camera)
    connector = LocalConnector(now=lambda: world.at)
    world.open(connector)
    connector.start()
    connector.call("/tractor1/continue", "", {}, on_reply=lambda _reply: None)
    begun = time.process_time()
    while world.at < SIMULATED_S:
        world.step()
    taken = time.process_time() - begun
    world.close()
    return SIMULATED_S / taken


def _frames() -> list[tuple[str, str, str]]:
    from rai_missions.worlds.orchard import Orchard  # mujoco is imported after open_world chose how to render

    world = Orchard()
    camera = world.camera
    assert camera is not None
    moment = camera.moment(world.data)
    kinds: dict[str, Callable[[], object]] = {
        "colour": lambda: camera.colour(moment),
        "depth": lambda: camera.depth_m(moment),
        "segmentation": lambda: camera.segmentation(moment),
        "detector": lambda: camera.frame(moment),
    }
    rows = [(kind, f"{_median_ms(render):.1f} ms", "a frame of 640x480") for kind, render in kinds.items()]
    world.close()
    return [*rows[:-1], (*rows[-1][:2], "depth and segmentation of 320x240")]


def _median_ms(render: Callable[[], object], times: int = 20) -> float:
    render()
    taken = []
    for _ in range(times):
        begun = time.perf_counter()
        render()
        taken.append(time.perf_counter() - begun)
    return statistics.median(taken) * 1000


if __name__ == "__main__":
    main()
