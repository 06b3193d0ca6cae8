"""No module needs itself through others, imports for type checkers and late ones counted."""

from tests.house.import_graph import circles, import_graph


def test_no_circle_of_imports() -> None:
    assert circles(import_graph()) == []


def test_late_names_and_public_names_count() -> None:
    """`collision.Checker` of `from mafsil import collision`, a name from a face, `lazily`: each needs its module."""
    graph = import_graph()
    assert "mafsil.collision.checker" in graph["mafsil.planning.arm_planning"]
    assert "mafsil.planning.roadmap" in graph["mafsil.planning.arm_planning"]
    assert "mafsil.model.mechanism" in graph["mafsil.robot.loading"]
