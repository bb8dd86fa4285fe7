# SPDX-License-Identifier: Apache-2.0
"""A provider's package whose models do to their process whatever a model can do: `--model hostile:DEED`.

It represents any `langchain_PROVIDER` that is installed; tests name this folder as one in which packages are found.
"""

from __future__ import annotations

import ctypes
import json
import os
import re
import signal
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from langchain_core.messages import AIMessage, BaseMessage
from pydantic import SecretStr

from rai_missions.answerers.test_models import DoubleModel, call

__all__ = ("DEEDS", "ChatHostile")

LONG_S = 3_600


class ChatHostile(DoubleModel):
    """Does one thing, each time that it is asked; by a name in two parts, `DEED:WORDS`."""

    model: str
    key: SecretStr = SecretStr(os.environ.get("HOSTILE_API_KEY", "none-given"))

    def __init__(self, model: str, **words: Any) -> None:
        super().__init__(**{**words, "model": model})
        deed = model.partition(":")[0]
        if deed == "refuses":
            raise ValueError(f"no model {model}\nand more")
        if deed == "opens_never":
            time.sleep(LONG_S)
        if deed == "dies_early":
            os._exit(5)
        if deed == "opens_late":
            time.sleep(float(model.partition(":")[2]))

    def reply_to(self, messages: list[BaseMessage]) -> str | AIMessage:
        deed, _, words = self.model.partition(":")
        done: str | AIMessage = DEEDS[deed](messages, words)
        return done


def answers(messages: list[BaseMessage], words: str) -> str:
    return json.dumps({"option": words or "stay", "why": "as it was asked to"})


def repeats(messages: list[BaseMessage], words: str) -> str:
    """What it was shown, in the reason."""
    shown = re.sub(r"[^\w .:,]", " ", str(messages[-1].content))
    return json.dumps({"option": "stay", "why": shown[-300:]})


def hangs(messages: list[BaseMessage], words: str) -> str:
    ctypes.CDLL(None).sleep(LONG_S)  # in C, without the interpreter's lock
    return ""


def holds(messages: list[BaseMessage], words: str) -> str:
    ctypes.PyDLL(None).sleep(LONG_S)  # in C, with the interpreter's lock
    return ""


def holds_once(messages: list[BaseMessage], words: str) -> str:
    """Holds the lock, but for a process that finds the file there."""
    if os.path.exists(words):
        return answers(messages, "")
    with open(words, "w", encoding="ascii"):
        pass
    return holds(messages, "")


def exits(messages: list[BaseMessage], words: str) -> str:
    os._exit(3)


def crashes(messages: list[BaseMessage], words: str) -> str:
    ctypes.string_at(0)
    return ""


def grows(messages: list[BaseMessage], words: str) -> str:
    held = []
    while True:
        held.append(b"x" * (8 << 20))
        time.sleep(0.001)


def grows_elsewhere(messages: list[BaseMessage], words: str) -> str:
    code = "import time; held = b'x' * (300 << 20); time.sleep(3600)"
    subprocess.run([sys.executable, "-c", code], check=False)
    return ""


def threads(messages: list[BaseMessage], words: str) -> str:
    for _ in range(1_000):
        threading.Thread(target=time.sleep, args=(LONG_S,)).start()
    return hangs(messages, words)


def spins(messages: list[BaseMessage], words: str) -> str:
    for _ in range(50):
        threading.Thread(target=_spin).start()
    return hangs(messages, words)


def _spin() -> None:
    while True:
        pass


def pools(messages: list[BaseMessage], words: str) -> str:
    with ThreadPoolExecutor(4) as pool:
        list(pool.map(lambda _: time.sleep(LONG_S), range(4)))
    return ""


def ignores(messages: list[BaseMessage], words: str) -> str:
    ctypes.CDLL(None).signal(signal.SIGTERM, 1)
    return hangs(messages, words)


def leaves_children(messages: list[BaseMessage], words: str) -> str:
    """One in its session, and one that has a session of its own and no parent any more."""
    for way in ("time.sleep(3600)", "os.setsid(); os.fork() and os._exit(0); time.sleep(3600)"):
        subprocess.Popen([sys.executable, "-c", f"import os, time; MARK = {words!r}; {way}"])
    return hangs(messages, "")


def kills_its_guard(messages: list[BaseMessage], words: str) -> str:
    os.kill(os.getppid(), signal.SIGKILL)
    return hangs(messages, "")


def stops_its_guard(messages: list[BaseMessage], words: str) -> str:
    os.kill(os.getppid(), signal.SIGSTOP)
    return hangs(messages, "")


def looks(messages: list[BaseMessage], words: str) -> AIMessage:
    """Looks up which topics there are, and answers with what it found in the reason."""
    last = messages[-1]
    if last.type == "tool":
        reported = re.sub(r"\W+", " ", str(last.content))
        return AIMessage("", tool_calls=[call("stay", why=reported[:300])])
    return AIMessage("", tool_calls=[call("list_topics", containing=words)])


def raises(messages: list[BaseMessage], words: str) -> str:
    raise RuntimeError(f"401: {os.environ.get('HOSTILE_API_KEY')}\nis no key")


def exits_politely(messages: list[BaseMessage], words: str) -> str:
    raise SystemExit(1)


def reports_its_start(messages: list[BaseMessage], words: str) -> str:
    """What others may read of this process, as far as it is named in the words."""
    with open("/proc/self/environ", "rb") as variables, open("/proc/self/cmdline", "rb") as arguments:
        found = variables.read() + arguments.read()
    begun = os.environ[words].encode() in found
    return json.dumps({"option": "stay", "why": f"it was {'shown' if begun else 'hidden'}"})


def _pipes() -> list[int]:
    return [fd for fd in range(3, 64) if _is_pipe(fd)]


def _is_pipe(fd: int) -> bool:
    try:
        return os.readlink(f"/proc/self/fd/{fd}").startswith("pipe:")
    except OSError:
        return False


def _write(data: bytes) -> None:
    for fd in _pipes():
        try:
            os.write(fd, data)
        except OSError:
            continue


def writes_noise(messages: list[BaseMessage], words: str) -> str:
    _write(b"\xff" * 100)
    return hangs(messages, "")


def _framed(message: object) -> bytes:
    data = json.dumps(message).encode()
    return struct.pack(">I", len(data)) + data


def floods(messages: list[BaseMessage], words: str) -> str:
    while True:
        _write(_framed({"dropped": 1}) * 1_000)


def forges(messages: list[BaseMessage], words: str) -> str:
    """Replies of which each is wrong in another way; the number of the reply is the words."""
    number = int(words or 0)
    _write(_framed(FORGED[number % len(FORGED)]))
    return hangs(messages, "")


GOOD = {"text": "stay", "calls": [], "in": 1, "out": 1, "broken": 0, "model": ""}
FORGED: list[object] = [
    {"reply": 1, "text": "x"}, {"reply": 1, **GOOD, "calls": {}}, {"reply": 1, **GOOD, "in": -1}, {"reply": 2, **GOOD},
    {"reply": 1, **GOOD, "text": "x" * 30_000}, {"reply": "1", **GOOD}, {"ready": {}}, {"ready": True},
    {"absent": "me"}, [], 7, {"reply": 1, **GOOD, "calls": [{"name": "stay", "args": "x", "id": ""}]},
    {"reply": True, **GOOD}, {"reply": 1, "raised": {}}, {"reply": 1, **GOOD, "in": 1e300}, {"dropped": 1},
    {"reply": 1, **GOOD, "model": None}, {"dropped": []},
]  # fmt: skip

DEEDS: dict[str, Callable[[list[BaseMessage], str], Any]] = {
    deed.__name__: deed
    for deed in (
        answers,
        repeats,
        hangs,
        holds,
        holds_once,
        exits,
        crashes,
        grows,
        grows_elsewhere,
        threads,
        spins,
        pools,
        ignores,
        leaves_children,
        kills_its_guard,
        stops_its_guard,
        looks,
        raises,
        exits_politely,
        reports_its_start,
        writes_noise,
        floods,
        forges,
    )
}
DEEDS["opens_late"] = answers
