# SPDX-License-Identifier: Apache-2.0
"""The tests reach nothing but this machine, and hold no one's key."""

from __future__ import annotations

import os
import socket
from typing import Any

import pytest


@pytest.mark.parametrize("host", ["192.0.2.1", "2001:db8::1", "models.example"])
def test_another_machine_is_out_of_reach(host: str) -> None:
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    ours: Any = socket.socket(family)  # `check` is what `connect` asks first: nothing is sent here
    with ours, pytest.raises(RuntimeError, match=f"tried to reach '{host}'; tests reach nothing but this machine"):
        ours.check((host, 80))
    assert socket.getaddrinfo.__name__ == "getaddrinfo_here"


@pytest.mark.parametrize("host", ["127.0.0.1", "127.8.0.1", "localhost"])
def test_this_machine_is_in_reach(host: str) -> None:
    with socket.socket() as server, socket.socket() as client:
        server.bind((host, 0))
        server.listen()
        client.connect(server.getsockname())


def test_no_key_is_at_hand() -> None:
    assert [name for name in os.environ if name.endswith("_API_KEY")] == []
