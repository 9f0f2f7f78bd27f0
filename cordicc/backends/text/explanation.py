"""`cordicc explain`: what was recognised, what each unit of a plan does, why there is no cheaper plan."""

from __future__ import annotations

from collections.abc import Iterator

from cordicc.backends.labels import MOST, most_within, turned_down
from cordicc.backends.text.formulas import Formulas
from cordicc.backends.text.recognition import Recognised, recognised
from cordicc.backends.text.summary import count
from cordicc.base.text_tables import Block, Facts, Heading, Sheet, percent
from cordicc.plan.model import Operation, Plan
from cordicc.plan.stated_accuracy import OutputAccuracy, SeenErrors
from cordicc.targets.target import CAU_KINDS

_GOALS = {
    "processors": "CAUs, then multipliers of two variables, then latency, then FIFO words",
    "latency": "latency, then CAUs, then multipliers of two variables, then FIFO words",
    "fifo": "FIFO words, then CAUs, then multipliers of two variables, then latency",
    "area": "the target's area figures, then CAUs, multipliers of two variables, latency, FIFO words",
}
_UNITS = {
    "auto": "",
    "standard": " without implicit CAUs (--units standard)",
    "implicit": ", implicit CAUs preferred (--units implicit)",
}


def explanation(plan: Plan) -> Sheet:
    """Return a plan in words."""
    formulas = Formulas(plan)
    blocks: list[Block] = [Heading("What was recognised"), *_recognised(plan, formulas)]
    units = list(_units(plan, formulas))
    blocks += [Heading("What each CAU does"), *(units or ["  There is none: the plan does without."])]
    ends = _ends(plan, formulas)
    if ends:
        blocks += [Heading("What leaves"), Facts(tuple(ends))]
    between = _between(plan, formulas)
    if between:
        blocks += [Heading("Between them"), Facts(tuple(between))]
    known = all(plan.optimal.values()) and plan.selection.proven
    blocks.append(Heading("Why there is no cheaper plan" if known else "What is known of cheaper plans"))
    blocks.append(Facts(tuple(_reasons(plan, formulas))))
    blocks += [Heading("How accurate it is"), Facts(tuple(_accuracy(plan)))]
    if plan.checks:
        blocks += [Heading("What is 0 on a perfect answer"), Facts(tuple(_checks(plan)))]
    return Sheet(f"{plan.name} on {plan.target.name}", tuple(blocks))


def _recognised(plan: Plan, formulas: Formulas) -> Iterator[Block]:
    """Yield, by equation, why its operations do what it says, and which they are."""
    before = None
    for equation in recognised(plan, formulas):
        if equation.text != before or not equation.text:  # coupled ones share their text
            yield f"  {equation.text or equation.target or 'of no single equation'}"
        before = equation.text
        yield from _why(equation)


def _why(equation: Recognised) -> Iterator[Block]:
    told: set[str] = set()
    for unit in (*equation.units, *equation.others):
        for why in unit.why:
            if why not in told:
                yield f"      {_sentence(why)}"
            told.add(why)
        yield f"      -> {_placed(unit.operation)}"
    if equation.rest:
        yield f"      {equation.rest}"


def _sentence(text: str) -> str:
    return text[:1].upper() + text[1:] + ("" if text.endswith(".") else ".")


def _placed(operation: Operation) -> str:
    return f"{operation.id}, {operation.mode}, on {operation.unit}"


def _units(plan: Plan, formulas: Formulas) -> Iterator[Block]:
    for unit in plan.units:
        if unit.kind not in CAU_KINDS:
            continue
        mine = sorted((o for o in plan.operations if o.unit == unit.id), key=lambda o: (o.start, o.id))
        shared = "" if len(mine) == 1 else f", {len(mine)} operations take turns"
        yield f"  {unit.id}, {unit.kind}, {count(unit.latency, 'cycle')}{shared}"
        rows = []
        for operation in mine:
            lines = [formula.text for formula in formulas.of(operation)]
            lines[0] += _branch(operation)
            rows.append((f"{operation.id}, cycles {operation.start} to {operation.finish}", lines[0]))
            rows += [("", line) for line in lines[1:]]
        yield Facts(tuple(rows), indent=6)


def _branch(operation: Operation) -> str:
    branch = operation.params.get("branch", "none")
    return "" if branch == "none" else f", branch {branch}"


def _ends(plan: Plan, formulas: Formulas) -> list[tuple[str, str]]:
    """Return the outputs that are not results of CAUs as they are."""
    makers = {name: o for o in plan.operations for name in o.results if name is not None}
    rows = []
    for name, operand in plan.outputs.items():
        maker = makers.get(operand.value or "")
        if maker is not None and operand.value is not None:
            symbol = formulas.symbol(operand.value).text
            if symbol != name:
                rows.append((name, f"= {symbol}"))
            elif maker.kind not in CAU_KINDS:
                rows.append(_defined(maker, formulas))
        else:
            rows.append((name, f"= {formulas.operand(operand).text}"))
    return rows


def _between(plan: Plan, formulas: Formulas) -> list[tuple[str, str]]:
    """Return the operators' results that formulas name, each with its own."""
    leaving = {operand.value for operand in plan.outputs.values()}
    small = [o for o in plan.operations if o.kind not in CAU_KINDS and o.results[0] is not None]
    named = [o for o in small if o.results[0] not in leaving and not formulas.written_out(str(o.results[0]))]
    return [_defined(operation, formulas) for operation in named]


def _defined(operation: Operation, formulas: Formulas) -> tuple[str, str]:
    """Return the name of an operator's result and what it is."""
    name, _, right = formulas.of(operation)[0].text.partition(" = ")
    return name, f"= {right}"


def _reasons(plan: Plan, formulas: Formulas) -> Iterator[tuple[str, str]]:
    minimize = plan.options.minimize
    units = _UNITS.get(plan.options.units, "")
    yield "goals", f"{_GOALS.get(minimize, minimize)}{units}"
    yield "operations", _choice(plan)
    yield "CAUs", _processors(plan)
    yield "latency", _latency(plan)
    yield "FIFO words", _words(plan, formulas)
    if plan.options.time_limit_struck:
        yield "stopped", "by --time-limit, so searches ended early"


def _choice(plan: Plan) -> str:
    """Say how the operations were chosen, and what was not among the alternatives."""
    left_out = "".join(f"; left out: {words}" for words in plan.selection.left_out)
    return _found(plan) + left_out


def _found(plan: Plan) -> str:
    if not plan.selection.searched:
        return "as the rules give them; alternatives were not searched, so other operations may be cheaper"
    found = "the cheapest of the alternatives that rewriting finds, each proven equal to the equations"
    if plan.selection.turned_down:
        found += f"; {turned_down(plan)}"
    if plan.selection.proven:
        return f"{found}; constraint programming proves that no set of these is cheaper"
    return f"{found}; not proven the cheapest of these"


def _processors(plan: Plan) -> str:
    total, interval = plan.processors()["total"], plan.initiation_interval
    operations = [o for o in plan.operations if o.kind in CAU_KINDS]
    each = "one" if interval == 1 else f"up to {interval}"
    parts = []
    for kind in CAU_KINDS:
        number = sum(o.kind == kind for o in operations)
        if number:
            least = -(-number // interval)
            units = count(least, "unit")
            parts.append(
                f"{count(number, f'{kind} operation')}, {each} a unit at interval {interval}, take {units}"
            )
    said = "; ".join(parts) or "no operation needs one"
    return f"{total}: {said}; {_verdict(plan, 'processors', total)}"


def _verdict(plan: Plan, name: str, figure: int) -> str:
    if plan.optimal[name]:
        return "proven the least for these operations"
    bound = plan.bounds[name]
    return f"proven is at least {bound}, so at most {figure - bound} fewer are possible"


def _latency(plan: Plan) -> str:
    chain = _chain(plan)
    path = " -> ".join(f"{o.id} {o.kind} {o.finish - o.start}" for o in chain)
    cycles = sum(o.finish - o.start for o in chain)
    verdict = _verdict(plan, "latency", plan.latency_cycles)
    if cycles == plan.latency_cycles:
        return f"{count(cycles, 'cycle')}, the longest chain of operations ({path}); {verdict}"
    waits = plan.latency_cycles - cycles
    return (
        f"{count(plan.latency_cycles, 'cycle')}: the longest chain takes {cycles} ({path}), "
        f"{waits} more as operations share units; {verdict}"
    )


def _chain(plan: Plan) -> list[Operation]:
    """Return the operations with cycles on a longest chain."""
    makers = {name: o for o in plan.operations for name in o.results if name is not None}
    longest: dict[str, tuple[int, list[Operation]]] = {}
    for operation in sorted(plan.operations, key=lambda o: (o.start, o.finish)):
        before = [
            longest[makers[item.value].id]
            for item in operation.operands
            if item.value in makers and makers[item.value].id in longest
        ]
        cycles, path = max(before, key=lambda way: way[0], default=(0, []))
        own = operation.finish - operation.start
        longest[operation.id] = cycles + own, [*path, operation] if own else path
    return max(longest.values(), key=lambda way: way[0], default=(0, []))[1]


def _words(plan: Plan, formulas: Formulas) -> str:
    if not plan.fifos:
        return "0: nothing waits"
    most = max(plan.fifos, key=lambda fifo: fifo.depth)
    where = (
        f"the deepest, {most.id}, holds {formulas.symbol(most.value).text} for {count(most.depth, 'word')}"
    )
    at = "" if plan.options.minimize == "fifo" else " at this latency"
    verdict = _verdict(plan, "fifo_words", plan.fifo_words)
    return f"{plan.fifo_words} in {count(len(plan.fifos), 'FIFO')}{at}; {where}; {verdict}"


def _accuracy(plan: Plan) -> Iterator[tuple[str, str]]:
    for output in plan.problem.outputs:
        name, unit = output.name, " rad" if output.is_angle else ""
        figures = plan.accuracy.get(name)
        if figures is None:
            yield name, "not measured"
        else:
            yield name, f"{_seen(figures.observed, unit)}; {_bound(figures, unit)}"


def _checks(plan: Plan) -> Iterator[tuple[str, str]]:
    """Yield how far each check is from 0."""
    for name, figures in plan.checks.items():
        check, seen = plan.problem.check(name), figures.observed
        unit = f" {check.unit}" if check.unit else ""
        if seen.max is None:
            yield name, "no valid sample has a value"
            continue
        allowed = "" if check.max is None else f"; at most {check.max:.3g}{unit} is allowed"
        missing = f"; {count(figures.undefined, 'sample')} without a value" if figures.undefined else ""
        yield (
            name,
            f"{check.text}: largest {seen.max:.3g}{unit} and rms {seen.rms:.3g}{unit} on the default samples"
            f"{allowed}{missing}",
        )


def _seen(seen: SeenErrors, unit: str) -> str:
    if seen.max is None:
        return "no sample was valid"
    return f"largest error {seen.max:.3g}{unit} and rms {seen.rms:.3g}{unit} on the default samples"


def _bound(figures: OutputAccuracy, unit: str) -> str:
    bound = figures.bound
    if bound is not None:
        share = f", {percent(bound.share_of_samples)} of the samples" if bound.conditions else ""
        own = most_within(bound)
        most = "" if own is None else f"; {MOST} of the valid samples are proven to be within {own:.3g}{unit}"
        return f"proven at most {bound.value:.3g}{unit} for {bound.where}{share}{most}"
    reason = figures.bound_reason
    return f"no bound: {reason}" if reason else "no bound derived (compile --certify derives one)"
