# SPDX-License-Identifier: Apache-2.0
"""From the name of a model, as given on the command line, to the chat model itself.

Rule: a provider is a package `langchain_PROVIDER`, imported when it is asked for; no list of models is kept here.
"""

from __future__ import annotations

import importlib
import importlib.util
import inspect
import math
import os
import pkgutil
import re
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

from rai_missions.errors import UsageError, install_command, suggestion
from rai_missions.redaction import first_line

if TYPE_CHECKING:
    from langchain_core.language_models import BaseChatModel

__all__ = ("check_model", "model_words", "open_model", "providers", "unknown_provider")

EXTRAS = ("anthropic", "ollama", "openai")
"""The providers that are an extra of this package."""
KEYS = {
    "anthropic": "ANTHROPIC_API_KEY",
    "cohere": "COHERE_API_KEY",
    "deepseek": "DEEPSEEK_API_KEY",
    "fireworks": "FIREWORKS_API_KEY",
    "google_genai": "GOOGLE_API_KEY",
    "groq": "GROQ_API_KEY",
    "mistralai": "MISTRAL_API_KEY",
    "openai": "OPENAI_API_KEY",
    "xai": "XAI_API_KEY",
}
"""Where a provider's package looks for its key, so that a missing one is reported by its name."""
NO_PROVIDERS = {"classic", "community", "core", "experimental", "protocol", "tests", "text_splitters"}
"""Packages named like a provider's that hold no chat model of their own."""


def open_model(spec: str, *, isolated: bool = False) -> BaseChatModel:
    """The chat model named: `openai:gpt-4o`, `ollama:qwen3:4b`, `local`, `local:FILE.gguf`.

    Args:
        spec: `PROVIDER:NAME`, where the package `langchain_PROVIDER` is installed, or `local`, a model on this machine.
        isolated: Whether each call is independent, as it must be where calls are compared: the provider's package
            repeats none that failed, as far as its class has `max_retries`, and a model on this machine keeps nothing
            of earlier prompts, so its answer depends on its own alone, and takes longer.

    Raises:
        UsageError: The name is not of that form, the provider is unknown or not installed, its key is missing, or it
            refuses the name.
    """
    provider, name = _parts(spec)
    if provider == "local":
        from rai_missions.answerers.model.local_server import local_model

        return local_model(_file(name), keeps_prompts=not isolated)
    offered = chat_class(package_of(provider))
    _need_key(spec, provider)
    try:
        once: dict[str, Any] = {"max_retries": 0} if isolated and "max_retries" in offered.model_fields else {}
        return offered(model=name, **once)  # type: ignore[call-arg]  # every provider's class takes `model`
    except Exception as error:  # whatever the provider's package raises, the caller named the model
        raise UsageError(f"the model '{spec}' cannot be opened: {_why(error)}") from error


def check_model(spec: str, *, memory_gib: float) -> None:
    """See whether a model can be opened, as far as that is known without importing its package.

    Args:
        spec: As `open_model` takes it.
        memory_gib: How much memory it may be resident in.

    Raises:
        UsageError: As `open_model`; or a file of weights is larger than the memory that it may be in.
    """
    if not 0 < memory_gib < math.inf:
        raise UsageError(f"a model's memory is a number of GiB above 0, not {memory_gib:g}")
    provider, name = _parts(spec)
    if provider != "local":
        _find(provider)
        _need_key(spec, provider)
        return
    from rai_missions.answerers.model.local_server import gguf, packaged_weights

    size_gib = gguf(_file(name) or packaged_weights()).stat().st_size / 2**30
    if size_gib > memory_gib:
        raise UsageError(
            f"the model '{spec}' has {size_gib:.1f} GiB of weights and may use {memory_gib:g} GiB of memory;"
            f" allow it more: --model-memory {math.ceil(size_gib * 1.5)}"
        )


def model_words(spec: str) -> str:
    """A model as the head of a run names it; of the weights that come along, what they are and are not.

    Args:
        spec: As `open_model` takes it.

    Raises:
        UsageError: It is of no such form.
    """
    provider, name = _parts(spec)
    if provider != "local" or name:
        return spec
    from rai_missions.answerers.model.local_server import TOY

    return f"local ({TOY})"


def _parts(spec: str) -> tuple[str, str]:
    """The provider, and what it calls the model."""
    provider, _, name = (part.strip() for part in spec.partition(":"))
    if provider != "local" and not (provider and name):
        raise UsageError(f"'{spec}' names no model: write PROVIDER:NAME, such as openai:gpt-4o, or local")
    return provider, name


def _file(name: str) -> Path | None:
    return Path(os.path.expanduser(name)) if name else None


def _need_key(spec: str, provider: str) -> None:
    variable = KEYS.get(provider)
    if variable and not os.environ.get(variable):
        raise UsageError(f"the model '{spec}' needs a key: set the environment variable {variable}")


def providers() -> tuple[str, ...]:
    """The providers that can be named: those that are an extra, those whose package is installed, and `local`."""
    installed = {found.name.removeprefix("langchain_") for found in pkgutil.iter_modules() if is_provider(found.name)}
    return tuple(sorted({*EXTRAS, *installed, "local"}))


def is_provider(module: str) -> bool:
    return module.startswith("langchain_") and module.removeprefix("langchain_") not in NO_PROVIDERS


def package_of(provider: str) -> ModuleType:
    """The provider's package, imported."""
    module = _find(provider)
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise UsageError(f"the package '{module}' is installed but does not import: {_why(error)}") from error


def unknown_provider(spec: str) -> str:
    """Why no package could open a model, by its name alone; empty where one may, though it may yet be uninstalled."""
    try:
        provider, _ = _parts(spec)
        if provider not in ("local", *EXTRAS, *KEYS):
            _find(provider)
    except UsageError as error:
        return str(error)
    return ""


def _find(provider: str) -> str:
    """The name of the provider's package, which is installed."""
    module = f"langchain_{provider}"
    if not re.fullmatch("[a-z][a-z0-9_]*", provider) or not is_provider(module):
        raise UsageError(f"no model provider '{provider}'{suggestion(provider, providers())}")
    if importlib.util.find_spec(module) is None:
        if provider in EXTRAS:
            raise UsageError(f"the provider '{provider}' is not installed: {install_command(provider)}")
        near = suggestion(provider, providers())
        more = "" if "did you mean" in near else f"; another comes with its package: pip install {distribution(module)}"
        raise UsageError(f"no model provider '{provider}'{near}{more}")
    return module


def distribution(module: str) -> str:
    return module.replace("_", "-")


def chat_class(package: ModuleType) -> type[BaseChatModel]:
    """The chat model that a provider's package offers; of several, such as one for another cloud, the plainest name."""
    from langchain_core.language_models import BaseChatModel

    offered = [
        value
        for name, value in vars(package).items()
        if name.startswith("Chat") and inspect.isclass(value) and issubclass(value, BaseChatModel)
    ]
    if not offered:
        raise UsageError(f"the package '{package.__name__}' offers no chat model")
    return min(offered, key=lambda offer: (len(offer.__name__), offer.__name__))


def _why(error: BaseException) -> str:
    return first_line(error) or type(error).__name__
