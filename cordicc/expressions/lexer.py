"""Text of an expression to tokens.  ASCII only; numbers are decimal and exact."""

from __future__ import annotations

import re
import unicodedata
from dataclasses import dataclass
from enum import StrEnum
from fractions import Fraction

from cordicc.expressions.hints import NO_CONDITIONALS
from cordicc.ir.meaning.exact import LARGEST, SMALLEST

MAX_TOKENS = 20_000
MAX_NAME = 100
_MAX_DIGITS = 400


class Kind(StrEnum):
    """The kinds of tokens."""

    NUMBER = "number"
    NAME = "name"
    OPERATOR = "operator"
    END = "end"


@dataclass(frozen=True, slots=True)
class Token:
    """A token: its kind, its text, its place in the expression (end exclusive), its number if one."""

    kind: Kind
    text: str
    start: int
    end: int
    number: Fraction = Fraction(0)


class ExpressionError(Exception):
    """A mistake in an expression, placed by offsets into its text."""

    def __init__(self, code: str, message: str, start: int, end: int, hint: str | None = None) -> None:
        super().__init__(message)
        self.code = code
        self.message = message
        self.start = start
        self.end = end
        self.hint = hint


NUMBER = r"(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
"""The form of a decimal number without sign."""

_NUMBER = re.compile(NUMBER)
_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_OPERATOR = re.compile(r"\*\*|==|!=|<=|>=|//|&&|\|\||[-+*/(),=<>^]")
_SPACE = re.compile(r"[ \t\r\n]+")

_LOOK_ALIKES = {
    "×": "*", "·": "*", "∙": "*", "⋅": "*", "∗": "*", "÷": "/", "∕": "/", "⁄": "/",
    "−": "-", "–": "-", "—": "-", "‐": "-", "‑": "-", "π": "pi", "√": "sqrt(...)", "°": "*deg",
    "²": "**2", "³": "**3", "≤": "<=", "≥": ">=", "≠": "=", "’": "'", "“": '"', "”": '"',
    "а": "a", "е": "e", "о": "o", "р": "p", "с": "c", "х": "x", "у": "y", "і": "i", "ѕ": "s", "ј": "j",
    "А": "A", "В": "B", "Е": "E", "К": "K", "М": "M", "Н": "H", "О": "O", "Р": "P", "С": "C", "Т": "T",
    "Х": "X", "ο": "o", "Α": "A", "Β": "B", "Ε": "E", "Ζ": "Z", "Η": "H", "Ι": "I", "Κ": "K", "Μ": "M",
    "Ν": "N", "Ο": "O", "Ρ": "P", "Τ": "T", "Χ": "X", "θ": "theta", "φ": "phi", "ϕ": "phi", "ψ": "psi",
    "α": "alpha", "β": "beta", "γ": "gamma", "δ": "delta", "ω": "omega", "λ": "lambda", "ρ": "rho",
}  # fmt: skip


def tokenize(text: str, brackets: bool = False) -> list[Token]:
    """Return the tokens of an expression, an END token last; `brackets` admits `[` and `]`.

    Raises ExpressionError at the first character that cannot be part of an expression.
    """
    tokens: list[Token] = []
    at = 0
    while True:
        space = _SPACE.match(text, at)
        at = space.end() if space else at
        if at == len(text):
            tokens.append(Token(Kind.END, "", at, at))
            return tokens
        if len(tokens) >= MAX_TOKENS:
            raise ExpressionError("E104", f"the expression has more than {MAX_TOKENS} tokens", at, at + 1)
        bracket = brackets and text[at] in "[]"
        token = Token(Kind.OPERATOR, text[at], at, at + 1) if bracket else _token(text, at)
        tokens.append(token)
        at = token.end


def _token(text: str, at: int) -> Token:
    number = _NUMBER.match(text, at)
    if number:
        _check_number_context(text, number)
        return Token(Kind.NUMBER, number[0], at, number.end(), _number(number[0], at))
    name = _NAME.match(text, at)
    if name:
        end = name.end()
        if end - at > MAX_NAME:
            raise ExpressionError("E207", f"a name has at most {MAX_NAME} characters", at, end)
        if end < len(text) and not text[end].isascii() and text[end].isalnum():
            raise _foreign(text, end)
        return Token(Kind.NAME, name[0], at, end)
    operator = _OPERATOR.match(text, at)
    if operator:
        return Token(Kind.OPERATOR, operator[0], at, operator.end())
    raise _foreign(text, at)


def _check_number_context(text: str, match: re.Match[str]) -> None:
    """Raise the error for a number written in a notation that is not decimal."""
    rest = text[match.end() : match.end() + 8]
    if match[0] == "0" and re.match(r"[xXbBoO][0-9a-fA-F]", rest):
        raise ExpressionError("E111", "only decimal numbers are understood", match.start(), match.end() + 2)
    if re.match(r"_[0-9]", rest):
        hint = "write the digits without '_'"
        raise ExpressionError("E111", "'_' inside a number", match.end(), match.end() + 1, hint)
    if re.match(r"\.[0-9]*", rest):
        raise ExpressionError("E111", "a number with two decimal points", match.start(), match.end() + 1)


def _number(text: str, at: int) -> Fraction:
    def wrong(message: str) -> ExpressionError:
        return ExpressionError("E111", message, at, at + len(text))

    mantissa, _, exponent = text.lower().partition("e")
    if len(mantissa) > _MAX_DIGITS:
        raise wrong(f"the number has more than {_MAX_DIGITS} digits")
    value = Fraction(mantissa if not mantissa.endswith(".") else mantissa[:-1])
    if value == 0:
        return value
    digits = exponent.lstrip("+-").lstrip("0") or "0"
    too_far = len(digits) > 4
    if not too_far:
        value *= Fraction(10) ** (-int(digits) if exponent.startswith("-") else int(digits))
    if too_far or not SMALLEST <= value <= LARGEST:
        raise wrong("the number is neither 0 nor between 1e-300 and 1e300 in magnitude")
    return value


def _foreign(text: str, at: int) -> ExpressionError:
    character = text[at]
    if character.isascii():
        prefix = re.search(r"\b(?:np|numpy|math|sp|sympy|cmath)$", text[:at])
        if re.match(r"\.(inf|nan)\b", text[at : at + 5], re.IGNORECASE):
            return ExpressionError("E111", "the number is not finite", at, at + 4)
        hint = {
            "[": "use parentheses ( )",
            "{": "use parentheses ( )",
            "%": "there is no remainder operator",
            "|": "use abs(...)",
            "?": NO_CONDITIONALS,
            "'": "names are written without quotes",
            '"': "names are written without quotes",
            ".": f"leave the prefix '{prefix[0]}.' out" if prefix else None,
        }.get(character)
        message = f"an expression cannot contain '{character}'"
        return ExpressionError("E110", message, at, at + 1, hint)
    name = unicodedata.name(character, "unnamed")
    plain = _LOOK_ALIKES.get(character) or unicodedata.normalize("NFKC", character)
    hint = f"write {plain!r} instead" if plain.isascii() and plain.isprintable() and plain.strip() else None
    message = f"'{character}' (U+{ord(character):04X} {name}) is not an ASCII character"
    return ExpressionError("E110", message, at, at + 1, hint)
