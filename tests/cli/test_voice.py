# SPDX-License-Identifier: Apache-2.0
"""`rai-missions voice`: ears and a voice on ROS, in a process of their own. A whole run is in `tests/rosbot`."""

from __future__ import annotations

import pytest

from rai_missions.cli.main import main


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ([], "'rai-missions voice --ros' joins the ROS graph"),
        (["--ros", "--below", "alpha"], "'--below alpha' is no beginning of a topic's name; write it like '/alpha'"),
        (["--ros", "-o", "spoken.wav"], "leave -o out, or name a FILE"),
        (["--ros", "--language", "dee"], "no language 'dee'; did you mean 'de'?"),
        (["no.wav", "--ros"], "there is no file no.wav"),
        (["pyproject.toml", "--ros"], "pyproject.toml is no WAV file that can be read"),
    ],
)
def test_a_fault_of_the_input_is_one_sentence(
    words: list[str], sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["voice", *words]) == 2
    error = capsys.readouterr().err
    assert sentence in error
    assert error.startswith("rai-missions voice: ")
    assert len(error.strip().splitlines()) == 1
