"""F3: one wrong argument in a valid call of 400 public functions, classes and methods: an answer, or an error in our
words.

`python -m tests.reliability.wrong_arguments [WORD]` prints every error that is not ours, of the calls with the word.
"""

from __future__ import annotations

import ast
import signal
import sys
import tempfile
import traceback
import warnings
from collections import Counter
from collections.abc import Iterator
from contextlib import chdir

import numpy as np

from mafsil.errors import MafsilError
from tests.reliability import decade_calls, method_calls
from tests.reliability.decades import TooLong

CALLS = decade_calls.CALLS + method_calls.CALLS
SECONDS = 6.0
"""That one call may take."""
WRONG: dict[str, object] = {
    "None": None,
    "a text": "x",
    "no text": "",
    "an object": object(),
    "an empty list": [],
    "too deep": [[[1.0]]],
    "NaN": float("nan"),
    "complex": 1j,
    "beyond all": 10**400,
    "a dict": {},
    "a function of nothing": lambda: 0,
    "no rows": np.zeros((0, 3)),
    "an array of texts": np.array(["a", "b"]),
    "True": True,
    "a set": {1},
    "bytes": b"x",
    "negative": -1,
    "a small number": 3,
    "ragged": [[1.0], [1.0, 2.0]],
    "a class": int,
    "seven numbers": (1, 2, 3, 4, 5, 6, 7),
}


def with_one_wrong(call: str) -> Iterator[tuple[str, object]]:
    """The call with each of its arguments replaced by the name `_wrong`, and with one of an unknown name.

    Args:
        call: its text.
    """
    whole = ast.parse(call, mode="eval").body
    assert isinstance(whole, ast.Call)
    if isinstance(whole.func, ast.Call):
        return  # What a public function gives back is called: no public name.
    for k in range(len(whole.args) + len(whole.keywords) + 1):
        tree = ast.parse(call, mode="eval")
        made, name = tree.body, ast.Name("_wrong", ast.Load())
        assert isinstance(made, ast.Call)
        if k < len(made.args):
            made.args[k], argument = name, str(k)
        elif k < len(made.args) + len(made.keywords):
            keyword = made.keywords[k - len(made.args)]
            keyword.value, argument = name, str(keyword.arg)
        else:
            made.keywords.append(ast.keyword("no_such_argument", name))
            argument = "no_such_argument"
        yield argument, compile(ast.fix_missing_locations(tree), call, "eval")


def work(calls: tuple[str, ...] = CALLS) -> tuple[Counter[str], list[str]]:
    """How the calls ended, and those that ended in an error of others."""
    counts, foreign = Counter[str](), list[str]()
    before = signal.signal(signal.SIGALRM, _stop)
    with tempfile.TemporaryDirectory() as folder, chdir(folder), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        names = method_calls.space(folder)
        for call in calls:
            if _end(compile(call, call, "eval"), dict(names)) != "answered":
                foreign.append(f"{call}: wrong as it stands")
            for argument, code in with_one_wrong(call):
                for kind, value in WRONG.items():
                    end = _end(code, names | {"_wrong": value})
                    counts[end if end in ("answered", "ours", "late") else "foreign"] += 1
                    if end not in ("answered", "ours"):
                        foreign.append(f"{call.partition('(')[0]}({argument}={kind}): {end}")
    signal.signal(signal.SIGALRM, before)
    return counts, foreign


def _end(code: object, names: dict[str, object]) -> str:
    signal.setitimer(signal.ITIMER_REAL, SECONDS)
    try:
        eval(code, names)  # type: ignore[arg-type]
    except MafsilError:
        return "ours"
    except TooLong:
        return "late"
    except Exception as error:
        place = traceback.extract_tb(error.__traceback__)[-1]
        return f"{type(error).__name__}: {error} at {place.filename.rpartition('/')[2]}:{place.lineno}"
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
    return "answered"


def _stop(*_: object) -> None:
    raise TooLong


if __name__ == "__main__":
    chosen = tuple(call for call in CALLS if all(word in call for word in sys.argv[1:]))
    found, bad = work(chosen)
    print(dict(found), *bad, sep="\n")
