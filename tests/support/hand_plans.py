"""Plans for tests of what comes after scheduling: hand-written operations and a small ASAP scheduler."""

from __future__ import annotations

import random
from dataclasses import dataclass, field
from typing import Any

from cordicc.plan.model import Fifo, Operand, Operation, Plan, Unit
from cordicc.plan.origin import PlanEquation, PlanOptions
from cordicc.plan.stated_accuracy import OutputAccuracy, SeenErrors
from tests.support.origins import problem_of, target_of

LATENCY = {"standard": 44, "implicit": 48, "mul": 4, "cmul": 4, "add": 3, "shift": 0, "sign": 0}
KIND = {
    "add": "add", "sub": "add", "mul": "mul", "cmul": "cmul", "shift": "shift", "neg": "sign", "abs": "sign",
    "flip": "sign", "guard": "sign", "vector": "standard", "rotate": "standard", "implicit": "implicit",
}  # fmt: skip
PORTS = {
    "add": "a b", "sub": "a b", "mul": "a b", "cmul": "a", "shift": "a", "neg": "a", "abs": "a",
    "flip": "a s",
    "guard": "a s", "vector": "x y z", "rotate": "x y z", "implicit": "A B C",
}  # fmt: skip
RESULTS = {"vector": "norm angle", "rotate": "x y", "implicit": "angle rest"}
SYSTEM = {"1": "circular", "0": "linear", "-1": "hyperbolic"}


@dataclass
class Builder:
    """Collects operations, then schedules them as soon as possible, each on a unit of its own."""

    name: str
    inputs: dict[str, tuple[float, float]]
    description: str = ""
    operations: list[dict[str, Any]] = field(default_factory=list)

    def add(self, op: str, *operands: str | float, equation: str = "", **params: Any) -> tuple[str, ...]:
        name = f"o{len(self.operations)}"
        results = tuple(f"{name}.{port}" for port in RESULTS.get(op, "value").split())
        self.operations.append(
            {
                "id": name,
                "op": op,
                "operands": operands,
                "results": results,
                "params": params,
                "equation": equation,
            }
        )
        return results

    def plan(self, outputs: dict[str, str | float], equations: list[tuple[str, str]] = ()) -> Plan:  # type: ignore[assignment]
        ready = dict.fromkeys(self.inputs, 0)
        counts: dict[str, int] = {}
        units, operations = [], []
        used = {item for o in self.operations for item in o["operands"]} | set(outputs.values())
        for item in self.operations:
            kind = KIND[item["op"]]
            start = max([ready[o] for o in item["operands"] if isinstance(o, str)], default=0)
            finish = start + LATENCY[kind]
            ready |= dict.fromkeys(item["results"], finish)
            counts[kind] = counts.get(kind, 0) + 1
            unit = Unit(f"{kind}{counts[kind]}", kind, LATENCY[kind])
            units.append(unit)
            operations.append(
                Operation(
                    item["id"],
                    item["op"],
                    item["params"],
                    kind,
                    mode_of(item),
                    unit.id,
                    start,
                    finish,
                    tuple(PORTS[item["op"]].split()),
                    tuple(operand(o) for o in item["operands"]),
                    tuple(r if r in used else None for r in item["results"]),
                    item["equation"],
                )
            )
        taken = {name: operand(value) for name, value in outputs.items()}
        latency = max([ready[v] for v in outputs.values() if isinstance(v, str)], default=0)
        fifos = segments(operations, taken, ready, latency)
        words = sum(f.depth for f in fifos)
        problem = problem_of(
            self.name,
            self.inputs,
            outputs,
            "m",
            description=self.description,
            equations=tuple(PlanEquation(t, e) for t, e in equations),
            constants={"l1": 0.4, "l2": 0.3},
            warnings=("part of the range is outside the domain, for example x = 0.1 & y < 0",),
        )
        bounds = {"processors": counts.get("standard", 0), "latency": latency, "fifo_words": words - 5}
        return Plan(
            problem, target_of(), PlanOptions(target="kinematic"), 1, latency, 44,
            tuple(units), tuple(operations),
            fifos, taken, {"processors": True, "latency": True, "fifo_words": False}, bounds,
            {name: OutputAccuracy(SeenErrors(1.25e-6, 3e-7)) for name in outputs},
        )  # fmt: skip


def mode_of(item: dict[str, Any]) -> str:
    op, params = item["op"], item["params"]
    system = SYSTEM[str(params.get("m", 1))]
    words = {
        "vector": f"{system} vectoring",
        "rotate": f"{system} rotation",
        "cmul": f"times {params.get('factor')}",
    }
    if op == "implicit":
        return f"implicit {system}, branch {params.get('branch', '+')}"
    return words.get(op, op)


def operand(item: str | float) -> Operand:
    return Operand(value=item) if isinstance(item, str) else Operand(constant=repr(item))


def segments(
    operations: list[Operation], outputs: dict[str, Operand], ready: dict[str, int], latency: int
) -> tuple[Fifo, ...]:
    taps: dict[str, dict[int, list[str]]] = {}
    for op in operations:
        for port, item in zip(op.ports, op.operands, strict=True):
            if item.value is not None and op.start > ready[item.value]:
                taps.setdefault(item.value, {}).setdefault(op.start, []).append(f"{op.id}.{port}")
    for name, item in outputs.items():
        if item.value is not None and latency > ready[item.value]:
            taps.setdefault(item.value, {}).setdefault(latency, []).append(f"out.{name}")
    maker = {r: op.id for op in operations for r in op.results if r}
    fifos: list[Fifo] = []
    for value, ends in taps.items():
        source, begin = maker.get(value, value), ready[value]
        ordered = sorted(ends)
        for index, end in enumerate(ordered):
            name = f"f{len(fifos)}"
            chained = (f"f{len(fifos) + 1}",) if index + 1 < len(ordered) else ()
            fifos.append(Fifo(name, value, source, (*ends[end], *chained), end - begin, 32))
            source, begin = name, end
    return tuple(fifos)


def wheel() -> Plan:
    """Joint beta of the wheel suspension on standard CAUs, as in Fig. 2 of the paper."""
    b = Builder("wheel-beta", {"S": (0.2, 0.4)}, "Wheel suspension, first joint.")
    eq = "beta"
    (a,) = b.add("cmul", "S", factor="0.5", equation="A")
    (bb,) = b.add("cmul", "S", factor="0.25", equation="B")
    (s2,) = b.add("mul", "S", "S", equation="C")
    (c,) = b.add("add", s2, 0.0625, equation="C")
    norm, psi = b.add("vector", bb, a, 0.0, m=1, sign=1, equation=eq)
    root, _ = b.add("vector", norm, c, 0.0, m=-1, sign=1, equation=eq)
    _, beta = b.add("vector", c, root, psi, m=1, sign=-1, equation=eq)
    return b.plan(
        {"beta": beta},
        [("A", "2*(V2y - V1y)*S"), ("B", "2*V2z*S"), ("beta", "atan(A/B) - atan(sqrt(R**2 - C**2)/C)")],
    )


def planar() -> Plan:
    """Planar two-link arm with implicit CAUs."""
    b = Builder("planar-2r", {"x": (0.2, 0.45), "y": (-0.2, 0.4)}, "Two-link arm, elbow down.")
    (x2,) = b.add("mul", "x", "x", equation="r2")
    (y2,) = b.add("mul", "y", "y", equation="r2")
    (r2,) = b.add("add", x2, y2, equation="r2")
    (d,) = b.add("sub", r2, 0.25, equation="theta2")
    (e,) = b.add("add", r2, 0.07, equation="theta1")
    (k,) = b.add("cmul", e, factor="1.25", equation="theta1")
    theta2, _ = b.add("implicit", 0.0, 0.24, d, m=1, branch="+", equation="theta2")
    theta1, rest = b.add("implicit", "y", "x", k, m=1, branch="-", equation="theta1")
    (neg,) = b.add("neg", theta1, equation="theta1")
    (ok,) = b.add("guard", neg, rest, condition="nonnegative", equation="theta1")
    return b.plan(
        {"theta1": ok, "theta2": theta2},
        [("r2", "x**2 + y**2"), ("theta2", "acos((r2 - l1**2 - l2**2)/(2*l1*l2))")],
    )


def puma(seed: int = 3, caus: int = 12, small: int = 40) -> Plan:
    """A random plan of the size of a PUMA 560's."""
    rng = random.Random(seed)
    names = ["px", "py", "pz", "r13", "r23", "r33", "r12", "r22", "r32"]
    b = Builder("puma-560", dict.fromkeys(names, (-1.0, 1.0)), "Six joints, random stand-in.")
    pool = list(names)
    angles: list[str] = []
    groups = [caus // 4] * 3 + [caus - 3 * (caus // 4)]
    for stage, count in enumerate(groups):
        for _ in range(small // 4):
            op = rng.choice(["mul", "mul", "add", "sub", "cmul", "neg"])
            picks = [rng.choice(pool[-12:] if rng.random() < 0.85 else pool) for _ in range(2)]
            if op in ("cmul", "neg"):
                picks, params = picks[:1], {"factor": "0.4318"} if op == "cmul" else {}
            else:
                params = {}
            pool += b.add(op, *picks, equation=f"t{stage}", **params)
        for _ in range(count):
            op = rng.choice(["implicit", "vector", "rotate"])
            picks = rng.sample(pool[-9:], 3 if op != "vector" else 2)
            extra = [] if op != "vector" else [0.0]
            first, second = b.add(op, *picks, *extra, m=1, branch="+", sign=1, equation=f"theta{len(angles)}")
            angles.append(first if op == "implicit" else second)
            pool += [first, second]
    return b.plan(
        {f"theta{i + 1}": angle for i, angle in enumerate(angles[-6:])}, [("theta1", "atan2(py, px)")]
    )
