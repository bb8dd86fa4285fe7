# SPDX-License-Identifier: Apache-2.0
"""Make the weights of `rai_missions.voice.recognisers.phrase_network`: speech, noise, Whisper's states, training.

`python -m benchmarks.train_phrases speak FOLDER --model kokoro.onnx --voices voices-v1.0.bin --text FILE` makes
recordings of the phrases, of words like them and of other talk, and keeps what Whisper's encoder gives for each turn of
them. It may run more than once, with other seeds. `… train FOLDER` writes the weights into the package.

Needs, next to the extra `voice`: kokoro-onnx (extra `voice-kokoro`, under GPL-3.0 by its phonemizer), Debian's festival
and festvox-kdlpc16k, jax and optax. Nothing of flite or eSpeak is learned: by their voices the ear is measured.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from benchmarks.bench_voice import mixed
from rai_missions.connectors.sound.connector import FRAME_BYTES, FRAME_S, RATE_HZ
from rai_missions.connectors.sound.wav import converted
from rai_missions.voice.ear import SoundEar
from rai_missions.voice.listener import PHRASES
from rai_missions.voice.recognisers import phrase_network
from rai_missions.voice.recognisers.phrase_network import MOST_STEPS, USUAL_STEPS
from rai_missions.voice.recognisers.whisper import Whisper
from rai_missions.voice.recognisers.whisper_weights import SIZES, weights_of
from rai_missions.voice.turns import TurnDetector, TurnEvent, TurnFrame

LIKE_PHRASES = Path(__file__).with_name("like_phrases.txt").read_text(encoding="utf-8").splitlines()
"""Words that sound like a phrase and are none."""
LEVELS_DB = (3, 5, 8, 10, 10, 12, 15, 20, 40)
"""By how much noise is below the speech; two recordings are made of each sound."""
KED_SHARE = 0.2
"""Of the sounds, those by diphones."""
SPEED, PITCH = (0.75, 1.45), (0.92, 1.09)
"""Ranges in which a speaker of Kokoro is changed."""
KED_STRETCH, KED_MEAN_HZ, KED_SPREAD_HZ, KED_PITCH = (0.7, 1.25), (80, 210), (4, 40), (0.85, 1.18)
TILT = 0.6
"""Of the spectrum, as by another microphone: at most so much of the sample before is taken off or added."""
FEATURES, WIDTH, BATCH, NONE = 48, 9, 96, len(PHRASES)
DROPPED, BLURRED, SMOOTHED = 0.3, 0.1, 0.02
"""In training: the share of features that is left out, noise on the states, how unsure of its label one is."""


class Turn(NamedTuple):
    """One turn of a recording."""

    states: np.ndarray
    """Steps × size, by Whisper's encoder."""
    label: int
    """Which phrase; `NONE` for other words."""


def texts(random: np.random.Generator, talk: list[str]) -> Iterator[tuple[str, int]]:
    """Without end: a phrase, words that are like one, one to four words of other talk; each with its label."""
    while True:
        for label, phrase in enumerate(PHRASES):
            yield phrase.capitalize(), label
            yield str(random.choice(LIKE_PHRASES)).capitalize(), NONE
            count = int(random.integers(1, 5))
            start = int(random.integers(0, len(talk) - count))
            words = " ".join(talk[start : start + count])
            if words.lower().strip(" .,;?'") not in PHRASES:
                yield words, NONE


class KokoroCast:
    """Kokoro with speakers that are mixed of one or two, faster and slower.

    Args:
        model: Its weights.
        voices: Its speakers.
        random: Chooses.
    """

    def __init__(self, model: str, voices: str, random: np.random.Generator) -> None:
        from kokoro_onnx import Kokoro

        self._network = Kokoro(model, voices)
        self._english = [name for name in self._network.get_voices() if name[0] in "ab"]
        self._random = random

    def speak(self, text: str) -> np.ndarray:
        """A text, at `RATE_HZ`, where 1 is the loudest."""
        share = float(self._random.uniform())
        one, other = self._random.choice(self._english, 2, replace=False)
        style = share * self._network.get_voice_style(one) + (1 - share) * self._network.get_voice_style(other)
        language = "en-gb" if "b" in (one[0], other[0]) and share < 0.5 else "en-us"
        speed = float(self._random.uniform(*SPEED))
        samples, rate = self._network.create(text, voice=style.astype(np.float32), speed=speed, lang=language)
        return resampled(samples, rate / float(self._random.uniform(*PITCH)))


class Ked:
    """Festival's voice of diphones, higher and lower, faster and slower.

    Args:
        random: Chooses.
    """

    def __init__(self, random: np.random.Generator) -> None:
        self._random = random

    def speak(self, text: str) -> np.ndarray | None:
        """A text, at `RATE_HZ`, where 1 is the loudest; None where its voice lacks a sound of it."""
        stretch, mean, spread = (
            float(self._random.uniform(*each)) for each in (KED_STRETCH, KED_MEAN_HZ, KED_SPREAD_HZ)
        )
        plain = re.sub("[^A-Za-z .,]", "", text)
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "sound.raw"
            script = f"""(voice_ked_diphone) (Parameter.set 'Duration_Stretch {stretch:.3f})
                (set! int_lr_params '((target_f0_mean {mean:.0f}) (target_f0_std {spread:.0f})
                                      (model_f0_mean 170) (model_f0_std 34)))
                (set! u (Utterance Text "{plain}.")) (utt.synth u) (utt.save.wave u "{file}" 'raw)"""
            (Path(folder) / "speak.scm").write_text(script)
            subprocess.run(["festival", "-b", f"{folder}/speak.scm"], check=False, capture_output=True)
            if not file.exists():
                return None
            sound = np.frombuffer(file.read_bytes(), "<i2").astype(np.float32) / 32768
        loud = np.flatnonzero(np.abs(sound) > 0.006)
        if not len(loud):
            return None
        around = RATE_HZ // 20
        sound = sound[max(0, loud[0] - around) : loud[-1] + around]
        return resampled(sound, RATE_HZ / float(self._random.uniform(*KED_PITCH)))


def resampled(sound: np.ndarray, rate: float) -> np.ndarray:
    """A sound of another rate at `RATE_HZ`; with a rate that is not its own it is higher or lower."""
    loudest = float(np.max(np.abs(sound), initial=1e-3))
    whole = (sound / loudest * 0.5 * 32767).astype("<i2").tobytes()
    return np.frombuffer(converted(whole, round(rate), 1, "speech"), "<i2").astype(np.float32) / 32768


def turns(ear: SoundEar, sound: bytes) -> Iterator[bytes]:
    """What a recogniser is given of each turn of a recording, at its end."""
    detector, at, offered = TurnDetector(), 0.0, dict[int, bytes]()
    sound += bytes(-len(sound) % FRAME_BYTES + 30 * FRAME_BYTES)
    events = list[TurnEvent]()
    for start in range(0, len(sound), FRAME_BYTES):
        found = ear.take(sound[start : start + FRAME_BYTES], bytes(FRAME_BYTES))
        events += detector.take(TurnFrame(at, found.speech, found.clear, found.quiet))
        at += FRAME_S
    for event in (*events, *detector.end()):
        if event.kind == "offered":
            offered[event.number] = event.quiet
        elif event.kind == "ended":
            yield offered[event.number]


def speak(args: argparse.Namespace) -> None:
    """Make recordings, and keep the states of their turns."""
    random = np.random.default_rng(args.seed)
    talk = re.sub(r"[^A-Za-z',.;? ]+", " ", args.text.read_text(encoding="utf-8")).split()
    kokoro, ked, ear = KokoroCast(args.model, args.voices, random), Ked(random), SoundEar()
    whisper = Whisper(weights_of(SIZES[0]), 1)
    found = list[Turn]()
    for number, (text, label) in zip(range(args.count), texts(random, talk), strict=False):
        sound = (ked if random.uniform() < KED_SHARE else kokoro).speak(text)
        if sound is None:
            continue
        tilt = float(random.uniform(-TILT, TILT))
        sound = np.append(sound[0], sound[1:] - tilt * sound[:-1]).astype(np.float32) * 32768
        for _ in range(2):
            recording = mixed(sound, float(random.choice(LEVELS_DB)), str(random.choice(["white", "pink"])), random)
            states = (whisper.states(each) for each in turns(ear, recording))
            found += [Turn(each.astype(np.float16), label) for each in states if len(each) <= MOST_STEPS]
        if number % 50 == 0:
            print(f"{number} of {args.count}", flush=True)
    args.folder.mkdir(parents=True, exist_ok=True)
    np.savez(
        args.folder / f"turns-{args.seed}.npz",
        states=np.concatenate([each.states for each in found]),
        steps=[len(each.states) for each in found],
        labels=[each.label for each in found],
    )


def kept(folder: Path) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """All turns of a folder: states, filled up to `MOST_STEPS`; 1 where there are some; labels."""
    found = list[Turn]()
    for file in sorted(folder.glob("turns-*.npz")):
        with np.load(file) as content:
            pieces = np.split(content["states"], np.cumsum(content["steps"])[:-1])
            found += [Turn(*each) for each in zip(pieces, content["labels"].tolist(), strict=True)]
    if not found:
        raise SystemExit(f"{folder} has no turns: make some with `speak`")
    states = np.zeros((len(found), MOST_STEPS, found[0].states.shape[1]), np.float16)
    present = np.zeros((len(found), MOST_STEPS, 1), np.float32)
    for place, each in enumerate(found):
        states[place, : len(each.states)] = each.states
        present[place, : len(each.states)] = 1
    return states, present, np.array([each.label for each in found])


def train(args: argparse.Namespace) -> None:
    """Train the network with all turns of a folder, and write its weights.

    They are found by AdamW, whose rate falls with a cosine; what scales the states is part of the first layer.
    """
    import jax
    import jax.numpy as jnp
    import optax

    states, present, labels = kept(args.folder)
    mean = (states.astype(np.float32) * present).sum((0, 1)) / present.sum()
    spread = np.sqrt(((states.astype(np.float32) - mean) ** 2 * present).sum((0, 1)) / present.sum()) + 1e-3

    def convolved(x: Any, kernel: Any) -> Any:
        return jax.lax.conv_general_dilated(x, kernel, (1,), "SAME", dimension_numbers=("NWC", "WIO", "NWC"))

    def answers(p: dict[str, Any], x: Any, there: Any, key: Any) -> Any:
        first, second, third = jax.random.split(key, 3)
        x = x * jax.random.bernoulli(first, 1 - DROPPED, (x.shape[0], 1, x.shape[2])) / (1 - DROPPED)
        x = x + BLURRED * jax.random.normal(second, x.shape)
        h = jax.nn.relu(x @ p["reduce"] + p["reduce_bias"]) * there
        h = jax.nn.relu(convolved(h, p["near"]) + p["near_bias"]) * there
        h = h + jax.nn.relu(convolved(h, p["far"]) + p["far_bias"]) * there
        pooled = jnp.concatenate([h.max(1), h.sum(1) / USUAL_STEPS], 1)
        pooled = pooled * jax.random.bernoulli(third, 1 - DROPPED, pooled.shape) / (1 - DROPPED)
        return pooled @ p["answer"] + p["answer_bias"]

    def loss(p: dict[str, Any], x: Any, there: Any, label: Any, key: Any) -> Any:
        wanted = optax.smooth_labels(jax.nn.one_hot(label, NONE + 1), SMOOTHED)
        return optax.softmax_cross_entropy(answers(p, x, there, key), wanted).mean()

    optimiser = optax.adamw(optax.cosine_decay_schedule(2e-3, args.steps), weight_decay=0.02)

    def step(p: dict[str, Any], moments: Any, x: Any, there: Any, label: Any, key: Any) -> Any:
        value, slope = jax.value_and_grad(loss)(p, x, there, label, key)
        change, moments = optimiser.update(slope, moments, p)
        return optax.apply_updates(p, change), moments, value

    fast = jax.jit(step)
    random = np.random.default_rng(args.seed)
    p = {name: jnp.array(each) for name, each in initial_weights(random, states.shape[2]).items()}
    moments, key, recent = optimiser.init(p), jax.random.PRNGKey(args.seed), 0.0
    for number in range(args.steps):
        batch = random.integers(0, len(labels), BATCH)
        x = (states[batch].astype(np.float32) - mean) / spread * present[batch]
        key, own = jax.random.split(key)
        p, moments, value = fast(p, moments, x, present[batch], labels[batch], own)
        recent += 0.02 * (float(value) - recent)
        if number % 100 == 0:
            print(f"{number} of {args.steps}: loss {recent:.3f}", flush=True)
    layers = {name: np.array(each) for name, each in p.items()}
    layers["reduce_bias"] -= (mean / spread) @ layers["reduce"]
    layers["reduce"] /= spread[:, None]
    half = {name: each.astype(np.float32 if name == "reduce_bias" else np.float16) for name, each in layers.items()}
    place = Path(str(phrase_network.__file__)).with_name(phrase_network.WEIGHTS)
    np.savez_compressed(place, allow_pickle=False, phrases=np.array(PHRASES), **half)
    print(f"{place}: {place.stat().st_size / 1000:.0f} kB, from {len(labels)} turns")


def initial_weights(random: np.random.Generator, size: int) -> dict[str, np.ndarray]:
    """Weights to begin with, for states of a size; see `PhraseNetwork`."""
    shapes = {
        "reduce": (size, FEATURES),
        "near": (WIDTH, FEATURES, FEATURES),
        "far": (WIDTH, FEATURES, FEATURES),
        "answer": (2 * FEATURES, NONE + 1),
    }
    weights = {name: random.normal(size=each) / np.sqrt(np.prod(each[:-1])) for name, each in shapes.items()}
    weights |= {f"{name}_bias": np.zeros(each[-1]) for name, each in shapes.items()}
    return {name: each.astype(np.float32) for name, each in weights.items()}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(required=True)
    speaking = commands.add_parser("speak", help="make recordings, and keep the states of their turns")
    speaking.add_argument("--model", required=True, help="kokoro's weights")
    speaking.add_argument("--voices", required=True, help="kokoro's speakers")
    speaking.add_argument("--text", type=Path, required=True, help="other talk: plain text")
    speaking.add_argument("--count", type=int, default=3000, help="how many sounds, each in two recordings")
    speaking.set_defaults(do=speak)
    training = commands.add_parser("train", help="train with the turns that there are, and write the weights")
    training.add_argument("--steps", type=int, default=2000, help="how many batches")
    training.set_defaults(do=train)
    for each in (speaking, training):
        each.add_argument("folder", type=Path, help="where the turns are")
        each.add_argument("--seed", type=int, default=1, help="of all chance")
    args = parser.parse_args()
    args.do(args)
    return 0


if __name__ == "__main__":
    sys.exit(main())
