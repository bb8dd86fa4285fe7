# SPDX-License-Identifier: Apache-2.0
"""How any client steers the mission: `std_srvs` and JSON, and, where the package is built, types of its own."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rai_missions.connectors.connector import Close, Connector, Data, Message
from rai_missions.node.names import NodeName
from rai_missions.node.order import ClientOrder, OrderReply, from_ros, mapping_in, read_order, who
from rai_missions.node.order_server import OrderServer
from rai_missions.node.transport import PACKAGE

__all__ = ("STRING", "serve_orders", "serve_typed_orders")

STRING, TRIGGER = "std_msgs/msg/String", "std_srvs/srv/Trigger"
PLAIN = ("start", "pause", "resume", "cancel", "e_stop")
"""Orders that need no more words: each is a service of its own."""


def serve_orders(
    connector: Connector, name: NodeName, commands: OrderServer, reply: Callable[[OrderReply], None]
) -> list[Close]:
    """Serve `~/start`, `~/pause`, `~/resume`, `~/cancel` and `~/e_stop`, and listen to `~/command`.

    Args:
        connector: Started.
        name: The node's.
        commands: Takes the orders.
        reply: Publishes what became of a command.
    """

    def receive(message: Message) -> None:
        order = read_order(message.data.get("data"))
        if isinstance(order, OrderReply):
            reply(order)
        else:
            commands.submit(from_ros(order), reply)

    triggers = [connector.serve(name.below(word), TRIGGER, _trigger(commands, word)) for word in PLAIN]
    return [*triggers, connector.subscribe(name.below("command"), STRING, receive)]


def _trigger(commands: OrderServer, word: str) -> Callable[[Data], Data]:
    return lambda _request: _answered(commands.ask(ClientOrder(word, by=f"operator (~/{word})", role="operator")))


def serve_typed_orders(connector: Connector, name: NodeName, commands: OrderServer) -> list[Close]:
    """Serve `~/set_control`, `~/answer` and `~/post`, in the types of `rai_missions_msgs`."""

    def control(request: Data) -> Data:
        order = ClientOrder("control", who(request.get("by")), to=str(request.get("to", "")))
        return _answered(commands.ask(from_ros(order)))

    def answer(request: Data) -> Data:
        given = mapping_in(request.get("parameters", ""), "parameters")
        if isinstance(given, str):
            return _answered(OrderReply(False, given))
        number, option = int(request.get("number", 0)), str(request.get("option", ""))
        run = str(request.get("run", ""))
        order = ClientOrder("answer", who(request.get("by")), question=number, run=run, option=option, parameters=given)
        return _answered(commands.ask(from_ros(order)))

    def post(request: Data) -> Data:
        given = mapping_in(request.get("data", ""), "data")
        if isinstance(given, str):
            return _answered(OrderReply(False, given))
        order = ClientOrder("post", who(request.get("by")), event=str(request.get("event", "")), data=given)
        return _answered(commands.ask(from_ros(order)))

    served: list[tuple[str, str, Callable[[Data], Data]]] = [
        ("set_control", "Control", control),
        ("answer", "Answer", answer),
        ("post", "Post", post),
    ]
    return [connector.serve(name.below(word), f"{PACKAGE}/srv/{kind}", act) for word, kind, act in served]


def _answered(reply: OrderReply) -> dict[str, Any]:
    return {"success": reply.success, "message": reply.why}
