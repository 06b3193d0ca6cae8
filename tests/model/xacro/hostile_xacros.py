"""Xacro files with one fault each."""

from __future__ import annotations

from dataclasses import dataclass

HEAD = '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">\n<link name="a"/>\n'


@dataclass(frozen=True)
class Case:
    """A file, the code that it gets, and its line."""

    name: str
    body: str
    code: str
    line: int = 3

    @property
    def data(self) -> str:
        return f"{HEAD}{self.body}\n</robot>"


def value(expression: str) -> str:
    """A link whose name is the value of an expression."""
    return f'<link name="${{{expression}}}"/>'


_DOUBLING = "".join(f'<xacro:property name="p{k + 1}" value="${{p{k}}}${{p{k}}}"/>' for k in range(60))
_ENDLESS = '<xacro:macro name="m" params="n"><link name="l${n}"/><xacro:m n="${n + 1}"/></xacro:macro><xacro:m n="0"/>'
_TWICE = (
    '<xacro:macro name="m" params="n"><xacro:if value="${n > 0}"><xacro:m n="${n - 1}"/><xacro:m n="${n - 1}"/>'
    '</xacro:if></xacro:macro><xacro:m n="60"/>'
)
_BLOCKS = '<xacro:macro name="m" params="*b"><xacro:insert_block name="b"/></xacro:macro>'

CASES = (
    Case("unknown macro", '<xacro:property name="x" value="1"/><xacro:arm/>', "X1101"),
    Case("unknown parameter", '<xacro:macro name="m" params="x"/><xacro:m y="1"/>', "X1102"),
    Case("parameter without value", '<xacro:macro name="m" params="x"/><xacro:m/>', "X1103"),
    Case("block missing", _BLOCKS + "<xacro:m/>", "X1104"),
    Case("block too many", _BLOCKS + '<xacro:m><link name="b"/><link name="c"/></xacro:m>', "X1104"),
    Case("unknown block", '<xacro:insert_block name="b"/>', "X1105"),
    Case("division by zero", value("1/0"), "X1106"),
    Case("no expression", value("1 +"), "X1106"),
    Case("imported module", value("__import__('os')"), "X1106"),
    Case("class of a number", value("(1).__class__"), "X1106"),
    Case("classes of a text", value("''.__class__.__mro__[1].__subclasses__()"), "X1106"),
    Case("globals of a function", value("len.__self__"), "X1106"),
    Case("lambda", value("(lambda: 1)()"), "X1106"),
    Case("format reaching inside", value("'{0.__class__}'.format(1)"), "X1106"),
    Case("format of a million", value("'%1000000000d' % 1"), "X1106"),
    Case("tower of powers", value("9**9**9**9"), "X1106"),
    Case("long text", value("'x'*10**9"), "X1106"),
    Case("long list", value("[0]*10**9"), "X1106"),
    Case("long range", value("range(10**12)"), "X1106"),
    Case("nested list", value("[[[[[[1]*99]*99]*99]*99]*99]*99"), "X1106"),
    Case("comprehension without end", value("[a for a in range(9999) for b in range(9999) for c in range(9999)]"),
         "X1106"),
    Case("deep parentheses", value("(" * 300 + "1" + ")" * 300), "X1106"),
    Case("deep signs", value("-" * 3000 + "1"), "X1106"),
    Case("longer than any expression", value("1+" * 3000 + "1"), "X1106"),
    Case("function as a value", value("len"), "X1106"),
    Case("undefined name", value("lenght"), "X1107"),
    Case("property that needs itself", '<xacro:property name="x" value="${x}"/>' + value("x"), "X1108"),
    Case("condition", '<xacro:if value="perhaps"/>', "X1109"),
    Case("argument", '<link name="$(arg x)"/>', "X1110"),
    Case("package", '<link name="$(find nowhere_at_all)"/>', "X1111"),
    Case("included file", '<xacro:include filename="other.xacro"/>', "X1112"),
    Case("included from outside", '<xacro:include filename="/etc/hostname"/>', "X1112"),
    Case("calls that double", _TWICE, "X1113"),
    Case("endless recursion", _ENDLESS, "F0122"),
    Case("texts that double", '<xacro:property name="p0" value="ab"/>' + _DOUBLING + value("p60"), "X1118"),
    Case("name of a property", '<xacro:property name="2x" value="1"/>' + value("1"), "X1115"),
    Case("name of a macro", '<xacro:macro name="a.b"/>' + value("1"), "X1115"),
    Case("command", '<link name="$(rm all)"/>', "X1116"),
    Case("environment", '<link name="$(env MAFSIL_IS_NOT_SET)"/>', "X1117"),
    Case("open brace", '<link name="${1"/>', "X1118"),
    Case("attribute", "<xacro:if/>", "X1120"),
    Case("left over", '<xacro:property name="x" value="1"/>', "X1122"),
)  # fmt: skip
