# SPDX-License-Identifier: Apache-2.0
"""A mission in Python is a file loaded by path; what goes wrong in it is reported with its line."""

from __future__ import annotations

from pathlib import Path

import pytest

from rai_missions import DefinitionError, UsageError, load

DATA = Path(__file__).parents[1] / "data"
GOOD = """
from rai_missions import Mission
from rai_missions.states import State

def mission() -> Mission:
    return Mission("small", initial="a", states={"a": State()})
"""


def fault_of(tmp_path: Path, text: str | bytes) -> str:
    file = tmp_path / "m.py"
    file.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(DefinitionError) as refused:
        load(file)
    assert refused.value.source == str(file)
    return "\n".join(str(fault) for fault in refused.value.faults)


def test_a_file_offers_a_mission_and_nothing_is_written_next_to_it(tmp_path: Path) -> None:
    (tmp_path / "m.py").write_text(GOOD)
    assert load(tmp_path / "m.py").name == "small"
    assert [each.name for each in tmp_path.iterdir()] == ["m.py"]


def test_a_changed_file_is_read_again(tmp_path: Path) -> None:
    (tmp_path / "m.py").write_text(GOOD)
    load(tmp_path / "m.py")
    (tmp_path / "m.py").write_text(GOOD.replace("small", "large"))
    assert load(tmp_path / "m.py").name == "large"


def test_a_mission_that_is_no_function_is_taken_as_well(tmp_path: Path) -> None:
    (tmp_path / "m.py").write_text(f"{GOOD}\nmission = mission()\n")
    assert load(tmp_path / "m.py").name == "small"


def test_python_is_refused_unexecuted_where_it_is_not_wanted(tmp_path: Path) -> None:
    (tmp_path / "m.py").write_text("raise SystemExit('executed')")
    with pytest.raises(UsageError, match="is Python, which is not to be executed here"):
        load(tmp_path / "m.py", python=False)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("x = 1\ndef f(:\n", "/: line 2: not Python: invalid syntax"),
        (b"\xff\xfe", "/: line 1: not Python: "),  # in words of Python's own, which differ from 3.14 on
        (b"x = 1\0", "/: line 1: not Python: source code "),
        ("x = 1\n\nx = {}['a']\n", "/: line 3: KeyError: 'a'"),
        ("import sys\nsys.exit(3)", "/: line 2: SystemExit: 3"),
        ("x = 1", "/: the file has no 'mission'; write `mission = Mission(…)` or `def mission() -> Mission:`"),
        ("mission = 3", "/: 'mission' is '3'; it is to be a Mission, or a function of it"),
        ("def mission():\n    return 3", "/: mission() returned '3'; return a Mission"),
        (
            "async def mission():\n    return 3",
            "/: mission() is an async function, and nothing awaits it; write `def`",
        ),
        ("def f():\n    raise ValueError\ndef mission():\n    f()", "/: line 2: ValueError"),
        ("def mission():\n    return mission()", "/: line 2: RecursionError"),
        (
            GOOD.replace('"a": State()', '"a": State(timout_s=1)'),
            "/timout_s: line 6: in State(…): a state has no 'timout_s'; did you mean 'timeout_s'?",
        ),
        (
            "from rai_missions import Key, Keys\nk = Keys(battery=Key(float))\nlow = k.batery < 1",
            "/: line 3: AttributeError: no key 'batery'; did you mean 'battery'?",
        ),
    ],
)
def test_what_goes_wrong_is_reported_with_its_line(tmp_path: Path, text: str | bytes, sentence: str) -> None:
    assert fault_of(tmp_path, text).startswith(sentence)


def test_a_file_may_define_dataclasses_and_be_called_anything(tmp_path: Path) -> None:
    extra = "from __future__ import annotations\nimport dataclasses\n@dataclasses.dataclass\nclass A:\n    b: int\n"
    (tmp_path / "my mission-2.py").write_text(extra + GOOD)
    assert load(tmp_path / "my mission-2.py").name == "small"


def test_the_twin_of_the_guides_tractor_equals_its_json() -> None:
    assert load(DATA / "tractor_design.py") == load(DATA / "tractor_design.json")


IMPORTS = {
    "from rai_missions import Mission, Action": "; it is in rai_missions.states",
    "from rai_missions import (\n    Mision,\n)": "; did you mean 'Mission'?",
    "from rai_missions.states import Sequence": "; it is in rai_missions.states.tree",
    "from os import rai_missions": "'os'",
}


@pytest.mark.parametrize("text", IMPORTS)
def test_a_name_that_a_package_of_ours_lacks_is_reported_with_the_place_where_it_is(tmp_path: Path, text: str) -> None:
    path = tmp_path / "m.py"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(DefinitionError) as caught:
        load(path)
    assert "ImportError" in str(caught.value) and IMPORTS[text] in str(caught.value)
    assert ("; " in str(caught.value)) == IMPORTS[text].startswith("; ")
