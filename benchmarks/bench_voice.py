# SPDX-License-Identifier: Apache-2.0
"""Speech, end to end: orders in noise, orders that are none, words, wake words, echo, barge-in and delays.

`python -m benchmarks.bench_voice [SECTION …] [--scale N]`; the sections are orders, false, words, wake, called, alarms,
echo, barge, delay. All speech is made here by flite; what is measured goes through frames, processes and turns as on a
robot, but for the words of `wake` and `alarms`, which are looked for in this process. A long run is made in pieces:
`WINDOWS` for `false`, `HOURS` and a `SEED` each for `alarms`.
"""

from __future__ import annotations

import argparse
import os
import re
import statistics
import sys
import time
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import lru_cache
from itertools import product
from pathlib import Path
from pydoc_data.topics import topics
from typing import Any, NamedTuple

import numpy as np

from rai_missions.connectors.sound.connector import FRAME_BYTES, FRAME_S, RATE_HZ, SoundFrame
from rai_missions.connectors.sound.files import FileSound
from rai_missions.connectors.sound.room import RoomSound
from rai_missions.conversation import (
    Dialogue,
    MissionView,
    Order,
    Speech,
    SpeechEnd,
    StatusView,
    TalkNote,
    Utterance,
)
from rai_missions.voice.ear import WAKE_WORDS, EchoCanceller, WakeWord
from rai_missions.voice.kind import opened
from rai_missions.voice.listener import PHRASES, WAKE_CUTOFF, ListenSettings, SpeechListener, Transcript
from rai_missions.voice.process import OnReply, SpeechProcess, SpeechReply
from rai_missions.voice.recognisers.whisper import plain_words
from rai_missions.voice.setup import ListenNames, Recognition, open_recognition
from rai_missions.voice.voices.flite import Flite
from rai_missions.voice.worker import ORDERS as ORDERS_OF_PROCESSES

SPEAKERS = ("slt", "rms", "awb", "kal")
ORDERS = ("pause the mission", "resume the mission", "continue", "cancel the mission", "start the mission", "yes", "no")
SPOKEN = PHRASES if os.environ.get("PHRASES") == "all" else ("stop", *ORDERS)
"""The orders that are spoken."""
SEED = int(os.environ.get("SEED", "1"))
"""Of the noise: thresholds were chosen with 101 and 201."""
RECOGNISER = os.environ.get("RECOGNISER", "whisper")
"""The first recogniser, with its options: `whisper:weights=base`."""
LEVELS = tuple(int(each) for each in os.environ.get("DB", "40 20 10").split())
"""By how many dB the noise of the orders is below the speech."""
NOISES = tuple(os.environ.get("NOISES", "white pink").split())
"""Their noises: white, pink, babble of eight voices, hum of the mains."""
CROWD_BEFORE_S = 5.0
"""How long the babble is there before an order."""
HUM_HZ, HUM_PARTIALS = 50, 20
FIRST, LAST = (int(each) for each in os.environ.get("WINDOWS", "0 1000000").split())
"""Which windows of `false` are transcribed: parts of a long run, one after the other."""
HERE = "HERE" in os.environ
"""The ear and the recognisers are in this process, which costs less, and no wall clock ends what is slow."""
WORDS = tuple(os.environ.get("WORDS", " ".join(WAKE_WORDS)).split())
"""The wake words of `wake`, `called` and `alarms`."""
HOURS = float(os.environ.get("HOURS", "0.1"))
"""Of sound without a wake word, for `alarms`."""
NOISE_SHARE, MUSIC_SHARE = 0.05, 0.05
"""Of its pieces, those that are noise alone, and music."""
NEAR_ALARM = 0.25
"""From which probability of a wake word on a piece is printed."""
READ_TEXT = Path(__file__).with_name("read_text.txt")
"""The words of eleven pages of the guide on 2026-11-27: the guide changes, the windows stay."""
SENTENCES = (
    "What are you doing?", "Where are you going?", "How far is it to the kitchen?", "Why did you stop?",
    "Go to the kitchen and look for a cup.", "How much battery is left?", "What do you see in front of you?",
    "Please drive to the living room.", "Is there a plant on the table?", "Bring me to the charging station.",
    "Which waypoint is the next one?", "The chair next to the door is in your way.", "Wait here until I come back.",
    "How long will the mission take?", "Show me what you have found so far.", "Is anybody in the bedroom?",
    "Drive a little slower, please.", "What can you carry?", "Did you find the red cup?", "Why are you waiting?",
)  # fmt: skip


OWN = (
    "The mission has ended. I drove all alleys.",
    "I am driving to the kitchen.",
    "Stop. Cancel the mission. Yes.",
)
"""Reports of the robot."""


class PartHere(SpeechProcess):
    """What a process would hold, in this one: on a machine with other work an ear is too late otherwise."""

    _held: Any = None

    def open(self) -> None:
        self._held = opened(self.sort, self.name, self._options)

    def wait_ready(self, within_s: float = 0.0) -> bool:
        return True

    def close(self, within_s: float = 0.0) -> None:
        self._held = None

    def ask(
        self, order: Mapping[str, Any], blobs: Sequence[bytes] = (), *, on_reply: OnReply, on_part: object = None
    ) -> None:
        on_reply(SpeechReply(ORDERS_OF_PROCESSES[self.sort](self._held, order, blobs, -1)))


class Bench:
    """The whole pipeline, with processes that are kept from one recording to the next.

    Args:
        names: The names of the recognisers and the wake word.
        here: All of it in this process.
    """

    def __init__(self, names: ListenNames | None = None, *, here: bool = False) -> None:
        self.found: list[Transcript] = []
        self.present: list[float] = []
        names = names or ListenNames(RECOGNISER)
        self._part = PartHere if here else SpeechProcess
        self.settings = ListenSettings(needs_wake_word=bool(names.wake_word))
        if here:
            whisper, _, options = names.recogniser.partition(":weights=")
            processes = (
                PartHere("ear", "ear", {"wake_word": names.wake_word}),
                PartHere("recogniser", whisper, {"threads": 1} | ({"weights": options} if options else {})),
                PartHere("recogniser", names.second),
            )
            for process in processes:
                process.open()
            self.recognition = Recognition(SpeechListener(*processes, on_transcript=self.found.append), processes)
        else:
            self.recognition = open_recognition(names, ListenSettings(), on_transcript=self.found.append)
        self.recognition.wait_ready()

    def of(self, sound: FileSound, *, after: int = 30) -> list[Transcript]:
        self.found.clear()
        self.present.clear()
        listener = SpeechListener(
            *self.recognition.processes,
            settings=self.settings,
            on_transcript=self.found.append,
            on_present=self.present.append,
        )
        sound.listen(listener.take)
        sound.start()
        count = 0
        while not sound.over or after > 0:
            after -= sound.over
            sound.step()
            count += 1
            if count % 64 == 0:
                listener.catch_up()
        listener.finish()
        return [each for each in self.found if each.text]

    def new_ear(self) -> None:
        """An ear that knows no room yet."""
        ear, *others = self.recognition.processes
        ear.close()
        fresh = self._part("ear", "ear", within_s=5.0)
        fresh.open()
        self.recognition = self.recognition._replace(processes=(fresh, *others))

    def close(self) -> None:
        self.recognition.close()


VOICES: dict[str, Flite] = {}


@lru_cache(maxsize=256)
def speech(text: str, speaker: str) -> np.ndarray:
    voice = VOICES.setdefault(speaker, Flite(speaker))
    return np.frombuffer(b"".join(voice.speak(text)), "<i2").astype(np.float32)


def noise(kind: str, count: int, random: np.random.Generator) -> np.ndarray:
    """White, pink, babble or hum, whose mean square is 1."""
    if kind == "babble":
        start = int(random.integers(len(babble()) - count))
        return babble()[start : start + count]
    if kind == "hum":
        angles = 2 * np.pi * HUM_HZ * np.arange(count) / RATE_HZ
        partials = sum(np.sin(each * angles + random.uniform(0, 2 * np.pi)) / each for each in range(1, HUM_PARTIALS))
        return np.asarray(partials / np.sqrt(np.mean(partials**2)))
    white = random.normal(size=count)
    if kind == "white":
        return white
    spectrum = np.fft.rfft(white) / np.sqrt(np.maximum(1, np.arange(count // 2 + 1)))
    pink = np.fft.irfft(spectrum, count)
    return np.asarray(pink / np.sqrt(np.mean(pink**2)))


@lru_cache
def babble() -> np.ndarray:
    """Half a minute of a room full of people: the guide, read by eight at once, from eight places on."""
    words, mixture = READ_TEXT.read_text().split(), np.zeros(30 * RATE_HZ)
    for place in range(8):
        start, track = place * len(words) // 8, np.zeros(0)
        while len(track) < len(mixture):
            track = np.append(track, speech(" ".join(words[start : start + 12]), SPEAKERS[place % 4]))
            start += 12
        mixture += track[: len(mixture)]
    return np.asarray(mixture / np.sqrt(np.mean(mixture**2)))


def mixed(
    sound: np.ndarray,
    db: float,
    kind: str,
    random: np.random.Generator,
    before_s: float = 1.5,
    *,
    of: np.ndarray | None = None,
) -> bytes:
    """Speech in noise: so many dB over the parts that are no pause; 1.5 s of noise come first, as in a room.

    Args:
        sound: The speech.
        db: By how much the noise is below it.
        kind: The kind of the noise.
        random: Makes it.
        before_s: How long it is there before the speech.
        of: Noise of that kind that is there already: a piece of it is taken, which costs less.
    """
    loud = sound[np.abs(sound) > 100]
    level = np.sqrt(np.mean(loud**2)) if len(loud) else 1000.0
    whole = np.concatenate([np.zeros(int(before_s * RATE_HZ)), sound, np.zeros(RATE_HZ // 2)])
    if of is None:
        around = noise(kind, len(whole), random)
    else:
        start = int(random.integers(len(of) - len(whole)))
        around = of[start : start + len(whole)]
    whole = whole + around * level * 10 ** (-db / 20)
    return bytes(np.clip(whole, -32768, 32767).astype("<i2").tobytes())


RUNNING = StatusView(run="r", mode="running", mission="patrol", missions=(MissionView("patrol"),))
PAUSED = RUNNING._replace(mode="paused")
IDLE = RUNNING._replace(run="", mode="")
VIEWS = {"resume": PAUSED, "start": IDLE}
"""In which state an order is spoken, where no mission runs."""


def effect(transcript: Transcript, view: StatusView, *, answers: bool = False) -> str:
    """What a transcript does, of one who may give each order: the order that counts or is read back, `yes` or `no`.

    Args:
        transcript: Of a turn.
        view: The run.
        answers: Whether an order was read back before, and waits for a yes or a no.

    Returns:
        With `?` where the robot asks for it again, or which of two orders is meant; empty for other talk.
    """
    dialogue = Dialogue(view=view)
    if answers:
        order = Utterance("cancel the mission", "operator", "voice", readings=("cancel",) * 2)
        for each in dialogue.on_utterance(order, view):
            if isinstance(each, Speech):
                dialogue.on_speech_end(SpeechEnd(each.key, "whole"))
    sentence = Utterance(transcript.text, "operator", "voice", readings=transcript.readings)
    for each in dialogue.on_utterance(sentence, view):
        if isinstance(each, Order):
            return "yes" if answers and each.confirmed else each.name
        if isinstance(each, TalkNote) and each.kind == "read_back":
            return str(each.data["order"]["order"])
        if isinstance(each, TalkNote) and each.kind == "void" and each.data["by"] == "no":
            return "no"
        if isinstance(each, TalkNote) and each.kind == "refused":
            return f"?{each.data['order']}"
    return "?" if transcript.text in PHRASES else ""


def order_of(phrase: str) -> str:
    """The order that a phrase is, or `yes` or `no`."""
    return {"wait": "pause", "continue": "resume"}.get(phrase, phrase.split()[0])


def orders(bench: Bench, scale: int) -> None:
    random, hits, counts, missed = np.random.default_rng(SEED), Counter[Any](), Counter[Any](), Counter[Any]()
    matrix = defaultdict[str, Counter[str]](Counter)
    for db, kind in product(LEVELS, NOISES):
        bench.new_ear()  # as in a room whose noise lasts: the ear has had time to know it
        for phrase, speaker, _ in product(SPOKEN, SPEAKERS, range(scale)):
            before_s = CROWD_BEFORE_S if kind == "babble" else 1.5
            sound = mixed(speech(f"{phrase.capitalize()}.", speaker), db, kind, random, before_s)
            found = bench.of(FileSound(sound))
            name = order_of(phrase)
            effects = [effect(each, VIEWS.get(name, RUNNING), answers=phrase in ("yes", "no")) for each in found]
            done = name if name in effects else next(filter(None, effects), "-")
            matrix[name][done] += 1
            key = ("stop" if phrase == "stop" else "other", db, kind)
            counts[key] += 1
            hits[key] += done == name
            if done != name:
                missed[f"{phrase}/{speaker}"] += 1
                print(f"    {phrase!r} by {speaker}, {db} dB {kind}: {done}", flush=True)
        for key in (("stop", db, kind), ("other", db, kind)):
            print(f"  {key[0]:6}{db} dB {kind:6} {hits[key]}/{counts[key]} = {hits[key] / counts[key]:.0%}", flush=True)
    for name, done_as in matrix.items():
        print(
            f"  {name:6} of {done_as.total()}:", ", ".join(f"{each} {count}" for each, count in done_as.most_common())
        )
    print("  missed most:", ", ".join(f"{name} {count}" for name, count in missed.most_common(12)))


def text_windows(count: int, random: np.random.Generator) -> Iterator[tuple[str, str]]:
    """Pieces of our own documents, read aloud."""
    words = READ_TEXT.read_text().split()
    for number in range(count):
        size = int(random.integers(1, 14))
        start = int(random.integers(0, len(words) - size))
        yield " ".join(words[start : start + size]), SPEAKERS[number % 4]


class Counts(NamedTuple):
    """Of windows of one kind that are no speech to the robot."""

    windows: int = 0
    turns: int = 0
    """With words, whatever they are."""
    phrases: int = 0
    """That the window does not have among its words."""
    read_back: int = 0
    ordered: int = 0
    """Without a confirmation."""

    def with_window(self, name: str, spoken: str, found: Iterable[Transcript]) -> Counts:
        """One window more; a phrase is printed, and all that is made of no words of a person."""
        counts = self._replace(windows=self.windows + 1)
        for each in found:
            given, back = consequences(each)
            is_phrase = each.text in PHRASES and not re.search(rf"\b{each.text}\b", plain_words(spoken))
            counts = Counts(
                counts.windows,
                counts.turns + 1,
                counts.phrases + is_phrase,
                counts.read_back + len(back) * is_phrase,
                counts.ordered + len(given) * is_phrase,
            )
            if is_phrase or not spoken:
                agree = each.readings.count(each.text)
                print(f"    {name} became {each.text!r} ({agree} agree): ordered {given}, read back {back}", flush=True)
        return counts


def consequences(transcript: Transcript) -> tuple[list[Any], list[Any]]:
    """What a transcript orders without a word more, and what is read back, while a mission runs; of one who may all."""
    sentence = Utterance(transcript.text, "operator", "voice", readings=transcript.readings)
    found = tuple(Dialogue(view=RUNNING).on_utterance(sentence, RUNNING))
    given = [each.name for each in found if isinstance(each, Order)]
    notes = [each for each in found if isinstance(each, TalkNote) and each.kind == "read_back"]
    return given, [each.data["order"]["order"] for each in notes]


def false_orders(bench: Bench, scale: int) -> None:
    """Read text, noise, and our own voice with reflections: a hundred windows, twenty and thirty times the scale."""
    counts, random, begun = defaultdict[str, Counts](Counts), np.random.default_rng(SEED + 1), time.monotonic()
    texts, own = tuple(text_windows(100 * scale, random)), tuple(text_windows(30 * scale, random))
    own = (*product(OWN, SPEAKERS), *own)
    rooms = tuple(product((-6.0, -12.0, -20.0), (20.0, 60.0, 120.0, 200.0)))
    for number in range(FIRST, min(LAST, 150 * scale)):
        random = np.random.default_rng((SEED, number))
        place, db, color = number - 120 * scale, (40, 20, 10)[number % 3], ("white", "pink")[number % 2]
        sound: FileSound | RoomSound
        if number < 100 * scale:
            kind, (text, speaker) = "read text", texts[number]
            name, sound = f"{db} dB {color}", FileSound(mixed(speech(text, speaker), db, color, random, 0.5))
        elif place < 0:
            kind, text, speaker, level = "noise", "", "none", (100, 400, 1600)[number % 3]
            loud = noise(color, 3 * RATE_HZ, random) * level
            name, sound = color, FileSound(bytes(loud.clip(-32768, 32767).astype("<i2").tobytes()))
        else:
            kind, (text, speaker), (echo_db, delay_ms) = "own voice", own[place], rooms[place // 5 % len(rooms)]
            if place % 5 == 0:
                bench.new_ear()  # a robot that begins in another room
            ours = bytes(speech(text, speaker).astype("<i2").tobytes())
            room = RoomSound(bytes(len(ours) + RATE_HZ), echo_db=echo_db, delay_ms=delay_ms, tail=tail(), seed=number)
            playing(room, ours)
            name, sound = f"{echo_db} dB, {delay_ms} ms", room
        spoken = "" if kind == "own voice" else text
        counts[kind] = counts[kind].with_window(f"{kind} {text!r} by {speaker}, {name}", spoken, bench.of(sound))
        if number % 50 == 49:
            print(f"  {number + 1} after {time.monotonic() - begun:.0f} s: {dict(counts)}", flush=True)
    for kind, each in counts.items():
        print(f"  {kind}: {each}")


def distance(one: list[str], other: list[str]) -> int:
    """Words to change, by Levenshtein."""
    row = list(range(len(other) + 1))
    for count, word in enumerate(one, 1):
        before, row = row, [count]
        for place, each in enumerate(other):
            row.append(min(before[place] + (word != each), before[place + 1] + 1, row[-1] + 1))
    return row[-1]


def words(bench: Bench, _: int) -> None:
    random = np.random.default_rng(SEED + 2)
    for db in (40, 20, 10):
        wrong, total, by = 0, 0, Counter[str]()
        for speaker in SPEAKERS:
            for text in SENTENCES:
                found = " ".join(
                    each.text for each in bench.of(FileSound(mixed(speech(text, speaker), db, "pink", random)))
                )
                errors = distance(plain_words(text).split(), plain_words(found).split())
                wrong, total = wrong + errors, total + len(plain_words(text).split())
                by[speaker] += errors
        print(f"  {db} dB pink: word errors {wrong / total:.1%} of {total}; by speaker {dict(by)}", flush=True)


class WakeLook:
    """What an ear makes of a stream for wake words: frame by frame, all of them on the same sound.

    In this process, and without the look for speech: it changes nothing of what a wake word is looked for in.
    """

    def __init__(self, names: Iterable[str]) -> None:
        self._canceller = EchoCanceller()
        self._words = {name: WakeWord(name) for name in names}

    def most(self, sound: bytes) -> dict[str, float]:
        """The highest probability of each word in the next sound, and in half a second of silence after it."""
        found = dict.fromkeys(self._words, 0.0)
        for start in range(0, len(sound) + RATE_HZ, FRAME_BYTES):
            frame = sound[start : start + FRAME_BYTES].ljust(FRAME_BYTES, b"\0")
            clear = self._canceller.take(frame, bytes(FRAME_BYTES))
            for name, word in self._words.items():
                found[name] = max(found[name], word.take(clear))
        return found


def spoken_word(name: str) -> str:
    """A wake word as a voice reads it."""
    return name.replace("_", " ").replace("nabu", "nah boo").capitalize()


def called(_: Bench, scale: int) -> None:
    """Orders in one breath with a wake word, and the word alone, which is no sentence."""
    random = np.random.default_rng(SEED + 7)
    for name in WORDS:
        bench = Bench(ListenNames(RECOGNISER, wake_word=name), here=HERE)
        for db in LEVELS:
            counts, alone = Counter[str](), list[str]()
            for phrase, speaker in (*product(("pause the mission", "cancel the mission"), SPEAKERS),) * scale:
                sound = mixed(speech(f"{spoken_word(name)}, {phrase}.", speaker), db, "pink", random)
                effects = [effect(each, RUNNING) for each in bench.of(FileSound(sound))]
                counts[next(filter(None, effects), "-")] += 1
                sound = mixed(speech(f"{spoken_word(name)}.", speaker), db, "pink", random)
                alone += [each.text for each in bench.of(FileSound(sound))]
            print(f"  {name}, {db} dB pink: {dict(counts)}; alone: {len(alone)} sentences {alone}", flush=True)
        bench.close()


def wake(_: Bench, scale: int) -> None:
    """Wake words that are spoken: alone, and with an order behind them."""
    random, look = np.random.default_rng(SEED + 3), WakeLook(WORDS)
    for name in WORDS:
        spoken = spoken_word(name)
        for behind in (".", ", pause the mission."):
            hits, by = Counter[str](), Counter[str]()
            cases = [(db, kind, speaker) for db in LEVELS for kind in ("white", "pink") for speaker in SPEAKERS] * scale
            most = list[float]()
            for db, kind, speaker in cases:
                most.append(look.most(mixed(speech(spoken + behind, speaker), db, kind, random))[name])
                hits[f"{db} dB"] += most[-1] >= WAKE_CUTOFF
                by[speaker] += most[-1] >= WAKE_CUTOFF
            print(
                f"  {spoken + behind!r}: {by.total()} of {len(cases)} recognised, {dict(hits)}, {dict(by)}; highest"
                f" probabilities {' '.join(f'{each:.2f}' for each in sorted(most))}",
                flush=True,
            )


def alarms(_: Bench, scale: int) -> None:
    """Wake words in `HOURS` of sound that has none; each `SEED` begins 10,000 words, about an hour, further."""
    random, look, begun = np.random.default_rng(SEED + 4), WakeLook(WORDS), time.process_time()
    passages, seconds, count = long_text(), 0.0, Counter[str]()
    minutes = {kind: noise(kind, 60 * RATE_HZ, random) for kind in ("white", "pink")}
    while seconds < HOURS * 3600:
        share, level = float(random.uniform()), float(random.choice((40, 20, 10)))
        kind = ("white", "pink")[int(random.integers(2))]
        if share < NOISE_SHARE:
            name = f"{kind} noise"
            sound = noise(kind, 8 * RATE_HZ, random) * float(random.choice((100, 400, 1600)))
            samples = bytes(sound.clip(-32768, 32767).astype("<i2").tobytes())
        elif share < NOISE_SHARE + MUSIC_SHARE:
            name = f"music at {level:.0f} dB"
            samples = mixed(music(random), level, kind, random, 0.2, of=minutes[kind])
        else:
            text, speaker = next(passages), SPEAKERS[int(random.integers(4))]
            name = f"{text!r} by {speaker} at {level:.0f} dB"
            samples = mixed(speech(text, speaker), level, kind, random, 0.2, of=minutes[kind])
        seconds += len(samples) / (2 * RATE_HZ) + 0.5
        for word, most in look.most(samples).items():
            count[word] += most >= WAKE_CUTOFF
            if most >= NEAR_ALARM:
                print(f"    {word} {most:.3f} {seconds / 3600:.3f} h: {name}", flush=True)
    print(
        f"  {seconds / 3600:.2f} h, {time.process_time() - begun:.0f} s of CPU without flite's; false alarms at "
        f"{WAKE_CUTOFF}: { {name: count[name] for name in WORDS} }"
    )


def long_text() -> Iterator[str]:
    """Passages of 8 to 30 words of our guide and of Python's reference, one after the other, from a seed's place on."""
    text = " ".join((READ_TEXT.read_text(), *(topics[name] for name in sorted(topics))))
    words = re.sub(r"[^A-Za-z0-9.,;:?!' ]+", " ", text).split()
    random, place = np.random.default_rng(SEED + 6), SEED * 10_000
    while True:
        size = int(random.integers(8, 31))
        yield " ".join(words[(place + each) % len(words)] for each in range(size))
        place += size


def music(random: np.random.Generator) -> np.ndarray:
    """Eight seconds of chords and a tune: tones with five partials that fade, as of strings that are struck."""
    found = np.zeros(8 * RATE_HZ)
    scale = 110.0 * 2 ** (np.array((0, 2, 4, 5, 7, 9, 11, 12, 14, 16, 17, 19)) / 12 + int(random.integers(12)) / 12)
    for beat in range(32):
        degree = int(random.integers(5))
        for place in (degree, degree + 2, degree + 4) if beat % 4 == 0 else (int(random.integers(5, 12)),):
            start, hz = beat * RATE_HZ // 4, scale[place] * (1 if beat % 4 == 0 else 2)
            at = np.arange(min(RATE_HZ, len(found) - start)) / RATE_HZ
            partials = sum(np.sin(2 * np.pi * hz * each * at) / each for each in range(1, 6))
            found[start : start + len(at)] += 1500 * partials * np.exp(-4 * at) * np.minimum(1, at / 0.005)
    return found


def playing(room: RoomSound, ours: bytes) -> None:
    pieces = iter(range(0, len(ours), FRAME_BYTES))
    room.play(lambda at: ours[start : start + FRAME_BYTES] if (start := next(pieces, None)) is not None else b"")


def tail() -> tuple[float, ...]:
    """The answer of a small room: 100 ms of reflections."""
    random, found = np.random.default_rng(5), np.zeros(1600)
    places = random.integers(50, 1600, 30)
    found[places] = random.normal(size=30) * np.exp(-places / 400) * 0.3
    return tuple(found)


def echo(bench: Bench, scale: int) -> None:
    for room_tail in ((), tail()):
        count, cuts, texts = 0, 0, list[str]()
        for db, delay in product((-6.0, -12.0, -20.0), (20.0, 60.0, 120.0, 200.0)):
            bench.new_ear()
            for number, text in enumerate(OWN * max(1, scale // 2)):
                ours = bytes(speech(text, SPEAKERS[number % 4]).astype("<i2").tobytes())
                room = RoomSound(bytes(len(ours) + RATE_HZ), echo_db=db, delay_ms=delay, tail=room_tail, seed=number)
                playing(room, ours)
                texts += [each.text for each in bench.of(room)]
                cuts += len(bench.present)
                count += 1
        print(
            f"  own voice, room {'with' if room_tail else 'without'} reflections: {count} reports, "
            f"{len(texts)} transcribed {texts}, {cuts} cut"
        )


BARGE_INS = ("Stop.", "What are you doing?", "Wait here until I come back.", "Cancel the mission.")


def barge(bench: Bench, scale: int) -> None:
    report = "I am driving to the kitchen. Four of six waypoints are done, and the battery is at sixty two percent."
    ours = bytes(speech(report, "slt").astype("<i2").tobytes())
    random = np.random.default_rng(SEED + 5)
    for db in (None, -20.0, -12.0, -6.0):
        bench.new_ear()
        delays, missed = list[float](), 0
        room = RoomSound(bytes(len(ours) + RATE_HZ), echo_db=db, delay_ms=60.0, tail=tail())
        playing(room, ours)
        bench.of(room)  # a report in which no one speaks: the canceller has learned the room
        for text, speaker in product(BARGE_INS, ("rms", "awb", "kal")):
            person = speech(text, speaker)
            onset = np.nonzero(np.abs(person) > 0.1 * np.abs(person).max())[0][0] / RATE_HZ
            at = float(random.uniform(0.3, 3.5))
            person = np.concatenate([np.zeros(int(at * RATE_HZ)), person]).astype("<i2")
            room = RoomSound(bytes(person.tobytes()) + bytes(RATE_HZ), echo_db=db, delay_ms=60.0, tail=tail())
            playing(room, ours)
            bench.of(room)
            early = [each for each in bench.present if each >= at]
            if early:
                delays.append(1000 * (early[0] - at - onset))
            else:
                missed += 1
        shown = f"p50 {statistics.median(delays):.0f}, p95 {np.percentile(delays, 95):.0f} ms" if delays else "none"
        print(f"  echo {db} dB: {len(delays)} of {len(delays) + missed} barge-ins known, after {shown}")


def delay(bench: Bench, scale: int) -> None:
    """End of speech → transcript, at the pace of the wall."""
    found = list[float]()
    for text in ("Stop.", *SENTENCES[: 5 * scale]):
        sound = speech(text, "slt")
        end = 0.6 + np.nonzero(np.abs(sound) > 200)[0][-1] / RATE_HZ
        recorded = bytes(
            np.concatenate([np.zeros(int(0.6 * RATE_HZ)), sound, np.zeros(RATE_HZ)]).astype("<i2").tobytes()
        )
        found.append(1000 * (arrival(bench, recorded) - end))
    p50, p95 = statistics.median(found), np.percentile(found, 95)
    print(f"  {len(found)} turns: p50 {p50:.0f}, p95 {p95:.0f}, stop {found[0]:.0f} ms")


def arrival(bench: Bench, recorded: bytes) -> float:
    """When the first transcript of a recording came, in seconds from its begin, at the pace of the wall."""
    file, arrived, begun = FileSound(recorded, paced=True), list[float](), list[float]()
    listener = SpeechListener(*bench.recognition.processes, on_transcript=lambda each: arrived.append(time.monotonic()))

    def take(frame: SoundFrame) -> None:
        if not begun:
            begun.append(time.monotonic() - FRAME_S)
        listener.take(frame)

    file.listen(take)
    file.start()
    while not file.over or not arrived:
        time.sleep(0.02)
    file.stop()
    return arrived[0] - begun[0]


SECTIONS: dict[str, Callable[[Bench, int], None]] = {
    "orders": orders,
    "false": false_orders,
    "words": words,
    "wake": wake,
    "called": called,
    "alarms": alarms,
    "echo": echo,
    "barge": barge,
    "delay": delay,
}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("sections", nargs="*", default=list(SECTIONS), help="which ones")
    parser.add_argument("--scale", type=int, default=1, help="how many of each; 10 for a thousand windows")
    given = parser.parse_args()
    bench = Bench(here=HERE)
    try:
        for name in given.sections:
            begun = time.monotonic()
            print(f"{name}:", flush=True)
            SECTIONS[name](bench, given.scale)
            print(f"  ({time.monotonic() - begun:.0f} s)", flush=True)
    finally:
        bench.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
