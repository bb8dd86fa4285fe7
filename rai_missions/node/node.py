# SPDX-License-Identifier: Apache-2.0
"""The mission's node: the paper's Agent around runs, over a connector, with the lifecycle that ROS 2 knows."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from pathlib import Path

from rai_missions.agents.mission import RunConfig
from rai_missions.agents.other_missions import RUNS_TOPIC
from rai_missions.agents.run_plan import profile_of
from rai_missions.connectors.connector import Close, Reply
from rai_missions.engine.step import Step
from rai_missions.errors import UsageError
from rai_missions.node.action_server import RunServer
from rai_missions.node.launched import parameters_of
from rai_missions.node.lifecycle_callbacks import LifecycleCallbacks
from rai_missions.node.managed_lifecycle import ManagedLifecycle, serve_lifecycle
from rai_missions.node.names import NodeName
from rai_missions.node.order import ClientOrder, OrderReply, ignore_reply
from rai_missions.node.order_server import PATIENCE_S, OrderServer
from rai_missions.node.publisher import StatusPublisher
from rai_missions.node.run_host import RunHost
from rai_missions.node.run_session import RunSession
from rai_missions.node.services import STRING, serve_orders, serve_typed_orders
from rai_missions.node.transport import PACKAGE, Carrier, name_of, open_carrier
from rai_missions.runtime.runner import Runner

__all__ = ("MissionNode",)

LOOK_S = 4.0
"""How long another node of the same name may take to answer; longer than a connector's `discovery_s`, within which it
is found or is not there."""
FAREWELL_S = 2.0
"""How much longer than its `cancel_s` a canceled run may take before the e-stop."""


class MissionNode:
    """A node that runs a mission whenever a client asks for it; or one next to a run that another object begins.

    Args:
        setting: What a run is made of.
        name: The node's; left out, the profile's or the mission's.
        managed: Runs are begun by clients. Else by the one who made the node, with `joined` and `attend`.
        ros_arguments: What follows `--ros-args`.
        carrier: Used instead of what the profile names.
        journals: Names a fresh journal for each run; else there is only the setting's.
        operator: Clients answer as the operator, where the setting names no one.
        ended: Receives each run of the node's own that is over.

    Raises:
        UsageError: A name that no node can have, a connector that cannot be opened.
        DefinitionError: The profile is at fault.
    """

    def __init__(
        self,
        setting: RunConfig,
        name: str = "",
        *,
        managed: bool = True,
        ros_arguments: Sequence[str] = (),
        carrier: Carrier | None = None,
        journals: Callable[[], Path] | None = None,
        operator: bool = True,
        ended: Callable[[RunSession], None] = lambda _session: None,
    ) -> None:
        robot = profile_of(setting)
        self._host = RunHost(setting, robot=robot, journals=journals, operator=operator)
        self.name: NodeName = name_of(name, self._host.called, robot, ros_arguments)
        self._carrier = carrier or open_carrier(robot, self.name, now=self._host.now, ros_arguments=ros_arguments)
        self._is_managed, self._on_end = managed, ended
        self._publisher = StatusPublisher(
            self._carrier, self.name, self._host, lambda: (self._lifecycle.state.label, self._lifecycle.fault)
        )
        self._finalized = threading.Event()
        self._commands = OrderServer(self._begin if managed else None, self._publisher.changed)
        self._acts = LifecycleCallbacks(self._commands, ready=self._ready, finalized=self._finalized.set)
        self._lifecycle = ManagedLifecycle(self._acts.by_label(), self._publisher.moved)
        self._closes: list[Close] = []
        self._is_open = self._is_ours = False

    # -- the agent ------------------------------------------------------------------------------------------------

    def run(self) -> None:
        """Open the node; next to a run it is active at once, else unconfigured.

        Raises:
            UsageError: Another node has its name, or a parameter is no argument of the mission.
            ConnectorError: The graph cannot be reached.
        """
        if self._is_open:
            return
        self._is_open = True
        self._is_ours = not self._carrier.connector.running
        try:
            self._carrier.connector.start()
            self._host.take_parameters(parameters_of(self._carrier.connector))
            self._look_for_others()
            self._serve()
        except BaseException:
            self.stop()
            raise
        self._publisher.open()
        if not self._is_managed:
            self._lifecycle.change("configure")
            self._lifecycle.change("activate")

    def stop(self) -> None:
        """Cancel what runs, and close the node."""
        session = self._commands.live
        if session is not None and self._is_managed:
            session.submit(ClientOrder("cancel", "stop", role="operator"), ignore_reply)
            self._host.join(session.runner.mission.cancel_s + FAREWELL_S)
            session.submit(ClientOrder("e_stop", "stop", role="operator"), ignore_reply)
            self._host.join(FAREWELL_S)
        while self._closes:
            self._closes.pop()()
        self._publisher.close()
        if self._is_open and self._is_ours:
            self._carrier.connector.stop()
        self._is_open = False

    @property
    def fault(self) -> str:
        """Why the last transition of its lifecycle failed; empty once one has succeeded."""
        return self._lifecycle.fault

    @property
    def session(self) -> RunSession | None:
        """The run that was begun last."""
        return self._host.session

    def ask(self, order: ClientOrder, within_s: float = PATIENCE_S) -> OrderReply:
        """Give an order from this program, and wait for a moment for what becomes of it."""
        return self._commands.ask(order, within_s)

    def wait(self, within_s: float | None = None) -> bool:
        """Until the node was shut down; whether it was."""
        return self._finalized.wait(within_s)

    def shut_down(self, *, at_once: bool = False) -> None:
        """Cancel what runs and finalize the node, as its lifecycle has it.

        Args:
            at_once: The run is not canceled; it gets the e-stop.
        """
        session = self._commands.live
        if at_once and session is not None:
            session.submit(ClientOrder("e_stop", "operator (interrupt)", role="operator"), ignore_reply)
        self._lifecycle.change_next("shutdown")

    # -- next to a run ---------------------------------------------------------------------------------------------

    def joined(self, setting: RunConfig) -> RunConfig:
        """A setting whose run travels over the node's connector, is reported by it and can be answered through it."""
        return self._host.joined(setting, self._carrier, on_step=self._followed, on_wait=self._publisher.changed)

    def attend(self, runner: Runner) -> RunSession:
        """Follow a run that is about to begin, by `RunSession.run`."""
        session = self._host.attend(runner)
        is_deactivated = self._acts.attend(session)
        self._commands.attend(session)
        if is_deactivated:
            self._lifecycle.change("deactivate")
        return session

    def conclude(self) -> None:
        """The run that was attended is over."""
        self._commands.ended()
        self._lifecycle.change("shutdown")

    def _followed(self, step: Step) -> None:
        session = self._host.session
        if session is not None:
            if session.step(step):
                self._publisher.changed()
            self._publisher.step(step, session.runner.run_id)
            session.receive(step)

    # -- runs of its own ------------------------------------------------------------------------------------------

    def _begin(self, order: ClientOrder) -> RunSession:
        return self._host.begin(order, self.joined, self._ended)

    def _ended(self, session: RunSession) -> None:
        self._commands.ended()
        self._on_end(session)

    def _ready(self) -> None:
        if self._is_managed:
            self._host.read()

    # -- the graph ------------------------------------------------------------------------------------------------

    def _look_for_others(self) -> None:
        replies: list[Reply] = []
        is_answered = threading.Event()

        def answered(reply: Reply) -> None:
            replies.append(reply)
            is_answered.set()

        service, kind = self.name.below("get_state"), "lifecycle_msgs/srv/GetState"
        self._carrier.connector.call(service, kind, {}, on_reply=answered, timeout_s=LOOK_S)
        is_answered.wait(LOOK_S + 1.0)
        if replies and replies[0].outcome == "succeeded":
            raise UsageError(f"another node is called {self.name.path} already; give this one a name with --node NAME")

    def _serve(self) -> None:
        connector, name = self._carrier.connector, self.name
        self._closes += serve_lifecycle(connector, name, self._lifecycle)
        self._closes += serve_orders(connector, name, self._commands, self._publisher.reply)
        self._closes.append(connector.subscribe(name.below("status"), STRING, self._publisher.receive))
        self._closes.append(connector.subscribe(RUNS_TOPIC, STRING, self._publisher.receive_run))
        if self._carrier.robots and self._host.published_clock is not None:
            self._closes.append(self._host.published_clock.follow(connector))
        if self._carrier.typed:
            self._closes += serve_typed_orders(connector, name, self._commands)
            if "actions" in connector.modes and self._is_managed:
                server = RunServer(self._commands, self._publisher.reply)
                self._publisher.follow(server.follow)
                self._closes.append(connector.offer(name.below("run"), f"{PACKAGE}/action/RunMission", server))
