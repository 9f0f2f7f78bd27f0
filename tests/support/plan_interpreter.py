"""An interpreter of fixed-point plans, written from docs/units.md and docs/plan.md, without cordicc.

All numbers are integers.  It takes the dictionary of `plan.json` and words of inputs, and gives words of
outputs, None for invalid ones.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any, NamedTuple

W = 52
NOTHING = -4096

Plain = dict[str, Any]


class Scaled(NamedTuple):
    m: int
    e: int


class Typed(NamedTuple):
    """A word and its format; the word None is invalid."""

    word: int | None
    width: int
    fraction: int


Result = Scaled | None


def rounded(value: int, places: int) -> int:
    return (value + (1 << (places - 1))) >> places if places > 0 else value << -places


def sign(value: int) -> int:
    return -1 if value < 0 else 1


def apart(number: Scaled) -> Scaled:
    return number if number.m else Scaled(0, NOTHING)


def normalise(number: Scaled, bits: int) -> Scaled:
    down = abs(number.m).bit_length() - bits
    return apart(Scaled(rounded(number.m, down), number.e + down))


def add(a: Scaled, b: Scaled) -> Scaled:
    e = max(a.e, b.e)
    return Scaled(rounded(a.m, e - a.e) + rounded(b.m, e - b.e), e)


def appended(number: Scaled, bits: int) -> Scaled:
    return apart(Scaled(number.m << bits, number.e - bits))


def row(table: Plain, column: str, exponent: int) -> int:
    values = table[column]
    found: int = values[min(max(exponent - table["first"], 0), len(values) - 1)]
    return found


class Constants:
    def __init__(self, data: Plain) -> None:
        self.data = data

    def word(self, name: str) -> int:
        return int(self.data[name]["word"])

    def fraction(self, name: str) -> int:
        return int(self.data[name]["fraction"])

    def pi(self, bits: int) -> int:
        """Return pi with some fraction bits, to nearest."""
        return rounded(self.word("pi"), self.fraction("pi") - bits)


class Unit:
    """A unit's operations on operands as typed words, all valid."""

    def __init__(self, data: Plain, constants: Plain) -> None:
        self.data, self.constants = data, Constants(constants)
        self.O, self.F, self.A = data["operand_bits"], data["fraction_bits"], data["angle_bits"]
        self.H, self.Q = data["half_turn"], data["quarter_turn"]

    def unpack(self, operand: Typed) -> Scaled:
        assert operand.word is not None
        up = self.O - abs(operand.word).bit_length()
        return apart(Scaled(operand.word << up, -operand.fraction - up))

    def join(self, bits: int, *numbers: Scaled, least: int = NOTHING) -> tuple[list[int], int]:
        e = max(least, *(number.e for number in numbers)) - (bits - self.O)
        return [rounded(number.m, e - number.e) for number in numbers], e

    def by_gain(self, number: Scaled, steps: Plain) -> Scaled:
        places = self.constants.data["gain_places"]
        inverse = steps["inverse_gain"]
        product = number.m * int(inverse["word"])
        return Scaled(rounded(product, inverse["fraction"] - places), number.e - places)

    def ln2(self, count: int) -> int:
        return rounded(count * self.constants.word("ln2"), self.constants.fraction("ln2") - self.A)

    def angle_sum(self, z: Scaled, angle: int) -> Scaled:
        e = max(z.e - (W - 2 - self.O), -self.A)
        return Scaled(rounded(z.m, e - z.e) + rounded(angle, e + self.A), e)

    def sum_and_difference(self, x: Scaled, y: Scaled) -> tuple[Scaled, Scaled]:
        (a, b), e = self.join(W, x, y)
        return normalise(Scaled(a + b, e), self.F), normalise(Scaled(a - b, e), self.F)

    # Iterations

    def steps(self, more: Plain) -> Plain:
        found: Plain = self.data["steps"][more["steps"]]
        return found

    def rotate(self, m: int, x: int, y: int, z: int, steps: Plain) -> tuple[int, int, int]:
        for s, angle in zip(steps["shifts"], steps["angles"], strict=True):
            d = sign(z)
            x, y, z = x - m * d * rounded(y, s), y + d * rounded(x, s), z - d * angle
        return x, y, z

    def vector(self, m: int, x: int, y: int, z: int, steps: Plain) -> tuple[int, int, int]:
        for s, angle in zip(steps["shifts"], steps["angles"], strict=True):
            d = sign(y)
            x, y, z = x + m * d * rounded(y, s), y - d * rounded(x, s), z + d * angle
        return x, y, z

    def implicit(
        self, m: int, x: int, y: int, T: int, z: int, near: tuple[int, int] | None, steps: Plain
    ) -> tuple[int, int, int, int]:
        shares, growth = self.constants.data["shares"], self.constants.data["growth_fraction"]
        for i, (s, angle) in enumerate(zip(steps["shifts"], steps["angles"], strict=True)):
            root_free = self.data["rule"] == "root-free"
            settled = root_free and i >= steps["unsettled"]
            level = T if settled else y
            u = T - y
            if near is not None:
                h, w = ((each + 1) // shares * steps["stretched"][i] for each in near)
                if 0 <= x < w and max(u, -u - 1) < h:
                    u = m * sign(T)
            d = sign(u) if x >= 0 else sign(-level - 1) if m == 1 else sign(level)
            z += d * angle
            if not root_free:
                x, y = x - m * d * rounded(y, s), y + d * rounded(x, s)
                T += rounded(T * steps["target_factors"][i], growth)
            elif i < steps["doubles"]:
                x, y, T = (
                    x - m * (d * rounded(y, s - 1) + rounded(x, 2 * s)),
                    y + d * rounded(x, s - 1) - m * rounded(y, 2 * s),
                    T + m * rounded(T, 2 * s),
                )
            elif not settled:
                x, y, T = (
                    x - m * d * rounded(y, s),
                    y + d * rounded(x, s),
                    T + m * rounded(T, 2 * s + 1),
                )
            else:
                x, y = x - m * d * rounded(T, s), y + d * rounded(x, s)
        return x, y, T, z

    # Operations

    def run(self, op: str, params: Plain, more: Plain, operands: list[Typed]) -> list[Result]:
        system = {1: "circular", 0: "linear", -1: "hyperbolic"}
        name = op if op == "lightcone" else f"{op}_{system[params['m']]}"
        results: list[Result] = getattr(self, name)(params, more, *map(self.unpack, operands))
        return results

    def rotate_circular(self, params: Plain, more: Plain, x: Scaled, y: Scaled, z: Scaled) -> list[Result]:
        steps = self.steps(more)
        if "quarters" in more:
            g, thresholds = more["quarters"]["fraction"], more["quarters"]["thresholds"]
            multiples = more["quarters"]["multiples"]
            a = rounded(z.m, -g - z.e)
            p, n = sum(t <= a for t in thresholds), sum(t < -a for t in thresholds)
            rest, k = rounded(a + multiples[n] - multiples[p], g - self.A), (p - n) % 4
        else:
            turns = more["turns"]
            t = int(turns["words"][z.e - turns["first"]]) if z.m else 0
            phase = ((z.m * t) >> turns["tail"]) % (1 << 64)
            k = (phase + (1 << 61)) >> 62
            rest = rounded(phase - (k << 62), 61 - self.A) * self.constants.word("tau")
            rest, k = rounded(rest, self.constants.fraction("tau") + 3), k % 4
        (a, b), e = self.join(self.F, x, y, least=more["least_exponent"])
        a, b = (-b, a) if k % 2 else (a, b)
        a, b = (-a, -b) if k >= 2 else (a, b)
        a, b, _ = self.rotate(1, a, b, rest, steps)
        return [self.by_gain(Scaled(a, e), steps), self.by_gain(Scaled(b, e), steps)]

    def rotate_linear(self, params: Plain, more: Plain, x: Scaled, y: Scaled, z: Scaled) -> list[Result]:
        n = self.F + 1
        start = x.m << (n - self.O), 0, z.m << (self.A - self.O)
        _, p, _ = self.rotate(0, *start, self.steps(more))
        p = p if x.m and z.m else 0
        product = apart(Scaled(p, x.e + z.e + 2 * self.O - n))
        return [x, add(appended(product, W - 2 - n), appended(y, W - 2 - self.O))]

    def rotate_hyperbolic(self, params: Plain, more: Plain, x: Scaled, y: Scaled, z: Scaled) -> list[Result]:
        steps, A = self.steps(more), self.A
        value = Fraction(z.m) * Fraction(2) ** z.e
        if abs(value) > 512:
            z = Scaled(sign(z.m) << (self.O - 1), 10 - self.O)
        a = rounded(z.m, -A - z.e)
        c = (a >> max(0, A - 16)) << max(0, 16 - A)
        k = rounded(c * self.constants.word("inverse_ln2"), 46)
        u, v = self.sum_and_difference(x, y)
        p, q, _ = self.rotate(-1, (u.m + v.m + 1) >> 1, (u.m - v.m + 1) >> 1, a - self.ln2(k), steps)
        g = apart(self.by_gain(Scaled(p + q if u.m else 0, u.e + k), steps))
        h = apart(self.by_gain(Scaled(p - q if v.m else 0, v.e - k), steps))
        first, second = add(g, h), add(g, Scaled(-h.m, h.e))
        return [Scaled(first.m, first.e - 1), Scaled(second.m, second.e - 1)]

    def vector_circular(self, params: Plain, more: Plain, x: Scaled, y: Scaled, z: Scaled) -> list[Result]:
        steps, H = self.steps(more), self.H
        (a, b), e = self.join(self.F, x, y)
        start = 0
        if x.m < 0:
            a, b, start = -a, -b, -H if y.m < 0 else H
        a, _, angle = self.vector(1, a, b, start, steps)
        angle = max(angle, 0 if y.m >= 0 else -H)
        angle = min(angle, H if y.m > 0 or x.m < 0 else 0)
        if x.m == y.m == 0:
            return [Scaled(0, 0), None]
        return [self.by_gain(Scaled(a, e), steps), self.angle_sum(z, params["sign"] * angle)]

    def vector_linear(self, params: Plain, more: Plain, x: Scaled, y: Scaled, z: Scaled) -> list[Result]:
        if not x.m:
            return [x, None]
        up = self.F + 1 - self.O
        _, _, q = self.vector(0, abs(x.m) << up, y.m << up, 0, self.steps(more))
        q = q * sign(x.m) * params["sign"] if y.m else 0
        quotient = apart(Scaled(q, y.e - x.e - self.A))
        return [x, add(appended(quotient, W - 4 - self.A), appended(z, W - 2 - self.O))]

    def measure(self, more: Plain, u: Scaled, v: Scaled, less: int) -> tuple[Result, int]:
        steps = self.steps(more)
        a, b = (normalise(Scaled(abs(each.m), each.e), self.F) for each in (u, v))
        differ = bool(u.m and v.m) and (u.m < 0) != (v.m < 0)
        near = any(each.m <= row(more["slack"], "places", each.e - less) for each in (a, b))
        zero = not u.m or not v.m or (differ and near)
        if (a.e + b.e) % 2:
            if a.m < b.m:
                a = Scaled(a.m << 1, a.e - 1)
            else:
                b = Scaled(b.m << 1, b.e - 1)
        x, _, angle = self.vector(-1, (a.m + b.m + 1) >> 1, (a.m - b.m + 1) >> 1, 0, steps)
        root = self.by_gain(Scaled(0 if zero else x, (a.e + b.e) >> 1), steps)
        angle += self.ln2(0 if zero else (a.e - b.e) >> 1)
        return (None if differ and not zero else root), angle

    def lightcone(self, params: Plain, more: Plain, u: Scaled, v: Scaled) -> list[Result]:
        root, angle = self.measure(more, u, v, 0)
        return [root, Scaled(angle, -self.A) if u.m * v.m > 0 else None]

    def vector_hyperbolic(self, params: Plain, more: Plain, x: Scaled, y: Scaled, z: Scaled) -> list[Result]:
        u, v = self.sum_and_difference(x, y)
        norm, angle = self.measure(more, u, v, max(x.e, y.e) if more["slack"]["relative"] else 0)
        sizes = [abs(Fraction(each.m) * Fraction(2) ** each.e) for each in (x, y)]
        return [norm, self.angle_sum(z, params["sign"] * angle) if sizes[1] < sizes[0] else None]

    def implicit_circular(self, params: Plain, more: Plain, A: Scaled, B: Scaled, C: Scaled) -> list[Result]:
        steps, reach, H, plus = self.steps(more), more["reach"], self.H, params["branch"] == "+"
        (x, y, T), e = self.join(self.F, A, B, C)
        x = -x if plus else x
        turned = (A.m > 0 or (A.m == 0 and B.m < 0)) if plus else A.m < 0
        x, y, start = (-x, -y, -H) if turned else (x, y, 0)
        alone = not A.m or not B.m
        c = abs(T) - abs(x) - abs(y)
        at_end = alone and c <= row(reach, "slack", e) and -c <= row(reach, "within", e)
        end = self.Q if A.m else (0 if (y < 0) == (T < 0) else H)
        beta = sign(T)
        y, T, z = beta * y, beta * T, 0
        if self.data["rule"] == "single-rotation" and y < 0:
            x, y, z = -y, x, self.Q
        upper = self.constants.data["upper"] << (self.F - 4) <= T
        width = row(reach, "room", e) + (row(reach, "rise", e) if upper else 0) | 7
        near = None if alone else (row(reach, "height", e), width)
        x, y, T, z = self.implicit(1, x, y, T, z, near, steps)
        t = start + beta * (end if at_end else z)
        t = min(max(t, -H), 0) if not A.m and B.m > 0 else min(max(t, -2 * H), 2 * H)
        t = -t if plus else t
        rest = self.by_gain(Scaled(0 if at_end else max(x, 0), e), steps)
        solved = c <= row(reach, "slack", e) if alone else T - y <= row(reach, "short", e)
        return [Scaled(t, -self.A), rest] if solved and (A.m or B.m) else [None, None]

    def log2(self, number: Scaled) -> int:
        m, e = normalise(Scaled(abs(number.m), number.e), 9)
        return (e + 8) * 256 + m - 256

    def implicit_hyperbolic(
        self, params: Plain, more: Plain, A: Scaled, B: Scaled, C: Scaled
    ) -> list[Result]:
        steps, reach, branch = self.steps(more), more["reach"], params["branch"]
        if C.m < 0:
            A, B, C = (Scaled(-each.m, each.e) for each in (A, B, C))
        p, q = self.sum_and_difference(B, A)
        both = p.m > 0 and q.m > 0
        mirrored = p.m <= 0 or (branch == "-" and q.m > 0)
        possible = q.m > 0 if mirrored else p.m > 0
        if branch == "none" and both:
            possible = False
        p, q = (q, p) if mirrored else (p, q)
        n = max(self.log2(C), (self.log2(p) + self.log2(q)) >> 1)
        k = min(max((n - self.log2(p) + 288) >> 8, -1024), 1024)
        p, q, c = Scaled(p.m, p.e + k), apart(Scaled(q.m, q.e - k)), Scaled(C.m, C.e + 1)
        V = max(p.e + self.F, q.e + self.F, c.e + self.O) - self.F - 8
        first, second, T = (rounded(each.m, V - each.e) for each in (p, q, c))
        x, y = first - second, first + second
        down = 9 if max(abs(x), abs(y), abs(T)) > 1 << (self.F + 8) else 8
        x, y, T, e = rounded(x, down), rounded(y, down), rounded(T, down), V + down
        alone = both and not A.m
        scale = self.constants.data["root_scale"]
        root = self.constants.data["roots"][min(abs(T) >> (self.F - 4), 16)]
        width = (row(reach, "room", e - 1) + (row(reach, "rise", e - 1) * root + scale - 1) // scale) | 7
        near = (row(reach, "height", e - 1), width) if both and A.m else None
        x, y, T, z = self.implicit(-1, x, y, T, 0, near, steps)
        t = (z + self.ln2(k)) * (-1 if mirrored else 1)
        (b_size, c_size), known = self.join(self.F, B, C)
        less = abs(b_size) - abs(c_size)
        if alone and less <= row(reach, "slack", known) and -less <= row(reach, "within", known):
            t = x = 0
        reached = y - T <= row(reach, "short", e - 1) and T - y <= row(reach, "beyond", e - 1)
        possible &= less <= row(reach, "slack", known) if alone else reached
        if not possible or not (C.m or q.m):
            return [None, None]
        return [Scaled(t, -self.A), self.by_gain(Scaled(max(x, 0), e - 1), steps)]


class Interpreter:
    """Runs the operations of a plan, one sample of words at a time."""

    def __init__(self, data: Plain) -> None:
        self.data = data
        format_ = data["target_data"]["arithmetic"]["format"]
        self.inside = format_["width"] + format_.get("guard", 0)
        self.rounding = format_.get("rounding", "half-up")
        cordic = data["cordic"]
        self.constants = Constants(cordic["constants"])
        self.units = {kind: Unit(unit, cordic["constants"]) for kind, unit in cordic["units"].items()}

    def run(self, words: dict[str, int]) -> dict[str, int | None]:
        """Return words of outputs, None for each of a sample that is invalid."""
        points = self.data["formats"]["values"]
        values = {
            name: Typed(word, points[name]["width"], points[name]["fraction"]) for name, word in words.items()
        }
        waiting = list(self.data["operations"])
        while waiting:
            ready = [
                o for o in waiting if all(i.get("value", next(iter(values))) in values for i in o["operands"])
            ]
            for operation in ready:
                values |= self.operation(operation, values)
            waiting = [o for o in waiting if o not in ready]
        outputs = {}
        for name, item in self.data["outputs"].items():
            point = self.data["formats"]["outputs"][name]
            taken = self.operand(item, values)
            outputs[name] = None if taken.word is None else self.word(taken.word, taken.fraction, point)
        return outputs if None not in outputs.values() else dict.fromkeys(outputs)

    def operand(self, item: Plain, values: dict[str, Typed]) -> Typed:
        return self.constant(item["constant"]) if "constant" in item else values[item["value"]]

    def constant(self, text: str) -> Typed:
        number, largest = Fraction(text), (1 << (self.inside - 1)) - 1
        if not number:
            return Typed(0, self.inside, self.inside - 1)
        fraction = 160
        while abs(round(number * Fraction(2) ** fraction)) > largest:
            fraction -= 1
        return Typed(round(number * Fraction(2) ** fraction), self.inside, fraction)

    def operation(self, operation: Plain, values: dict[str, Typed]) -> dict[str, Typed]:
        op, params, kind = operation["op"], operation["params"], operation["kind"]
        operands = [self.operand(item, values) for item in operation["operands"]]
        results: list[Result]
        if any(operand.word is None for operand in operands):
            results = [None] * len(operation["results"])
        elif kind in self.units:
            more = self.data["cordic"]["operations"][operation["id"]]
            results = self.units[kind].run(op, params, more, operands)
        else:
            slack = operation.get("slack", {}).get("beyond", 0.0)
            results = [self.plain(op, params, slack, operands)]
        angle = {"vector": 1, "implicit": 0}.get(op) if params.get("m") == 1 else None
        angle = 0 if op == "wrap" else angle
        most = 1 << (self.units[kind].data["exponent_bits"] - 1) if kind in self.units else 1 << 20
        found = {}
        for at, (name, result) in enumerate(zip(operation["results"], results, strict=True)):
            if name is not None:
                point = self.data["formats"]["values"][name]
                word = None
                if result is not None and abs(result.m).bit_length() + result.e <= most:
                    tiny = abs(result.m).bit_length() + result.e <= -most
                    word = self.word(0 if tiny else result.m, -result.e, point, at == angle)
                found[name] = Typed(word, point["width"], point["fraction"])
        return found

    def word(self, m: int, fraction: int, point: Plain, is_angle: bool = False) -> int | None:
        """Return m 2^-fraction as a word of a format, None where it is invalid."""
        down = fraction - point["fraction"]
        if down <= 0 or self.rounding == "half-up":
            word = rounded(m, down)
        else:
            odd = (m >> down) & 1
            word = (m + ((1 << (down - 1)) - 1 + odd if self.rounding == "half-even" else 0)) >> down
        if abs(word) > (1 << (point["width"] - 1)) - 1:
            return None
        if is_angle and point["width"] - point["fraction"] >= 3:
            bits = self.constants.fraction("pi")
            pi = self.constants.word("pi")
            most = pi >> (bits - point["fraction"])
            limit = pi + (1 << (bits - 2 - point["fraction"]))
            if abs(word) > most and abs(m) << (bits - fraction) <= limit:
                return sign(word) * most
        return word

    def plain(self, op: str, params: Plain, slack: float, operands: list[Typed]) -> Result:
        exact = [Scaled(int(operand.word or 0), -operand.fraction) for operand in operands]
        first = exact[0]
        if op in ("mul", "cmul"):
            factor = self.constant(params["factor"]) if op == "cmul" else operands[1]
            return Scaled(first.m * int(factor.word or 0), first.e - factor.fraction)
        if op == "shift":
            return Scaled(first.m, first.e + params["exponent"])
        if op == "sign":
            return Scaled((first.m > 0) - (first.m < 0), 0)
        if op == "wrap":
            return self.wrapped(operands[0])
        e = min(each.e for each in exact)
        a, *more = (each.m << (each.e - e) for each in exact)
        if op == "guard":
            s = more[0]
            holds = {
                "any": True,
                "nonzero": s != 0,
                "positive": s > 0,
                "nonnegative": s * Fraction(2) ** e >= -Fraction(slack),
            }
            return Scaled(a, e) if holds[params["condition"]] else None
        if op == "select":
            return Scaled(more[0] if a >= 0 else more[1], e)
        b = more[0] if more else 0
        results = {
            "add": a + b,
            "sub": a - b,
            "min": min(a, b),
            "max": max(a, b),
            "neg": -a,
            "abs": abs(a),
            "flip": a if b >= 0 else -a,
        }
        return Scaled(results[op], e)

    def wrapped(self, angle: Typed) -> Scaled:
        word, f = int(angle.word or 0), angle.fraction
        if f >= 31:
            return Scaled(word, -f)
        g, n = 27, 32
        if 2 * f < angle.width + 4:
            g = n = 33 + max(0, angle.width - f)
        word, f = word << max(0, -f), max(0, f)
        turn = ((1 << (n + 119)) * 2 + self.constants.word("pi")) // (2 * self.constants.word("pi"))
        assert self.constants.fraction("pi") == 120
        k = rounded(word * turn, f + n)
        return Scaled((word << g) - k * self.constants.pi(f + g + 1), -(f + g))
