# SPDX-License-Identifier: Apache-2.0
"""From the name of a model, as given on the command line, to the chat model itself.

Rule: a provider is a package `langchain_PROVIDER`, imported when it is asked for; no list of models is kept here.
"""

from __future__ import annotations

import importlib
import importlib.util
import inspect
import os
import pkgutil
import re
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

from rai_missions.cut import first_line
from rai_missions.errors import UsageError
from rai_missions.written import suggestion

if TYPE_CHECKING:
    from langchain_core.language_models import BaseChatModel

__all__ = ("open_model", "providers")

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
"""Where a provider's package looks for its key, so that a missing one is told by its name."""
NO_PROVIDERS = {"classic", "community", "core", "experimental", "protocol", "tests", "text_splitters"}
"""Packages named like a provider's that hold no chat model of their own."""


def open_model(spec: str) -> BaseChatModel:
    """The chat model named: `openai:gpt-4o`, `ollama:qwen3:4b`, `local`, `local:FILE.gguf`.

    Args:
        spec: `PROVIDER:NAME`, where the package `langchain_PROVIDER` is installed, or `local`, a model on this machine.

    Raises:
        UsageError: The name is not of that form, the provider is unknown or not installed, its key is missing, or it
            refuses the name.
    """
    provider, _, name = (part.strip() for part in spec.partition(":"))
    if provider == "local":
        from rai_missions.agents.local_model import local_model

        return local_model(Path(os.path.expanduser(name)) if name else None)
    if not provider or not name:
        raise UsageError(f"'{spec}' names no model: say PROVIDER:NAME, such as openai:gpt-4o, or local")
    offered = chat_class(package_of(provider))
    variable = KEYS.get(provider)
    if variable and not os.environ.get(variable):
        raise UsageError(f"the model '{spec}' needs a key: set the environment variable {variable}")
    try:
        return offered(model=name)  # type: ignore[call-arg]  # every provider's class takes `model`
    except Exception as error:  # whatever the provider's package raises, the caller named the model
        raise UsageError(f"the model '{spec}' cannot be opened: {_why(error)}") from error


def providers() -> tuple[str, ...]:
    """The providers that can be named: those that are an extra, those whose package is installed, and `local`."""
    installed = {found.name.removeprefix("langchain_") for found in pkgutil.iter_modules() if is_provider(found.name)}
    return tuple(sorted({*EXTRAS, *installed, "local"}))


def is_provider(module: str) -> bool:
    return module.startswith("langchain_") and module.removeprefix("langchain_") not in NO_PROVIDERS


def package_of(provider: str) -> ModuleType:
    """The provider's package, imported."""
    module = f"langchain_{provider}"
    if not re.fullmatch("[a-z][a-z0-9_]*", provider) or not is_provider(module):
        raise UsageError(f"no model provider '{provider}'{suggestion(provider, providers())}")
    if importlib.util.find_spec(module) is None:
        if provider in EXTRAS:
            raise UsageError(f"the provider '{provider}' is not installed: pip install 'rai-missions[{provider}]'")
        near = suggestion(provider, providers())
        more = "" if "did you mean" in near else f"; another comes with its package: pip install {distribution(module)}"
        raise UsageError(f"no model provider '{provider}'{near}{more}")
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise UsageError(f"the package '{module}' is installed but does not import: {_why(error)}") from error


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
