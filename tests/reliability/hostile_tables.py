"""F2 and R4 (loading): the hostile tables and the real files, counted.

`python -m tests.reliability.hostile_tables --files 1000 --shard 1000 --resume DIR`
"""

from __future__ import annotations

from pathlib import Path

from mafsil.model import mjcf, urdf
from mafsil.model.diagnostics import Report
from tests.model.mjcf.hostile_models import CASES as MJCF_CASES
from tests.model.urdf.hostile_files import CASES as URDF_CASES
from tests.model.urdf.hostile_files import Case
from tests.model.urdf.real_files import all_files
from tests.reliability import figures

TABLE = (*((urdf, case) for case in URDF_CASES), *((mjcf, case) for case in MJCF_CASES))


def hostile(seed: int, count: int) -> dict[str, int]:
    """A slice of the tables: expected code, line, repair, verdict, both languages."""
    cases = TABLE[seed * count : (seed + 1) * count]
    bad = sum(not _as_expected(reader.diagnose(case.data), case) for reader, case in cases)
    return {"files": len(cases), "bad_files": bad}


def _as_expected(report: Report, case: Case) -> bool:
    found = [d for d in report if d.code == case.code]
    both = all(d.line_of_text("en") != d.line_of_text("ar") for d in report)
    if not found or report.ok != case.accepted or not both:
        return False
    return found[0].line == case.line and (found[0].repair is not None) == case.repair


def real(seed: int, count: int) -> dict[str, int]:
    """A slice of the real files: loaded, or a coded diagnostic with a place."""
    paths: list[Path] = all_files()[seed * count : (seed + 1) * count]
    reports = [urdf.diagnose(path) for path in paths]
    silent = sum(not r.ok and not any(d.line > 0 for d in r.errors) for r in reports)
    offered = sum(d.repair is not None for r in reports for d in r)
    loaded, remarks = sum(r.ok for r in reports), sum(len(r.diagnostics) for r in reports)
    return {
        "files": len(paths),
        "loaded": loaded,
        "diagnostics": remarks,
        "offered_repairs": offered,
        "bad_files": silent,
    }


if __name__ == "__main__":
    options = figures.arguments(__doc__ or "", "files", 1_000, 1_000)
    figures.run("F2", options, hostile)
    figures.run("R4", options, real)
