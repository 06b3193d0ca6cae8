"""Formulas of the docstrings, typeset: `tau = M qdd + c + g + J' F_tip` becomes MathML while the site is built.

Docstrings are read in terminals too, so they carry plain formulas in the notation of docs/conventions.md and no LaTeX.

1. The text outside of code is cut into runs of mathematical tokens: letters with indices, Greek names, derivatives (qd,
   qdd, dM/dt), functions, numbers, operators and brackets. Words of a sentence are longer than a letter and end a run.
2. A run is a formula when it is a relation: something, then =, < or >, then something, with brackets that close.
3. Its tokens become LaTeX one by one, and latex2mathml makes MathML of it: no script runs in the reader's browser.
4. What is left is prose: signs that reStructuredText would take for markup are escaped, `names` are literals.

The pages of docs/ set their formulas between `$` signs; code in them that is a relation by rule 2 is typeset as well.
"""

from __future__ import annotations

import re
from typing import Any

from docutils import nodes
from latex2mathml import exceptions
from latex2mathml.converter import convert
from sphinx.application import Sphinx

GREEK = (
    "alpha|beta|gamma|delta|epsilon|zeta|eta|theta|kappa|lambda|mu|nu|xi|pi|rho|sigma|tau|phi|psi|omega|"
    "Gamma|Delta|Theta|Lambda|Sigma|Phi|Psi|Omega"
)
FUNCTIONS = ["sin", "cos", "tan", "exp", "log", "det", "min", "max"]
NAMED = {
    "Ad": r"\mathrm{Ad}",
    "ad": r"\mathrm{ad}",
    "atan2": r"\operatorname{atan2}",
    "sqrt": r"\surd",
    "rank": r"\operatorname{rank}",
}
RATES = {"qd": r"\dot{q}", "qdd": r"\ddot{q}"}
OPERATORS = {"<=": r"\le", ">=": r"\ge", "'": r"^{\top}", "**": "^", "*": r"\,", "{": r"\{", "}": r"\}"}

_NAMES = "|".join([GREEK, *FUNCTIONS, *NAMED, *RATES])
WORD = rf"(?:{_NAMES}|d[A-Za-z](?:_[A-Za-z0-9]+)?/dt|[A-Za-z])(?:_[A-Za-z0-9]+)*(?![A-Za-z0-9_])"
NUMBER = r"\d+(?:\.\d+)?(?![\w.])"
OPERATOR = r"<=|>=|\*\*|[-+*/^'=<>|,()\[\]{}]"
TOKEN = re.compile(rf"(?P<word>{WORD})|(?P<number>{NUMBER})|(?P<operator>{OPERATOR})")
RUN = re.compile(rf"(?<![\w.*])(?:{WORD}|{NUMBER}|{OPERATOR}| (?=\S))+")
CODE = re.compile(r"(``[^`]*``|`[^`]*`|^ *>>>.*?$)", re.M)
STEP = re.compile(r"\s*(\d+\.|[a-z]\)|[-*]) ")
FIELD = re.compile(r"\s*(:\w|\.\. )")
MARKUP = re.compile(r"\*|\||(?<=\w)_(?!\w)|\\")
LATEX_ERRORS = tuple(
    each for each in vars(exceptions).values() if isinstance(each, type) and issubclass(each, Exception)
)


def typeset(text: str) -> str:
    """A docstring's text as reStructuredText: formulas in the math role, names as literals, all else as it reads."""
    pieces = CODE.split(text)
    return "".join(_literal(piece) if index % 2 else _prose(piece) for index, piece in enumerate(pieces))


def is_relation(run: str) -> bool:
    """Whether the tokens say that something equals, or is less than, something else."""
    sides = re.split(r"<=|>=|[=<>]", run)
    closed = all(run.count(opening) == run.count(closing) for opening, closing in ("()", "[]", "{}"))
    whole = len(sides) > 1 and all(re.search(r"\w", side) for side in sides)
    return closed and whole and re.search("[A-Za-z]", run) is not None


def latex(formula: str) -> str:
    """One formula in LaTeX, token by token."""
    return " ".join(_written(token) for token in TOKEN.finditer(formula))


def mathml(formula: str, display: str = "inline") -> str | None:
    """LaTeX as MathML; None where its tokens make no sense as a formula (two exponents in a row, say)."""
    try:
        return convert(formula, display=display)
    except LATEX_ERRORS:
        return None


def setup(app: Sphinx) -> None:
    """Docstrings are typeset as they are read; every formula of the site is written as MathML."""
    app.connect("autodoc-process-docstring", _typeset, priority=400)
    app.connect("autodoc-process-docstring", _lay_out, priority=900)  # after the sections have become fields
    app.connect("doctree-read", set_relations)
    app.add_html_math_renderer("mathml", (_inline, None), (_block, None))


def laid_out(lines: list[str]) -> list[str]:
    """Blank lines where reStructuredText wants them: before steps and fields, and round blocks that are indented."""
    done: list[str] = []
    for line in lines:
        before = done[-1] if done else ""
        if line.strip() and before.strip():
            continues = _indent(line) == _hang(before) or (FIELD.match(before) and line.startswith(" "))
            if STEP.match(line) or FIELD.match(line) or not continues:
                done.append("")
        done.append(line)
    return done


def _indent(line: str) -> int:
    return len(line) - len(line.lstrip())


def _hang(line: str) -> int:
    """Where the text that continues this line begins."""
    step = STEP.match(line)
    return step.end() if step else _indent(line)


def set_relations(app: Sphinx, doctree: nodes.document) -> None:
    """Code of a guide page that is a formula from end to end becomes one: `V_s = J_s qd`, not `seed = 1`."""
    if app.env.docname.startswith("reference/"):
        return
    for literal in list(doctree.findall(nodes.literal)):
        text = literal.astext()
        if RUN.fullmatch(text) and is_relation(text) and mathml(latex(text)):
            literal.replace_self(nodes.math(text, latex(text)))


def _typeset(app: Sphinx, what: str, name: str, thing: Any, options: Any, lines: list[str]) -> None:
    lines[:] = typeset("\n".join(lines)).split("\n")


def _lay_out(app: Sphinx, what: str, name: str, thing: Any, options: Any, lines: list[str]) -> None:
    lines[:] = laid_out(lines)


def _inline(translator: Any, node: nodes.math) -> None:
    translator.body.append(mathml(node.astext()) or translator.encode(node.astext()))
    raise nodes.SkipNode


def _block(translator: Any, node: nodes.math_block) -> None:
    translator.body.append(mathml(node.astext(), "block") or translator.encode(node.astext()))
    raise nodes.SkipNode


def _prose(text: str) -> str:
    done, end = [], 0
    for run in RUN.finditer(text):
        body = run[0].rstrip(" ,-(")
        start = run.start() + len(body) - len(body := body.lstrip())
        formula = latex(body) if is_relation(body) else ""
        if formula and mathml(formula):
            done += [_escaped(text[end:start]), rf"\ :math:`{formula}`\ "]
            end = start + len(body)
    return "".join([*done, _escaped(text[end:])])


def _written(token: re.Match[str]) -> str:
    if token["number"]:
        return token["number"]
    if token["operator"]:
        return OPERATORS.get(token["operator"], token["operator"])
    rate = re.fullmatch(r"d(\w+)/dt", token["word"])
    if rate:
        return rf"\frac{{\mathrm{{d}} {_letter(rate[1])}}}{{\mathrm{{d}}t}}"
    return _letter(token["word"])


def _letter(word: str) -> str:
    name, *indices = word.split("_")
    base = RATES.get(name) or NAMED.get(name) or (rf"\{name}" if len(name) > 1 else name)
    return base + (f"_{{{','.join(indices)}}}" if indices else "")


def _literal(code: str) -> str:
    return code if code.startswith("``") or ">>>" in code else f"`{code}`"


def _escaped(text: str) -> str:
    return MARKUP.sub(r"\\\g<0>", text)
