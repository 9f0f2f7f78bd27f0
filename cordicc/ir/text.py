"""The printed form of a graph, which parses back to an equal graph.

%0 = input[name=x]
%1:2 = rotate[m=1](%0, %0, %0) @theta
output y = %1#1
"""

from __future__ import annotations

import re
from fractions import Fraction

from cordicc.base.diagnostics import Diagnostic, InvalidInput, Source, Span
from cordicc.ir.graph import Graph, Node, Param, Value
from cordicc.ir.ops import OPS

_STRING_PARAMS = {"name", "condition", "branch"}
_INTEGER_PARAMS = {"m", "sign"}


def format_number(number: Fraction) -> str:
    """Return a rational exactly: an integer, a ratio, or mantissa and exponent of a long dyadic."""
    if number.denominator == 1 and abs(number.numerator) < 1 << 64:
        return str(number.numerator)
    denominator = number.denominator
    if denominator & (denominator - 1) == 0 and denominator.bit_length() > 65:
        return f"{number.numerator:#x}p-{denominator.bit_length() - 1}"
    return f"{number.numerator}/{denominator}"


def parse_number(text: str) -> Fraction:
    """Return the number printed by `format_number`.

    Raises ValueError for anything else.
    """
    match = re.fullmatch(r"(-?0x[0-9a-f]{1,400})p-([0-9]{1,4})", text)
    if match:
        return Fraction(int(match[1], 16), 1 << int(match[2]))
    if not re.fullmatch(r"-?[0-9]{1,1000}(/[0-9]{1,1000})?", text):
        raise ValueError(f"not a number: {text!r}")
    return Fraction(text)


def _format_value(graph: Graph, value: Value) -> str:
    many = len(graph.node(value).definition.results) > 1
    return f"%{value.node}#{value.result}" if many else f"%{value.node}"


def _format_param(param: Param) -> str:
    return format_number(Fraction(param)) if isinstance(param, Fraction | int) else param


def print_graph(graph: Graph) -> str:
    """Return the text of a graph, one operation a line, ending in a newline."""
    lines = []
    for index, node in enumerate(graph.nodes):
        definition = node.definition
        count = f":{len(definition.results)}" if len(definition.results) > 1 else ""
        params = ", ".join(
            f"{name}={_format_param(param)}"
            for name, param in zip(definition.params, node.params, strict=True)
        )
        operands = ", ".join(_format_value(graph, v) for v in node.operands)
        text = f"%{index}{count} = {node.op}"
        text += f"[{params}]" if params else ""
        text += f"({operands})" if operands else ""
        lines.append(text + (f" @{node.origin}" if node.origin else ""))
    for name, value in graph.outputs.items():
        lines.append(f"output {name} = {_format_value(graph, value)}")
    return "\n".join(lines) + "\n"


_LINE = re.compile(
    r"%(?P<index>[0-9]{1,7})(?::[0-9])? = (?P<op>[a-z_0-9]+)(?:\[(?P<params>[^\]]*)\])?"
    r"(?:\((?P<operands>[^)]*)\))?(?: @(?P<origin>\w+))?"
)
_OUTPUT = re.compile(r"output (?P<name>[\w.]+) = (?P<value>%[0-9]{1,7}(?:#[0-9])?)")


def parse_graph(text: str, name: str = "<graph>") -> Graph:
    """Return the graph of a printed form.

    Raises InvalidInput, with the line, for text that `print_graph` cannot have written.
    """
    source = Source(name, text)
    nodes: list[Node] = []
    outputs: dict[str, Value] = {}
    for number, line in enumerate(text.splitlines(), 1):
        try:
            _parse_line(line, nodes, outputs)
        except ValueError as error:
            span = Span(number, 1, len(line) + 1)
            raise InvalidInput([Diagnostic("E601", str(error), span, None, source=source)]) from None
    return Graph(tuple(nodes), outputs)


def _parse_line(line: str, nodes: list[Node], outputs: dict[str, Value]) -> None:
    output = _OUTPUT.fullmatch(line)
    if output:
        outputs[output["name"]] = _parse_value(output["value"], nodes)
        return
    match = _LINE.fullmatch(line)
    if not match or match["op"] not in OPS:
        raise ValueError("not an operation of the graph")
    if int(match["index"]) != len(nodes):
        raise ValueError(f"expected operation number {len(nodes)}")
    definition = OPS[match["op"]]
    params: list[Param] = []
    texts = match["params"].split(", ") if match["params"] else []
    if len(texts) != len(definition.params):
        raise ValueError(f"'{definition.name}' takes the parameters {definition.params}")
    for expected, item in zip(definition.params, texts, strict=True):
        key, _, value = item.partition("=")
        if key != expected:
            raise ValueError(f"expected parameter '{expected}'")
        params.append(_parse_param(key, value))
    operands = (
        tuple(_parse_value(v, nodes) for v in match["operands"].split(", ")) if match["operands"] else ()
    )
    if len(operands) != definition.arity:
        raise ValueError(f"'{definition.name}' takes {definition.arity} operands")
    nodes.append(Node(definition.name, tuple(params), operands, match["origin"] or ""))


def _parse_param(key: str, text: str) -> Param:
    if key in _STRING_PARAMS:
        return text
    number = parse_number(text)
    if key in _INTEGER_PARAMS:
        if number not in (-1, 0, 1):
            raise ValueError(f"parameter '{key}' is out of range")
        return int(number)
    return number


def _parse_value(text: str, nodes: list[Node]) -> Value:
    match = re.fullmatch(r"%([0-9]{1,7})(?:#([0-9]))?", text)
    if not match:
        raise ValueError(f"not a value: {text!r}")
    value = Value(int(match[1]), int(match[2] or 0))
    if value.node >= len(nodes) or value.result >= len(nodes[value.node].definition.results):
        raise ValueError(f"{text} is not defined before its use")
    return value
