# SPDX-License-Identifier: Apache-2.0
"""How Fast DDS is set where the user has set nothing; each in a process of its own, which reads it once."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from rai_missions.connectors.ros2 import fastdds as middleware

VARIABLES = tuple(each.variable for each in (middleware.FAST_DDS_2, middleware.FAST_DDS_3))
EDITION = middleware.edition()
VARIABLE = EDITION.variable
ROOMY = 8_000_000
PROGRAM = """
import json, os, sys
from pathlib import Path
from rai_missions.connectors.ros2 import open_connector
connector = open_connector(json.loads(sys.argv[1]))
connector.start()
sizes = {}
for line in Path("/proc/self/maps").read_text().splitlines():
    place, *_, name = line.split()
    if "/dev/shm/fast" in name and "port" not in name:
        begin, end = (int(each, 16) for each in place.split("-"))
        sizes[name] = sizes.get(name, 0) + end - begin
print(json.dumps({"largest": max(sizes.values(), default=0), "file": os.environ.get(sys.argv[2])}))
connector.stop()
"""


def opened(folder: Path, options: dict[str, Any], **environment: str) -> tuple[dict[str, Any], str]:
    """What a process has of shared memory after its connector's start, and what it wrote to stderr."""
    given = {name: value for name, value in os.environ.items() if name not in VARIABLES}
    command = [sys.executable, "-W", "ignore", "-c", PROGRAM, json.dumps(options), VARIABLE]
    ended = subprocess.run(
        command, capture_output=True, text=True, timeout=120, check=True, cwd=folder, env={**given, **environment}
    )
    return json.loads(ended.stdout.splitlines()[-1]), ended.stderr


def test_a_process_with_pictures_has_shared_memory_for_several(ros: None, tmp_path: Path) -> None:
    reported, complaints = opened(tmp_path, {"pictures": True})
    assert reported["largest"] > ROOMY, "else a picture alone fills it, and a stop that comes behind is lost"
    assert reported["file"] is None, "no process that this one starts shall inherit it"
    assert "XMLPARSER" not in complaints


def test_a_process_without_pictures_takes_no_more_memory_than_ever(ros: None, tmp_path: Path) -> None:
    reported, complaints = opened(tmp_path, {})
    assert 0 < reported["largest"] < ROOMY and reported["file"] is None
    assert "XMLPARSER" not in complaints


def test_a_users_own_profile_stays(ros: None, tmp_path: Path) -> None:
    own = tmp_path / "own.xml"
    own.write_text("<profiles/>")
    reported, _ = opened(tmp_path, {"pictures": True}, **{VARIABLE: str(own)})
    assert reported["largest"] < ROOMY and reported["file"] == str(own)


def test_a_users_choice_of_transports_stays(ros: None, tmp_path: Path) -> None:
    reported, _ = opened(tmp_path, {"pictures": True}, FASTDDS_BUILTIN_TRANSPORTS="SHM")
    assert 0 < reported["largest"] < ROOMY


@pytest.mark.parametrize("is_roomy", [True, False])
def test_the_environment_is_as_before_whatever_happens(is_roomy: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    for each in VARIABLES:
        monkeypatch.delenv(each, raising=False)

    def fail() -> None:
        with middleware.carried(pictures=is_roomy):
            assert os.environ[VARIABLE] == str(EDITION.pictures if is_roomy else EDITION.prompt)
            raise RuntimeError

    with pytest.raises(RuntimeError):
        fail()
    assert VARIABLE not in os.environ


def test_a_file_in_the_folder_counts_as_the_users(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for each in VARIABLES:
        monkeypatch.delenv(each, raising=False)
    monkeypatch.chdir(tmp_path)
    (tmp_path / EDITION.default_file).write_text("<profiles/>")
    with middleware.carried(pictures=True):
        assert VARIABLE not in os.environ


@pytest.mark.parametrize("profile", [middleware.FAST_DDS_2.prompt, middleware.FAST_DDS_2.pictures])
def test_what_is_lost_is_sent_again_within_a_tenth_of_a_second(profile: Path) -> None:
    space = "{http://www.eprosima.com/XMLSchemas/fastRTPS_Profiles}"
    writers = ElementTree.parse(profile).getroot().findall(f"{space}publisher[@is_default_profile='true']")
    periods = [each.find(f"{space}times/{space}heartbeatPeriod") for each in writers]
    assert [(each[0].text, int(each[1].text or 0) <= 100_000_000) for each in periods if each is not None] == [
        ("0", True)
    ]


def test_the_profiles_of_both_generations_state_the_same() -> None:
    two, three = middleware.FAST_DDS_2, middleware.FAST_DDS_3
    for older, newer in ((two.prompt, three.prompt), (two.pictures, three.pictures)):
        assert newer.read_text().replace("heartbeat_period", "heartbeatPeriod") == older.read_text()


def test_the_generation_is_known_by_its_package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda _name: None)
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path))
    assert middleware.edition() == middleware.FAST_DDS_2
    (tmp_path / "share" / "fastdds").mkdir(parents=True)
    assert middleware.edition() == middleware.FAST_DDS_3
