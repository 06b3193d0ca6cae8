"""Writes docs/shell: the manual page and the completion scripts that the wheel puts where shells and `man` look.

python docs/make_shell_files.py          writes the files
python docs/make_shell_files.py --check  fails if a file is not what would be written
"""

from __future__ import annotations

import sys
from pathlib import Path

import mafsil as mf
from mafsil.cli.answer import Answer
from mafsil.cli.manual import completion, manual

FOLDER = Path(__file__).parent / "shell"


def main() -> int:
    """Write or check the files."""
    mf.language("en")
    answers = {"mafsil.1": manual(), "mafsil.bash": completion("bash"), "mafsil.fish": completion("fish")}
    texts = {FOLDER / name: _text(answer) for name, answer in answers.items()}
    if "--check" in sys.argv:
        return int(any(not file.exists() or file.read_text("utf-8") != text for file, text in texts.items()))
    FOLDER.mkdir(exist_ok=True)
    for file, text in texts.items():
        file.write_text(text, "utf-8")
    return 0


def _text(answer: Answer) -> str:
    return "\n".join(map(str, answer.lines)) + "\n"


if __name__ == "__main__":
    raise SystemExit(main())
