# SPDX-License-Identifier: Apache-2.0
"""What every connector to sound must do, as a function that its tests call."""

from __future__ import annotations

import statistics
from collections.abc import Callable
from itertools import pairwise

from rai_missions.connectors.sound.connector import FRAME_BYTES, FRAME_S, SoundConnector, SoundFrame
from rai_missions.errors import UsageError

__all__ = ("check_sound_connector",)

MARK = b"\x11\x22" * (FRAME_BYTES // 2)
JITTER_S = 0.5 * FRAME_S


def check_sound_connector(make: Callable[[], SoundConnector], pass_time: Callable[[SoundConnector, int], None]) -> None:
    """Hold a connector to the contract of `SoundConnector`.

    Args:
        make: Gives a fresh connector, not started.
        pass_time: Has at least so many frames pass.

    Raises:
        AssertionError: A promise is broken; the text states which.
    """
    for check in (_gives_frames_in_order, _plays_what_a_source_gives, _outlives_what_fails, _refuses_a_second_source):
        sound = make()
        sound.start()
        try:
            check(sound, pass_time)
        finally:
            sound.stop()
    _starts_and_stops_repeatedly(make(), pass_time)


PassTime = Callable[[SoundConnector, int], None]


def _gives_frames_in_order(sound: SoundConnector, pass_time: PassTime) -> None:
    frames: list[SoundFrame] = []
    close = sound.listen(frames.append)
    pass_time(sound, 5)
    assert not sound.fault, f"sound comes, so there is no fault: {sound.fault}"
    assert len(frames) >= 5, f"after 5 frames of time {len(frames)} were given"
    sizes = {len(frame.recorded) for frame in frames} | {len(frame.played) for frame in frames}
    assert sizes == {FRAME_BYTES}, f"a frame has {FRAME_BYTES} bytes each way, not {sorted(sizes)}"
    gaps = [after.at - before.at for before, after in pairwise(frames)]
    assert all(gap > 0 for gap in gaps), f"frames come in the order of their instants, not with gaps {gaps}"
    usual = statistics.median(gaps)  # a device that was opened again leaves a gap
    assert abs(usual - FRAME_S) < JITTER_S, f"frames come every {FRAME_S * 1000:g} ms, not every {usual * 1000:.1f}"
    close()
    close()
    count = len(frames)
    pass_time(sound, 2)
    assert len(frames) == count, "a closed listener is given nothing"


def _plays_what_a_source_gives(sound: SoundConnector, pass_time: PassTime) -> None:
    frames: list[SoundFrame] = []
    asked: list[float] = []

    def source(at: float) -> bytes:
        asked.append(at)
        return MARK if len(asked) <= 2 else (MARK[:100] if len(asked) == 3 else b"")

    sound.listen(frames.append)
    close = sound.play(source)
    pass_time(sound, 8)
    close()
    played = [frame.played for frame in frames if any(frame.played)]
    short = MARK[:100].ljust(FRAME_BYTES, b"\0")
    assert played == [MARK, MARK, short], "what a source gives is played once, in order, and what is missing is silence"
    assert asked == sorted(asked), "a source is asked for one instant after the other"
    count = len(asked)
    pass_time(sound, 3)
    assert len(asked) == count, "a closed source is asked for nothing"


def _outlives_what_fails(sound: SoundConnector, pass_time: PassTime) -> None:
    def fail(_: object) -> bytes:
        raise ValueError("no sound")

    def give_text(_: object) -> bytes:
        return "no sound"  # type: ignore[return-value]

    for source in (fail, give_text):
        frames: list[SoundFrame] = []
        close = sound.play(source)
        sound.listen(fail)
        sound.listen(frames.append)
        pass_time(sound, 3)
        close()
        assert len(frames) >= 3, "a source or a listener that fails takes nothing else along"
        assert not any(any(frame.played) for frame in frames), "a source that fails is silence"


def _refuses_a_second_source(sound: SoundConnector, _: PassTime) -> None:
    close = sound.play(lambda at: b"")
    try:
        sound.play(lambda at: b"")
    except UsageError:
        close()
        close()
        sound.play(lambda at: b"")()
        return
    raise AssertionError("a second source is refused")


def _starts_and_stops_repeatedly(sound: SoundConnector, pass_time: PassTime) -> None:
    frames: list[SoundFrame] = []
    sound.stop()
    sound.listen(frames.append)
    for _ in range(2):
        _runs(sound, expected=False)
        sound.start()
        sound.start()
        _runs(sound, expected=True)
        pass_time(sound, 2)
        sound.stop()
        sound.stop()
    count = len(frames)
    assert count >= 4, "frames come again after a second start"
    _runs(sound, expected=False)


def _runs(sound: SoundConnector, *, expected: bool) -> None:
    assert sound.running is expected, "what was started runs; what was not started, or was stopped, does not"
