"""Hostile problem files: what YAML, numbers, names, expressions and sizes can be made to do."""

from __future__ import annotations

from collections.abc import Iterable

from tests.support.hostile.cases import Case, compiling

HEAD = "inputs: {x: [0.5, 1], y: [0.1, 0.9], z: [0.1, 0.2]}\nequations:\n"


def one(expression: str) -> str:
    """Return a problem of one equation."""
    return f"{HEAD}  - w = {expression}\n"


def lines(items: Iterable[str]) -> str:
    return "".join(f"  - {item}\n" for item in items)


def coefficient(expression: str, before: Iterable[str] = (), small: bool = True) -> str:
    """Return a solve that is linear only if the expression, a coefficient of cos(t)**2, is zero."""
    head = HEAD.replace("[0.5, 1]", "[1.0e-3, 2.0e-3]") if small else HEAD
    solve = f'solve: "({expression})*cos(t)**2 + cos(t) = y", for: t, branch: "+"'
    return head + lines([*before, "{" + solve + "}"])


def bomb(levels: int = 9) -> str:
    """Return ten to the number of levels, by aliases."""
    text = "a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n"
    for level in range(1, levels + 1):
        text += f"a{level}: &a{level} [{', '.join([f'*a{level - 1}'] * 10)}]\n"
    return text


def table(joints: int, frames: int = 1, alpha: str = "0.3", convention: str = "standard") -> str:
    """Return tables of joints."""
    text = "inputs:\n" + "".join(f"  q{i}: [-1, 1]\n" for i in range(joints)) + "equations:\n"
    for frame in range(frames):
        text += f"  - dh:\n      frame: T{frame}\n      convention: {convention}\n      joints:\n"
        text += "".join(f"        - {{theta: q{i}, d: 0.1, a: 0.2, alpha: {alpha}}}\n" for i in range(joints))
    return text


def chain(count: int, branch: str = "'+'") -> str:
    """Return solves each of which rests on the one before."""
    written = "cos(t{0})*cos(t{1}) + y*sin(t{1}) = sin(t{0})/3"
    solves = (f"{{solve: {written.format(i - 1, i)}, for: t{i}, branch: {branch}}}" for i in range(1, count))
    return HEAD + lines(["t0 = x", *solves])


NUL = "\0"
SIXTY_FOURTH = "((((x*2)**64)**64)**64)**64"
TWENTY = "+".join(f"{i}*x*y**{i}" for i in range(1, 25))

YAML = [
    compiling("alias bomb", bomb(), "E104"),
    compiling("alias of itself", "{a: &a [*a]}", "E103"),
    compiling("deep flow lists", "[" * 100_000, "E104"),
    compiling("deep flow mappings", "{a: " * 50_000, "E104"),
    compiling("deep block mappings", "".join(" " * i + "a:\n" for i in range(1000)), "E104"),
    compiling("dashes", "- " * 100_000, "E104"),
    compiling("anchors", "a:\n" + "".join(f"  - &a{i} x\n" for i in range(39_000)), "E201"),
    compiling("unknown keys", "".join(f"k{i}: 1\n" for i in range(19_000)), "E201"),
    compiling("too many nodes", "".join(f"k{i}: 1\n" for i in range(45_000)), "E104"),
    compiling("a key of 900 kB", "k" * 900_000 + ": 1\n", "E101"),
    compiling("more than a megabyte", "#" * (1 << 21), "E100"),
    compiling("a tag that runs code", "!!python/object/apply:os.system ['touch pwned']", "E103"),
    compiling("a tag on a value", "name: !!python/name:os.system x\n", "E103"),
    compiling("merge key", "inputs: {<<: {x: [0, 1]}}\nequations: [y = x]", "E207"),
    compiling("a key twice", "inputs: {x: [0, 1]}\n" * 2 + "equations: [y = x]", "E102"),
    compiling("an input twice", "inputs: {x: [0, 1], x: [0, 2]}\nequations: [y = x]", "E102"),
    compiling("nothing", "", "E208"),
    compiling("null", "null", "E202"),
    compiling("two documents", "---\na: 1\n---\nb: 2\n", "E103"),
    compiling("another version", "%YAML 9.9\n---\na: 1", "E101"),
    compiling("an escape beyond Unicode", 'name: "\\UFFFFFFFF"\n', "E101", "E105"),
    compiling("complex keys", "? [a, b]\n: 1\n", "E103"),
]

TEXT = [
    compiling("Latin-1", "name: caf\xe9\n".encode("latin-1"), "E100"),
    compiling("UTF-16", "name: x\n".encode("utf-16"), "E100"),
    compiling("UTF-32", "name: x\n".encode("utf-32"), "E100", "E105"),
    compiling("half a surrogate pair", HEAD.encode() + b"  - w = \xed\xa0\x80\n", "E100"),
    compiling("an escaped surrogate", 'name: "\\ud800"\n', "E105", "E101"),
    compiling("overlong UTF-8", b"name: \xc0\xaf\n", "E100"),
    compiling("NUL", one(f"x{NUL}"), "E105"),
    compiling("BEL", one("x\x07+1"), "E105"),
    compiling("escape sequence", one("x\x1b[2J"), "E105"),
    compiling("C1 control", one("x\x9b2J"), "E105"),
    compiling("Cyrillic x", one("х*2"), "E110"),
    compiling("Cyrillic sine", one("ѕin(x)"), "E110"),
    compiling("full-width letters", one("ｘ+１"), "E110"),
    compiling("Arabic digits", one("x*٣"), "E110"),
    compiling("right-to-left override", one("x\u202e+1"), "E110"),
    compiling("zero-width space", one("x\u200b+1"), "E110"),
    compiling("combining accent", one("x\u0301+1"), "E110"),
    compiling("a name in mathematical letters", "inputs: {𝐱: [0, 1]}\nequations: [w = 1]", "E207"),
    compiling("random bytes", bytes((i * 7919 + i // 3) % 256 for i in range(100_000)), "E100", "E105"),
]

NAMES = [
    compiling("import", one("__import__('os').system('touch pwned')"), "E110"),
    compiling("exec", one("exec('1')"), "E110", "E114"),
    compiling("attribute", one("x.__class__.__mro__"), "E110"),
    compiling("call of a class", one("Symbol(x)"), "E114"),
    compiling("lambda", one("lambda: 1"), "E202", "E116", "E117"),
    compiling("format string", one("f'{x}'"), "E110", "E203"),
    compiling(
        "names of Python and SymPy objects",
        "inputs: {lambda: [0, 1], beta: [0, 1], E1: [0, 1], S: [0, 1], __import__: [0, 1], re: [0, 1],\n"
        "  im: [0, 1], None: [0, 1], True: [0, 1], oo: [0.5, 1], I: [0.1, 0.2], zoo: [0, 1],\n"
        "  Symbol: [0, 1], self: [0, 1]}\n"
        "equations:\n"
        "  - N = lambda + beta*E1 + S*__import__ + re/(1 + im) + None*True + oo*I + zoo + Symbol*self\n"
        "  - {solve: oo*cos(Q) + beta*sin(Q) = I, for: Q, branch: '+'}\n",
    ),
    compiling("a name of 100 kB", f"inputs: {{{'a' * 100_000}: [0, 1]}}\nequations: [w = 1]", "E101", "E207"),
    compiling("an unknown name of 900 kB", one("a" * 900_000), "E203", "E207"),
    compiling("a folder name with slashes", f"name: ../../etc/passwd\n{one('x')}", "E202"),
    compiling("an absolute folder name", f"name: /tmp/pwned\n{one('x')}", "E202"),
    compiling("a description of 900 kB", f"description: {'a' * 900_000}\n{one('x')}", "E104"),
    compiling("a unit of 900 kB", f"inputs: {{x: {{range: [0, 1], unit: {'m' * 900_000}}}}}\n", "E104"),
    compiling("markup in texts", f"name: <script>\ndescription: '<img src=x onerror=alert(1)>'\n{one('x')}"),
]

NUMBERS = [
    compiling("1e400", one("1e400*x"), "E111"),
    compiling("1e-400", one("1e-400*x"), "E111"),
    compiling("1e99999999999", one("1e99999999999"), "E111"),
    compiling("a million digits", one("1" * 900_000), "E111"),
    compiling("a million zeros", one("0." + "0" * 900_000 + "1"), "E111"),
    compiling("tower of powers", one("2**2**2**2**2**2"), "E210"),
    compiling("10**10**6", one("10**10**6"), "E210"),
    compiling("a power of a power of a constant", one("((((2**64)**64)**64)**64)**64"), "E209"),
    compiling("a power of a power of an input", one("((((x**64)**64)**64)**64)**64")),
    compiling("powers that overflow", one("((((2*x)**64)**64)**64)**64"), "E410", "E320"),
    compiling("x * 1e300 * 1e300", one("x*1e300*1e300"), "E410", "E411"),
    compiling("x * 1e-300 * 1e-300", one("x*1e-300*1e-300"), "E410", "E411"),
    compiling("x / 1e300 / 1e300 * 1e300", one("x/1e300/1e300*1e300"), "E410", "E411"),
    compiling("a constant out of range", f"constants: {{a: 1e300, b: a*a}}\n{one('a*x')}", "E209"),
    compiling("sine of 1e300", f"constants: {{a: sin(1e300)*cos(1e299) + atan(1e300)}}\n{one('a*x')}"),
    compiling("exp of 1e300", f"constants: {{a: exp(1e300)}}\n{one('a*x')}", "E209"),
    compiling("nan", one(".nan*x"), "E111"),
    compiling("inf", one("inf*x"), "E203"),
    compiling("range of infinities", "inputs: {x: [-.inf, .inf]}\nequations: [w = x]", "E111"),
    compiling("range of nan", "inputs: {x: [.nan, .nan]}\nequations: [w = x]", "E111"),
    compiling("range of 1e300", "inputs: {x: [-1e300, 1e300]}\nequations: [w = x*x]", "E410", "E411"),
    compiling("range of 1e-300", "inputs: {x: [1e-300, 2e-300]}\nequations: [w = x*x]"),
    compiling("range of zero", "inputs: {x: [0, 0]}\nequations: [w = x/x]", "ok"),
    compiling("range upside down", "inputs: {x: [1, 0]}\nequations: [w = x]", "E211"),
    compiling("fractions that grow", one("+".join(f"x/{2 * i + 1}" for i in range(300)))),
    compiling(
        "constants that grow",
        "constants:\n  a0: 1/3\n"
        + "".join(f"  a{i}: a{i - 1}*a{i - 1} + 1/{2 * i + 1}\n" for i in range(1, 2000))
        + one("x*a1999"),
    ),
    compiling(
        "thousands of constants",
        "constants:\n" + "".join(f"  b{i}: sin(tan(exp(cos({i}))))\n" for i in range(3000)) + one("x*b1"),
    ),
    compiling("max_error of 1e-300", f"{one('sin(x)')}outputs: {{w: {{max_error: 1e-300}}}}\n", "E413"),
    compiling("max_error of nothing", f"{one('sin(x)')}outputs: {{w: {{max_error: 0}}}}\n", "E215"),
]

EXPRESSIONS = [
    compiling("a megabyte of a sum", one("+".join(["x"] * 400_000)), "E104"),
    compiling("10,000 parentheses", one("(" * 9000 + "x" + ")" * 9000), "E104"),
    compiling("10,000 signs", one("-" * 10_000 + "x"), "E104"),
    compiling("10,000 roots", one("sqrt(" * 6000 + "x" + ")" * 6000), "E104"),
    compiling("100 sines", one("sin(" * 99 + "x" + ")" * 99)),
    compiling("100 exponentials", one("exp(" * 99 + "x" + ")" * 99), "ok", "E410", "E320"),
    compiling("100 powers", one("x" + "**1" * 120), "E104"),
    compiling("20,000 products", one("*".join(["x"] * 9_900)), "E415"),
    compiling("20,000 quotients", one("/".join(["x"] * 9_900)), "E415"),
    compiling("20,000 sines", one("+".join(f"sin({i}*x)" for i in range(2_400))), "E415"),
    compiling("minimum of 3,000", one("min(" + ",".join(f"x*{i}" for i in range(3_000)) + ")"), "E415"),
    compiling("an unfinished call", one("sin("), "E112", "E113"),
    compiling("only operators", one("*" * 5000), "E112", "E117"),
]

PROOFS = [
    compiling("a tower that looks like zero", coefficient(f"({SIXTY_FOURTH})**64"), "E302"),
    compiling(
        "the sine of a million angles",
        coefficient("2*sin(1000000*x)*cos(1000000*x) - sin(2000000*x)"),
        "E302",
    ),
    compiling(
        "the sine of a sum of many angles",
        coefficient(f"2*sin({TWENTY})*cos({TWENTY}) - sin(2*({TWENTY}))"),
        "E302",
    ),
    compiling(
        "many fractions",
        coefficient(
            "+".join(f"1/(x*y**{i}+z)" for i in range(1, 61))
            + "-"
            + "-".join(f"2/(2*x*y**{i}+2*z)" for i in range(1, 61))
        ),
        "E302",
    ),
    compiling(
        "powers of sines",
        coefficient(
            "*".join(f"(1-cos({i}*x*y)**2)**6" for i in range(1, 9))
            + "-"
            + "*".join(f"sin({i}*x*y)**12" for i in range(1, 9)),
            small=False,
        ),
        "E302",
    ),
    compiling(
        "an expression that doubles at each step",
        coefficient(
            "m119 - m118*sin(m118) + m118*cos(m118) - cos(m118)*m118",
            ["m0 = x", *(f"m{i} = m{i - 1}*sin(m{i - 1})" for i in range(1, 120))],
        ),
        "E302",
    ),
    compiling(
        "lengths of lengths",
        coefficient(
            "(m59+x)**2 - m59**2 - 2*m59*x - x**2",
            ["m0 = y", *(f"m{i} = hypot(m{i - 1}, sin(m{i - 1}))" for i in range(1, 60))],
        ),
        "E302",
    ),
    compiling("a long power", coefficient("(x+y+z)**60 - ((x+y+z)**30)**2", small=False), "E302"),
]

SOLVES = [
    compiling(
        "degree 16",
        coefficient("x-x").replace(
            "cos(t) = y", "*".join(f"(x*{i}+y*cos(t)+z*sin(t))" for i in range(1, 17)) + " = y"
        ),
        "E302",
    ),
    compiling(
        "700 terms of degree 16",
        coefficient("x-x").replace(
            "cos(t) = y", "+".join(f"(x+y*cos(t)+z*sin(t)+{j})**16" for j in range(700)) + " = y"
        ),
        "E104",
    ),
    compiling(
        "1,100 multiples",
        coefficient("x-x").replace(
            "cos(t) = y", "+".join(f"x**{j % 60}*cos(8*t+{j}*x)" for j in range(1100)) + " = y"
        ),
        "E302",
    ),
    compiling("100 solves in a chain", chain(100)),
    compiling("8,000 solves in a chain", chain(5_000), "E104", "E415"),
    compiling("300 solves with conditions in a chain", chain(300, "'sin(t1) > 0'"), "E309", "E202"),
    compiling(
        "30 solves with all branches",
        HEAD
        + lines(
            f"{{solve: cos(t{i})*x + y*sin(t{i}) = z/{i + 2}, for: t{i}, branch: all}}" for i in range(30)
        )
        + lines(["w = " + "+".join(f"t{i}" for i in range(30))]),
        "E104",
    ),
    compiling(
        "all branches of everything, thousands of times",
        "branches: all\n"
        + HEAD
        + lines(f"{{solve: cos(t{i})*x + y*sin(t{i}) = z/{i + 2}, for: t{i}}}" for i in range(4))
        + lines(f"w{i} = t0+t1*t2-t3*{i}" for i in range(2000)),
        "E104",
    ),
]

SIZES = [
    compiling("500 joints", table(500), "E104"),
    compiling("32 joints 16 times", table(32, 16)),
    compiling("32 joints 17 times", table(32, 17), "E104"),
    compiling("32 right angles", table(32, 1, "pi/2", "modified")),
    compiling(
        "1,000 inputs",
        "inputs:\n" + "".join(f"  x{i}: [0, 1]\n" for i in range(1000))
        + "equations:\n  - w = " + "+".join(f"x{i}" for i in range(1000)) + "\n",
    ),
    compiling(
        "200 inputs",
        "inputs:\n" + "".join(f"  x{i}: [0, 1]\n" for i in range(200))
        + "equations:\n  - w = " + "+".join(f"x{i}" for i in range(200)) + "\n",
    ),
    compiling(
        "9,000 inputs",
        "inputs:\n" + "".join(f"  x{i}: [0, 1]\n" for i in range(9000)) + "equations: [w = x1]\n",
        "E415",
    ),
    compiling("18,000 equations", HEAD + lines(f"w{i} = x + {i}" for i in range(18_000)), "E415", "E104"),
    compiling("18,000 unused", HEAD + lines(f"w{i} = x" for i in range(18_000)) + "outputs: [w0]\n"),
    compiling("18,000 in reverse", HEAD + lines(f"w{i} = w{i + 1}*y" for i in range(18_000)), "E205"),
    compiling("18,000 unknown names", HEAD + lines(f"w{i} = v{i}*y" for i in range(18_000)), "E203"),
    compiling(
        "misspelt long names",
        HEAD
        + lines(f"{'z' * 38}{i} = x" for i in range(9_000))
        + lines(f"q{i} = {'z' * 37}{i}_*y" for i in range(200)),
        "E203",
    ),
    compiling(
        "thousands of poles",
        "inputs: {x: [-1, 1], y: [-1, 1]}\nequations:\n"
        + lines(["w0 = x", *(f"w{i} = 1/(w{i - 1} + y/{i})" for i in range(1, 1200))]),
        "ok", "E410",
    ),
    compiling(
        "products of cross products",
        HEAD + lines(['vector: "v = ' + "cross([x,y,z]+" * 90 + "[x,y,z]" + ", [y,z,x])" * 90 + '"']),
    ),
    compiling(
        "a thousand vectors",
        HEAD
        + lines(
            ['vector: "v0 = [x, y, z]"']
            + [f'vector: "v{i} = cross(v{i - 1}, rotate(v{i - 1}, x, y)) + v{i - 1}"' for i in range(1, 600)]
        ),
        "E415", "E410", "E104",
    ),
    compiling(
        "20,000 assumptions",
        one("x+y+z") + "assume:\n" + lines(f"x**{i % 60 + 2} < 2" for i in range(18_000)),
    ),
    compiling(
        "assumptions of thousands of terms",
        one("x+y+z") + "assume:\n" + lines(["+".join(["sin(x)"] * 3000) + " > 0"] * 20),
    ),
]  # fmt: skip

CASES: list[Case] = [
    *YAML, *TEXT, *NAMES, *NUMBERS, *EXPRESSIONS, *PROOFS, *SOLVES, *SIZES,
]  # fmt: skip
