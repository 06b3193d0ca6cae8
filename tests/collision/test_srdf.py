"""SRDF files: misspelt words are said, what tinyxml2 takes is read, special files are refused at once."""

from __future__ import annotations

import os
import warnings
from pathlib import Path

import pytest

from mafsil.collision.srdf import disabled_pairs, read
from mafsil.errors import FileError, ModelWarning

PAIR = '<disable_collisions link1="a" link2="b" reason="Never"/>'


def test_misspelt_words_are_said(tmp_path: Path) -> None:
    path = tmp_path / "arm.srdf"
    for text, word in (
        (PAIR.replace("link2", "lnik2"), "link2"),
        (PAIR.replace("disable_collisions", "disable_colisions"), "disable_collisions"),
        ("<group name='g'><chian base_link='a' tip_link='b'/></group>", "chain"),
        ("<group_state name='h' group='g'><joint name='j' vlaue='1'/></group_state>", "value"),
    ):
        path.write_text(f"<robot name='r'>{text}</robot>")
        with pytest.warns(ModelWarning, match=word):
            read(path)
    path.write_text(f"<!-- a -- b --><robot name='r'>{PAIR}</robot>")
    with pytest.warns(ModelWarning, match="hyphen"):
        assert disabled_pairs(path) == {frozenset("ab"): "Never"}


def test_sound_files_say_nothing(tmp_path: Path) -> None:
    path = tmp_path / "arm.srdf"
    extras = "<virtual_joint name='v' type='fixed' parent_frame='w' child_link='a'/><passive_joint name='p'/>"
    path.write_text(f"<?xml version='1.0'?><robot name='r'>{PAIR}{extras}</robot>")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert len(disabled_pairs(path)) == 1


def test_special_and_damaged_files_are_refused(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.srdf")
    (tmp_path / "cut.srdf").write_text("<robot><group")
    (tmp_path / "code.srdf").write_text('<?xml version="1.0" encoding="foo"?><robot>\x00')
    for name in ("pipe.srdf", "none.srdf", "cut.srdf", "code.srdf", "."):
        with pytest.raises(FileError):
            disabled_pairs(tmp_path / name)
