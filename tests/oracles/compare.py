"""Worst error of every quantity of every robot against Pinocchio and MuJoCo.

python -m tests.oracles.compare --states 10000                 all robots, the table, figures as JSON
python -m tests.oracles.compare --robots panda urdf:pr2        some
python -m tests.oracles.compare --shard 1/2 --resume           every second robot, those with figures left out

One JSON file per robot lands in the output folder as soon as the robot is done. Exit status 1 beyond the limit.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from mafsil.robot import Robot
from tests.oracles import ours, subjects
from tests.oracles.comparison import RAW, Table, compared, oracles_of, states_of

LIMIT = 1e-10


def main(arguments: Sequence[str] | None = None) -> int:
    options = _parsed(arguments)
    options.output.mkdir(parents=True, exist_ok=True)
    records = list(_records(options))
    for line in table_text(records):
        print(line)
    beyond = [record["robot"] for record in records if record["worst"] > LIMIT]
    print(
        f"{len(records)} robots, worst {max((record['worst'] for record in records), default=0.0):.1e}, limit {LIMIT:g}"
    )
    if beyond:
        print(f"beyond the limit: {', '.join(beyond)}")
    return 1 if beyond or not records else 0


def _records(options: argparse.Namespace) -> Iterator[dict[str, Any]]:
    index, count = (int(part) for part in options.shard.split("/"))
    for name in options.robots[index - 1 :: count]:
        place = options.output / f"{name.replace(':', '-')}.json"
        wanted = {"robot": name, "states": options.states, "seed": options.seed, "method": options.method}
        if options.resume and place.exists():
            record = json.loads(place.read_text())
            if all(record.get(key) == value for key, value in wanted.items()):
                yield record
                continue
        record = wanted | measured(name, options.states, options.seed, options.method)
        place.write_text(json.dumps(record, indent=1))
        print(f"{name}: worst {record['worst']:.1e}", file=sys.stderr, flush=True)
        yield record


def measured(name: str, states: int, seed: int, method: str) -> dict[str, Any]:
    """Figures of one robot."""
    mechanism = subjects.mechanism(name)
    evaluate = partial(ours.compiled, Robot(mechanism)) if method == "compiled" else partial(ours.traced, mechanism)
    table, seconds = compared(mechanism, oracles_of(name, mechanism), evaluate, states_of(mechanism, states, seed))
    return {"joints": mechanism.n, "worst": worst(table), "errors": _plain(table), "seconds": seconds}


def worst(table: Table) -> float:
    """Largest error of all that is judged."""
    return max(errors.worst for row in table.values() for name, errors in row.items() if name != RAW)


def table_text(records: Sequence[dict[str, Any]]) -> Iterator[str]:
    """One line per robot and oracle, one column per quantity: the worst error."""
    quantities = [
        name for name in (*ours.ALL, RAW) if any(name in row for r in records for row in r["errors"].values())
    ]
    for k, name in enumerate(quantities):
        yield f"{_letter(k)} {name}"
    yield f"{'robot':24}{'n':>4} {'oracle':20}" + "".join(f"{_letter(k):>8}" for k in range(len(quantities)))
    for record in records:
        for oracle, row in record["errors"].items():
            cells = "".join(f"{row[name]['worst']:8.0e}" if name in row else f"{'':8}" for name in quantities)
            yield f"{record['robot']:24}{record['joints']:4} {oracle:20}{cells}"


def _letter(k: int) -> str:
    return chr(ord("a") + k)


def _plain(table: Table) -> dict[str, dict[str, dict[str, float]]]:
    return {
        oracle: {name: {"worst": e.worst, "median": e.median, "state": e.state} for name, e in row.items()}
        for oracle, row in table.items()
    }


def _parsed(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m tests.oracles.compare", description=__doc__)
    parser.add_argument("--states", type=int, default=10_000)
    parser.add_argument(
        "--robots", nargs="+", default=list(subjects.names()), choices=subjects.names(), metavar="ROBOT"
    )
    parser.add_argument("--method", choices=("compiled", "traced"), default="compiled")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--shard", default="1/1", help="k/N: every N-th robot, beginning with the k-th")
    parser.add_argument("--resume", action="store_true", help="leave out robots whose figures are there")
    parser.add_argument("--output", type=Path, default=Path("build/oracles"))
    return parser.parse_args(arguments)


if __name__ == "__main__":
    sys.exit(main())
