# SPDX-License-Identifier: Apache-2.0
"""The doctor reports a message package that is there twice."""

from __future__ import annotations

import os
from pathlib import Path

from rai_missions.cli.doctor.interfaces import copies


def prefix(folder: Path, package: str, **messages: str) -> Path:
    (folder / "share" / package / "msg").mkdir(parents=True)
    (folder / "share" / package / "package.xml").touch()
    for name, text in messages.items():
        (folder / "share" / package / "msg" / f"{name}.msg").write_text(text, encoding="utf-8")
    return folder.resolve()


def test_a_package_that_is_there_once_is_not_named(tmp_path: Path) -> None:
    home = prefix(tmp_path / "a", "rai_interfaces", HRIMessage="string text")
    assert list(copies({}, home)) == []
    assert list(copies({"AMENT_PREFIX_PATH": str(home)}, home)) == [], "its own prefix is no other place"


def test_two_copies_that_agree_are_named_and_no_fault(tmp_path: Path) -> None:
    one = prefix(tmp_path / "a", "rai_interfaces", HRIMessage="# theirs\n\nstring  text # words", Other="int8 x")
    two = prefix(tmp_path / "b", "rai_interfaces", HRIMessage="string text")
    (found,) = copies({"AMENT_PREFIX_PATH": str(one)}, two)
    assert str(found) == f"ok      rai_interfaces is there 2 times: {one}, {two}; what they share is the same"


def test_two_copies_that_differ_are_a_fault_with_its_remedy(tmp_path: Path) -> None:
    one = prefix(tmp_path / "a", "rai_interfaces", HRIMessage="string text")
    two = prefix(tmp_path / "b", "rai_interfaces", HRIMessage="string text\nstring role")
    home = prefix(tmp_path / "c", "tf2_msgs")
    (found,) = copies({"AMENT_PREFIX_PATH": os.pathsep.join(map(str, (one, two)))}, home)
    assert found.status == "missing"
    assert found.what == f"rai_interfaces is there 2 times: {one}, {two}, and their messages differ"
    assert found.remedy.startswith("keep one; share/rai_missions_interfaces/rai_interfaces.files lists")
