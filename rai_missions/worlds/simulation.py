# SPDX-License-Identifier: Apache-2.0
"""What our worlds share: a compiled model stepped in simulated time, a camera, and what is open on a connector."""

from __future__ import annotations

import hashlib
from collections.abc import Collection, Iterable, Mapping
from concurrent.futures import Future
from functools import partial
from typing import Any, ClassVar, Self

import mujoco
import numpy as np

from rai_missions.connectors.connector import ActionServer, Answer, Close, Connector, Data, SupportsAdoption
from rai_missions.worlds import messages
from rai_missions.worlds.battery import Battery
from rai_missions.worlds.branching import branched
from rai_missions.worlds.camera import Camera
from rai_missions.worlds.goal_server import SupportsHeir
from rai_missions.worlds.publish_queue import LockedServer, Outbox

__all__ = ("Simulation",)


class Simulation:
    """The physics, the clock and the connections of a `World`.

    Args:
        model: Compiled.
        outbox: Where messages wait until a step is over.
        battery: The robot's; None where it has none.
        camera: The robot's; None where it has none.
        start_s: What the clock shows at the start.
        timestep_s: Of the physics.
    """

    period_s = 0.05
    battery: Battery
    """Only where the robot has one."""
    LEADS_OUT: ClassVar = {"_closes": list}

    def __init__(
        self,
        model: Any,
        outbox: Outbox,
        battery: Battery | None,
        *,
        camera: Camera | None,
        start_s: float,
        timestep_s: float,
    ) -> None:
        self.model, self.data = model, mujoco.MjData(model)
        if battery is not None:
            self.battery = battery
        self.camera = camera
        self.substeps = round(self.period_s / timestep_s)
        self._outbox = outbox
        self._steps, self._start_s = 0, start_s
        self._closes: list[Close] = []
        mujoco.mj_forward(model, self.data)

    @property
    def at(self) -> float:
        """What its clock shows, simulated seconds."""
        return round(self._start_s + self._steps * self.period_s, 9)

    def since(self) -> float:
        """Simulated seconds since the start."""
        return self.at - self._start_s

    def branch(self) -> Self:
        """A copy of the world as it is now, to the bit, on no connector yet; from any thread, between two steps.

        What happens to either changes nothing in the other. A goal that is pursued is pursued there too; its reports
        go to the connector on which the branch is opened.
        """
        with self._outbox.lock:
            return branched(self, type(self).__name__.lower())

    def close(self) -> None:
        for close in self._closes:
            close()
        self._closes.clear()
        if self.camera is not None:
            self.camera.close()

    def fingerprint(self) -> str:
        """SHA-256 of the physical state: two runs that agree to the bit have the same."""
        state = np.concatenate([self.data.qpos, self.data.qvel, self.data.mocap_pos.ravel()])
        return hashlib.sha256(state.tobytes()).hexdigest()

    def _open(
        self,
        connector: Connector,
        *,
        pictures: Collection[str],
        actions: Iterable[tuple[str, str, ActionServer]],
        services: Mapping[tuple[str, str], Answer],
        without: Collection[str] = (),
    ) -> None:
        """Put everything on a connector.

        Args:
            connector: Where to.
            pictures: Topics that need a camera.
            actions: Name, type and server of each.
            services: Name and type → what answers, while no step is made.
            without: Topics that are not published this time.
        """
        if self.camera is not None:
            self.camera.check()
        self._outbox.open(connector, without=(*without, *(() if self.camera is not None else pictures)))
        for (name, type_name), answer in services.items():
            self._closes.append(connector.serve(name, type_name, self._locked(answer)))
        for name, type_name, server in actions:
            self._closes.append(connector.offer(name, type_name, LockedServer(server, self._outbox)))
            if isinstance(server, SupportsHeir) and isinstance(connector, SupportsAdoption):
                server.continue_with(partial(connector.adopt_goal, name))

    def _locked(self, answer: Answer) -> Answer:
        def answered(request: Data) -> Data | Future[Data]:
            with self._outbox.lock:
                return answer(request)

        return answered

    def _is_due(self, periods: int) -> bool:
        """Whether what is published once in so many periods is due after this one."""
        return self._steps % periods == 1

    def _publish_battery(self, *, charging: bool = False) -> None:
        percentage, voltage = self.battery.percentage, self.battery.voltage
        self._outbox.publish("battery", messages.battery_state(percentage, voltage, self.at, charging=charging))
