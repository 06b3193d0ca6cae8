"""C sources: they compile without a warning and give the numbers of the kernel, whatever the robot is called."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil.errors import FileError, InputError
from mafsil.kernels import tape
from mafsil.kernels.export import Legend
from mafsil.kernels.export.c_source import header, literal, program, source
from mafsil.kernels.export.exported import STRICT, Export, compiler, export, trial
from mafsil.kernels.export.legend import Vectors, harmless, identifier, symbol, vectors
from mafsil.kernels.kernel import compile as compile_kernel
from mafsil.kernels.layout import Port, Signature

CC = compiler()
needs_compiler = pytest.mark.skipif(CC is None, reason="no C compiler")
HOSTILE = [
    "ذراع */ int x; /*",
    'a"b\\',
    "a\n#error\n",
    "??/",
    "\u202eevil\u202c",
    "int",
    "9lives",
    "",
    "x" * 300,
    "😀*/",
]


def renamed(name: str) -> mf.Robot:
    from dataclasses import replace

    return mf.Robot(replace(mf.load("planar2r").mechanism, name=name))


@needs_compiler
@pytest.mark.parametrize("real", ["double", "float"])
@pytest.mark.parametrize(
    ("robot", "quantity"),
    [
        ("planar2r", "potential_energy"),
        ("panda", "inverse_dynamics"),
        ("puma560", "forward_dynamics"),
        ("ur5e", "jacobian_body_rate"),
        ("scara_rrrp", "link_wrenches"),
    ],
)
def test_compiles_without_a_warning_and_agrees(robot: str, quantity: str, real: str) -> None:
    assert CC
    found = trial(mf.export(mf.load(robot), quantity, real=real), CC)
    assert found.ok, found.said
    assert re.fullmatch(rf"ok \w+_{quantity}: 8 rows, worst \S+ units in the last place", found.said)


@needs_compiler
def test_optional_inputs_and_frames() -> None:
    assert CC
    robot = mf.load("panda")
    loaded = robot.export("inverse_dynamics", optional=("tip_wrench",))
    assert "tip_wrench[6]: wrench (m, f) the tip exerts on the world" in loaded.files[f"{loaded.name}.h"].decode()
    framed = robot.export("forward_kinematics", frame=robot.mechanism.link_names[4], function="fk_4")
    assert set(framed.files) == {"fk_4.h", "fk_4.c", "fk_4_test.c"}
    assert trial(loaded, CC).ok
    assert trial(framed, CC).ok


@needs_compiler
@pytest.mark.parametrize("name", HOSTILE)
def test_no_name_harms(name: str) -> None:
    assert CC
    found = renamed(name or "-").export("forward_kinematics")
    assert re.fullmatch(r"[a-z][a-z0-9_]*", found.name)
    text = b"".join(found.files.values()).decode()
    header_text = found.files[f"{found.name}.h"].decode()
    assert header_text.count("/*") == header_text.count("*/") == 2
    assert not re.search("[\u202a-\u202e\\\\]", re.sub(r'\\n"', "", text))
    assert trial(found, CC, (*STRICT, "-Wcomment", "-Wtrigraphs")).ok


def test_arabic_names_stay_readable_in_comments_and_differ_as_symbols() -> None:
    assert harmless("ذراع ٣ */") == "ذراع ٣ __".replace("__", "_/") or "*/" not in harmless("ذراع ٣ */")
    assert "ذراع" in harmless("ذراع")
    assert identifier("ذراع") != identifier("يد")
    assert identifier("KUKA LBR-iiwa 7") == "kuka_lbr_iiwa_7"
    assert len(identifier("x" * 300)) < 32


@pytest.mark.parametrize("name", ["int", "1a", "a b", "a-b", "", "_x", "main", "é"])
def test_names_that_c_refuses(name: str) -> None:
    with pytest.raises(InputError, match="no name for a C function"):
        symbol("panda", "mass_matrix", name)


def kitchen() -> tuple[Signature, object]:
    """One function with every operation of a tape."""
    import mafsil.expression as ex

    x, y = ex.symbol("x", 3), ex.symbol("unused", 2)
    a, b, c = x[0], x[1], x[2]
    values = [
        ex.sin(a), ex.cos(a), ex.tan(a), ex.asin(a / 4), ex.acos(b / 4), ex.atan(c), ex.atan2(a, b), ex.exp(a),
        ex.log(1 + a * a), ex.sqrt(1 + b * b), ex.floor(a * 3.3), ex.ceil(a * 3.3), ex.fabs(b), ex.sign(b),
        ex.fmin(a, b), ex.fmax(a, b), ex.tanh(c),
        (1 + a * a) ** 1.5, ex.copysign(a, b), a / (1 + b * b), -a, ex.if_else(a < b, a, c),
        ex.if_else(ex.logic_and(a <= b, ex.unequal(b, c)), a, 0), a < b,
        ex.if_else(ex.logic_or(ex.equal(a, b), ex.logic_not(c)), 1, 2),
        1e300, float("inf"), -float("inf"), float("nan"), a, 2 * a * b - c, c - a * b,
        -(a * b) - c,
    ]  # fmt: skip
    signature = Signature("kitchen", (Port("double", (3,)), Port("t1", (2,))), (Port("double", (len(values),)),))
    return signature, ex.Function("kitchen", [x, y], [ex.vertcat(*values)])


@needs_compiler
@pytest.mark.parametrize("to", ["c", "object"])
def test_every_operation(to: str) -> None:
    assert CC
    signature, function = kitchen()
    kernel = compile_kernel(signature, lambda: function, key="kitchen")
    found = trial(export(kernel, Legend("*/", "everything"), to), CC, STRICT if to == "c" else ("-std=c99",))
    assert found.ok, found.said


@needs_compiler
def test_the_proof_notices_a_wrong_number() -> None:
    assert CC
    found = mf.load("planar2r").export("mass_matrix")
    code = found.files[f"{found.name}.c"].decode()
    broken = re.sub(r"(mass_matrix\[0\] = \w+)", r"\1 * 1.0000000001", code)
    assert broken != code
    bad = Export(found.name, {**found.files, f"{found.name}.c": broken.encode()})
    result = trial(bad, CC)
    assert not result.ok
    assert "instead of" in result.said
    nothing = trial(Export(found.name, {**found.files, f"{found.name}.c": b"int x"}), CC)
    assert not nothing.ok


@needs_compiler
def test_outputs_may_overwrite_inputs(tmp_path: Path) -> None:
    assert CC
    robot = mf.load("planar2r")
    found = robot.export("gravity_torque")
    found.write(tmp_path)
    main = f'#include "{found.name}.h"\n#include <stdio.h>\nint main(void) {{ double x[2] = {{0.3, -0.7}}; '
    (tmp_path / "over.c").write_text(main + f'{found.name}(x, x); printf("%.17g %.17g", x[0], x[1]); return 0; }}')
    subprocess.run([CC, "-O2", "over.c", f"{found.name}.c", "-o", "over", "-lm"], cwd=tmp_path, check=True)
    answer = subprocess.run([str(tmp_path / "over")], capture_output=True, check=True, text=True).stdout
    assert np.allclose([float(x) for x in answer.split()], robot.gravity_torque([0.3, -0.7]), rtol=1e-14)


def test_text_without_a_compiler() -> None:
    """What can be said of the sources by reading them."""
    signature, function = kitchen()
    found = tape.read(function)
    code = source(found, signature, "kitchen", "double")
    assert not re.search(r"\b(malloc|free|for|while|goto)\b", code)
    assert code.count("{") == code.count("}") == 1
    declared = re.findall(r"const double (t\d+) =", code)
    assert len(declared) == len(set(declared))
    assert "(void)t1_;" in code
    assert "double_out[0] = " in code
    assert "void kitchen(const double double_[3], const double t1_[2], double double_out[" in header(
        signature, Legend("a", "b"), "kitchen", "double"
    )


@pytest.mark.parametrize("value", [0.1, -0.0, 1e300, 5e-324, 1.0, -3.0, 1e22, 123456789.0])
def test_literals_keep_every_bit(value: float) -> None:
    text = literal(value, "double").strip("()")
    assert np.float64(text).tobytes() == np.float64(value).tobytes()
    assert "." in text or "e" in text
    single = literal(value, "float").strip("()")
    if value != 1e300:
        assert np.float32(single.removesuffix("f")) == np.float32(value)
    else:
        assert "INFINITY" in single


def test_vectors_are_the_kernels() -> None:
    robot = mf.load("scara_rrrp")
    kernel = robot.kernel("inverse_dynamics")
    stored = vectors(kernel.evaluate, tape.read(kernel.build()), kernel.signature, single=True)
    assert isinstance(stored, Vectors)
    assert np.array_equal(stored.outputs[0], robot.inverse_dynamics(*stored.inputs))
    assert all((x == x.astype(np.float32)).all() for x in stored.inputs)
    assert not stored.inputs[0][0].any()
    assert (stored.units[0] > 0).all()
    assert "int main(void)" in program(kernel.signature, "f", "float", stored)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"to": "rust"}, "choose one of c, object, ptx"),
        ({"real": "half"}, "does not go with"),
        ({"to": "object", "real": "float"}, "does not go with"),
        ({"to": "c", "target": "aarch64"}, "leave it out"),
        ({"to": "object", "target": "z80"}, "cortex-m7"),
        ({"to": "ptx", "target": "sm_1"}, "sm_90"),
        ({"function": "for"}, "no name for a C function"),
    ],
)
def test_wrong_wishes_are_refused(arguments: dict[str, str], sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        mf.load("planar2r").export("mass_matrix", **arguments)  # type: ignore[arg-type]


def test_files_appear_whole_or_not_at_all(tmp_path: Path) -> None:
    found = mf.load("planar2r").export("mass_matrix")
    paths = found.write(tmp_path / "new" / "folder")
    assert sorted(path.name for path in paths) == sorted(found.files)
    assert sorted(path.name for path in (tmp_path / "new" / "folder").iterdir()) == sorted(found.files)
    (tmp_path / "file").write_text("")
    with pytest.raises(FileError, match="cannot be written"):
        found.write(tmp_path / "file")


def test_command(tmp_path: Path) -> None:
    words = [sys.executable, "-m", "mafsil.cli", "export", "planar2r", "mass_matrix", "--out", str(tmp_path)]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert {path.name for path in tmp_path.iterdir()} == {
        f"planar2r_mass_matrix{end}" for end in (".c", ".h", "_test.c")
    }
    refused = subprocess.run(
        [*words, "--to", "ptx", "--target", "x", "--lang", "ar"], capture_output=True, text=True, check=False
    )
    assert refused.returncode == 2
    assert "غير معروف" in refused.stderr


def test_doctor_compiles_exports(monkeypatch: pytest.MonkeyPatch) -> None:
    from mafsil.cli import export as command

    monkeypatch.setattr(command, "CHECKED", (("planar2r", "mass_matrix"),))
    rows = command.checks()
    assert all(row["ok"] for row in rows), rows
    assert len(rows) == (3 if CC else 1)
    monkeypatch.setenv("CC", "no-such-compiler")
    (row,) = command.checks()
    assert row["ok"]
    assert "no C compiler found" in row["detail"]
