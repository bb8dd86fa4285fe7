# SPDX-License-Identifier: Apache-2.0
"""Which kinds of connectors there are: ours, and those that other packages offer by entry points.

Rule: what opens a connector is loaded when one of its kind is opened, never to see whether there is one.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from rai_missions.connectors.connector import Connector
from rai_missions.errors import UsageError, suggestion
from rai_missions.kinds import PackageOffer, known_names, offered

__all__ = ("check_connector", "check_options", "connector_offer", "open_offered")

GROUP = "rai_missions.connectors"
CONNECTORS: Mapping[str, str] = {"ros2": "rai_missions.connectors.ros2", "mqtt": "rai_missions.connectors.mqtt"}
"""Ours: kind → the module that opens it."""
IN_PROCESS = ("local", "python")
"""Kinds that a run opens itself: a simulated world with nothing around it, and a robot in Python that was named."""


def connector_offer(kind: str) -> PackageOffer | None:
    """Who opens connectors of a kind; None for those of `IN_PROCESS`, and where no package does.

    What it loads has `open_connector(options, *, now)`; where it also has `why_absent` and `fields_of`, a profile is
    compared with the types of messages that are there, and where it has `why_no_name`, with the names that it takes.

    Raises:
        UsageError: Two packages do.
    """
    return None if kind in IN_PROCESS else offered(GROUP, kind, CONNECTORS)


def check_connector(kind: str) -> PackageOffer | None:
    """Who opens connectors of a kind; None for those of `IN_PROCESS`.

    Raises:
        UsageError: No one, or two packages do.
    """
    offer = connector_offer(kind)
    if offer is None and kind not in IN_PROCESS:
        raise UsageError(f"no connector of kind '{kind}'{suggestion(kind, known_names(GROUP, ('local', *CONNECTORS)))}")
    return offer


def check_options(offer: PackageOffer, options: Mapping[str, Any]) -> None:
    """Check what a profile gives a connector: by its package's `check_options`, or by opening it without a start.

    Raises:
        UsageError: As `open_offered`.
    """
    if hasattr(package := offer.load(), "check_options"):
        package.check_options(options)
    else:
        open_offered(offer, options)


def open_offered(
    offer: PackageOffer, options: Mapping[str, Any], *, now: Callable[[], float] | None = None
) -> Connector:
    """A connector that a package opens, not started.

    Args:
        offer: As `connector_offer` has it.
        options: What a profile gives under `connector`, without `kind`.
        now: The clock of the run, in seconds; None where its own is used.

    Raises:
        UsageError: It does not load, does not open or is no connector, with its kind and package; an option is not
            understood.
    """
    with offer.opening():
        connector: Connector = offer.keeping(Connector, offer.load().open_connector(options, now=now))
    return connector
