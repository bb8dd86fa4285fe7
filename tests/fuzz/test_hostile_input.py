# SPDX-License-Identifier: Apache-2.0
"""Whatever is opened, checked, drawn or replayed: it is taken, or refused in a sentence, soon and in little memory."""

from __future__ import annotations

import json
import random
import resource
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.fuzz.hostile import MAKERS, made
from tests.fuzz.mutator import mutated
from tests.fuzz.seeds import seeds
from tests.fuzz.targets import TARGETS, fed

HOSTILE = [(target, name) for target in MAKERS for name in made(target)]
FILES = {"mission": "mission.json", "journal": "run.journal", "recording": "run.mcap"}
MOST_BYTES = 4 * 2**30
"""Of address space, for a command: MuJoCo and others are not loaded, and whatever is read is read in parts."""
MOST_CHARACTERS = 300_000
"""Of what is printed: a thousand faults of a line or two."""


@pytest.mark.parametrize(("target", "name"), HOSTILE, ids=[f"{target}: {name}" for target, name in HOSTILE])
def test_hostile_input_is_refused_in_a_sentence_or_is_none(target: str, name: str, tmp_path: Path) -> None:
    assert len(fed(target, made(target)[name], tmp_path)) < MOST_CHARACTERS


@pytest.mark.parametrize("target", TARGETS)
def test_good_input_is_taken(target: str, tmp_path: Path) -> None:
    assert fed(target, next(seeds(target)), tmp_path) == ""


@pytest.mark.parametrize("target", ["mission", "profile", "rows"])
@given(seed=st.integers(0, 2**32))
def test_a_changed_mission_profile_or_journal_is_taken_or_refused(
    tmp_path_factory: pytest.TempPathFactory, target: str, seed: int
) -> None:
    source = random.Random(seed)
    value = json.loads(source.choice(list(seeds(target))))
    data = json.dumps(mutated(value, source)).encode("utf-8", "surrogatepass")
    fed(target, data, tmp_path_factory.mktemp("fed"))


@pytest.mark.parametrize("target", ["journal", "recording", "identity"])
@given(changes=st.lists(st.tuples(st.integers(0, 2**20), st.binary(min_size=1, max_size=8)), min_size=1, max_size=4))
def test_changed_bytes_are_taken_or_refused(
    tmp_path_factory: pytest.TempPathFactory, target: str, changes: list[tuple[int, bytes]]
) -> None:
    data = bytearray(next(seeds(target)))
    for at, other in changes:
        place = at % len(data)
        data[place : place + len(other)] = other
    fed(target, bytes(data), tmp_path_factory.mktemp("fed"))


def limited() -> None:
    resource.setrlimit(resource.RLIMIT_AS, (MOST_BYTES, MOST_BYTES))


@pytest.mark.parametrize("target", FILES)
def test_a_command_reports_what_is_wrong_without_a_traceback_and_in_bounded_memory(target: str, tmp_path: Path) -> None:
    """One process for all of them: starting one is what takes its time."""
    paths = []
    for number, data in enumerate(made(target).values()):
        folder = tmp_path / str(number)
        folder.mkdir()
        (folder / FILES[target]).write_bytes(data)
        paths.append(str(folder / FILES[target]))
    command = {"mission": "check"}.get(target, "replay")
    program = f"import sys; from rai_missions.cli.main import main; print([main([{command!r}, each]) for each in sys.argv[1:]])"  # noqa: E501
    done = subprocess.run(
        [sys.executable, "-c", program, *paths],
        capture_output=True,
        text=True,
        timeout=120,
        preexec_fn=limited,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-2000:]
    assert "Traceback" not in done.stderr
    assert set(json.loads(done.stdout.splitlines()[-1])) <= {0, 1, 2}
