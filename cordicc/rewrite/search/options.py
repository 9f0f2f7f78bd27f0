"""The alternatives as data: classes of equal values, and the operations that yield them.

A value stands in two classes: one of values equal to it, and, for an angle, a wider one of angles equal
modulo 2 pi, which is all that a rotation, a wrap and a sum inside one of them ask for.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple, cast

import numpy as np

from cordicc.base.arrays import Floats
from cordicc.ir.graph import Param, Value, factored
from cordicc.ir.ops import OPS
from cordicc.rewrite.exact.values import Store
from cordicc.rewrite.passes.wraps import INSIDE

_LARGEST = 2.0**96
"""Far within the range of single precision, whose exponents end at 127."""

_SUMS = ("add", "sub", "neg")
_LINEAR = ("add", "sub", "neg", "cmul", "shift")
_USUAL = 4.0
"""How many times the error bound of the median sample is allowed to an output anywhere, or one rounding of
the largest, if that is more."""


@dataclass(frozen=True, slots=True)
class Option:
    """An operation on classes; `results` gives the classes of each result.

    They are results of the store's `node`, from number `first` on.
    """

    op: str
    params: tuple[Param, ...]
    operands: tuple[int, ...]
    results: tuple[tuple[int, ...], ...]
    node: int
    first: int = 0

    @property
    def m(self) -> int:
        """Return the coordinate system of a unit that has one."""
        return cast(int, self.params[OPS[self.op].params.index("m")])

    def value(self, result: int) -> Value:
        """Return a result as a value of the store."""
        return Value(self.node, self.first + result)

    def ways(self) -> tuple[Way, ...]:
        """Return for each result how it is made: what nodes with the same operands have in common."""
        return tuple((self.op, self.params, self.operands, result) for result in range(len(self.results)))


Way = tuple[str, tuple[Param, ...], tuple[int, ...], int]
"""Operation, parameters, classes of the operands, and the number of the result."""


class Worse(NamedTuple):
    """How many times the error bound of a value in the realisation of the passes an operation is allowed.

    `than_any`: that of the most accurate operation that yields it instead.
    """

    times: float
    than_any: bool = False


@dataclass(frozen=True, slots=True)
class Alternatives:
    """Options, the classes that are wanted, and which options yield a class."""

    options: tuple[Option, ...]
    wanted: Mapping[str, int]
    providers: Mapping[int, tuple[int, ...]]
    class_of: Callable[[Value], int]


class Classes:
    """Numbers the classes of the values of a store."""

    def __init__(self, store: Store) -> None:
        self.store = store
        self._numbers: dict[tuple[str, object], int] = {}
        self._turns: dict[object, object] = {}
        for index, node in enumerate(store.algebra.nodes):
            for result in range(len(node.definition.results)):
                value = Value(index, result)
                rotor = store.rotors.known_rotor(value)
                if rotor is not None:
                    self._join(("turn", store.find(value)), ("rotor", rotor[0].key, rotor[1].key))
        for one, other in store.turns:
            self._join(("turn", store.find(one)), ("turn", store.find(other)))

    def _root(self, token: object) -> object:
        while token in self._turns:
            token = self._turns[token]
        return token

    def _join(self, a: object, b: object) -> None:
        a, b = self._root(a), self._root(b)
        if a != b:
            self._turns[a] = b

    def exact(self, value: Value) -> int:
        """Return the class of the values equal to this one."""
        return self._numbers.setdefault(("value", self.store.find(value)), len(self._numbers))

    def exact_classes(self) -> set[int]:
        """Return the classes of equal values."""
        return {number for (kind, _), number in self._numbers.items() if kind == "value"}

    def turn(self, value: Value) -> int:
        """Return the class of the angles equal to this one modulo 2 pi."""
        token = self._root(("turn", self.store.find(value)))
        return self._numbers.setdefault(("turn", token), len(self._numbers))


def alternatives(
    store: Store,
    certain: int,
    outputs: Mapping[str, Value],
    extra: Iterable[Value],
    worse: Worse,
    banned: Collection[Value] = (),
) -> Alternatives:
    """Return all that may compute the outputs, and `extra` values that a guard may want.

    The first `certain` nodes of the store are the realisation to be no less accurate than: of another
    operation those results are left out that are one of its values with a bound of the rounding error that
    is more than `worse` times as large, and so are those in `banned` and those that are made the same way.
    """
    classes = Classes(store)
    options: list[Option] = []
    least: dict[int, Floats] = {}
    ways = {
        way
        for value in banned
        for option in _options(store, classes, value.node)
        for result, way in enumerate(option.ways())
        if option.value(result) == value
    }
    every = [_options(store, classes, index) for index in range(certain)]
    _remember(store, [made[0] for made in every if made], least)
    _ease(store, classes, outputs.values(), least, worse.times)
    every += [_options(store, classes, index) for index in range(certain, len(store.algebra.nodes))]
    if worse.than_any:
        _remember(store, [made[0] for made in every[certain:] if made], least)
        _ease(store, classes, outputs.values(), least, worse.times)
    for index, made in enumerate(every):
        if index < certain and not worse.than_any:
            options += [_without(o, lambda value, _: value in banned) for o in made]
        else:
            good = [_accurate(store, o, least, worse.times) for o in made if _moderate(store, o)]
            options += [_without(o, lambda _, way: way in ways) for o in good]
    options = _possible(options)
    providers: dict[int, list[int]] = {}
    for number, option in enumerate(options):
        for result in option.results:
            for each in result:
                providers.setdefault(each, []).append(number)
    wanted = {name: classes.exact(value) for name, value in outputs.items()}
    live = _live(options, providers, [*wanted.values(), *(classes.exact(v) for v in extra)])
    kept = [i for i in range(len(options)) if i in live]
    used = {k for i in kept for k in options[i].operands} | classes.exact_classes()
    renumber = {old: new for new, old in enumerate(kept)}
    pruned = {
        each: tuple(renumber[i] for i in made if i in renumber)
        for each, made in providers.items()
        if each in used and any(i in renumber for i in made)
    }
    return Alternatives(tuple(options[i] for i in kept), wanted, pruned, classes.exact)


def _without(option: Option, banned: Callable[[Value, Way], bool]) -> Option:
    """Return an option that does not yield some results."""
    results = tuple(
        () if banned(option.value(number), way) else result
        for number, (result, way) in enumerate(zip(option.results, option.ways(), strict=True))
    )
    return option if results == option.results else replace(option, results=results)


def _remember(store: Store, options: list[Option], least: dict[int, Floats]) -> None:
    """Note the error bound of each class of values that certain operations yield."""
    for option in options:
        for result, classes in enumerate(option.results):
            error = store.error(option.value(result))
            for k in classes:
                least[k] = np.fmin(least[k], error) if k in least else error


def _ease(
    store: Store, classes: Classes, outputs: Iterable[Value], least: dict[int, Floats], worse: float
) -> None:
    """Let the results themselves have the error bound that is usual over the samples, everywhere.

    So may what they are sums and multiples of, where nothing else takes it.
    """
    nodes = tuple(store.algebra.nodes)
    users = Counter(v for node in nodes for v in set(node.operands))
    for output in set(outputs):
        known = least.get(classes.exact(output))
        if known is None or np.isnan(known).all():
            continue
        usual = max(float(np.nanmedian(known)), float(np.nanmax(np.abs(store.numbers(output)))))
        todo = [(output, usual * (_USUAL / worse))]
        while todo:
            value, allowed = todo.pop()
            for k in (classes.exact(value), classes.turn(value)):
                if k in least:
                    least[k] = np.fmax(least[k], allowed)
            node = store.node(value)
            factor = abs(float(factored(nodes, value)[0])) if node.op in ("cmul", "shift") else 1.0
            if node.op in _LINEAR and factor:
                inner = factored(nodes, value)[1:] if node.op in ("cmul", "shift") else node.operands
                todo += [(v, allowed / factor) for v in inner if users[v] == 1]


def _accurate(store: Store, option: Option, least: Mapping[int, Floats], worse: float) -> Option:
    """Return an option without the results that are less accurate than they may be."""

    def inaccurate(value: Value, way: Way) -> bool:
        error = store.error(value)
        return not all(np.all(error / worse <= least[k]) for k in option.results[way[3]] if k in least)

    return _without(option, inaccurate)


def _moderate(store: Store, option: Option) -> bool:
    """Tell whether the results stay far from overflow and underflow of single precision."""
    for result in range(len(option.results)):
        size = np.abs(store.numbers(option.value(result)))
        if np.any(size > _LARGEST) or np.any((size < 1 / _LARGEST) & (size > 0)):
            return False
    return True


def _possible(options: list[Option]) -> list[Option]:
    """Return the options whose operands something yields."""
    while True:
        made = {k for option in options for result in option.results for k in result}
        kept = [option for option in options if made.issuperset(option.operands)]
        if len(kept) == len(options):
            return kept
        options = kept


def _live(options: list[Option], providers: Mapping[int, list[int]], roots: list[int]) -> set[int]:
    seen_classes, live, todo = set(roots), set(), list(roots)
    while todo:
        for number in providers.get(todo.pop(), ()):
            if number in live:
                continue
            live.add(number)
            for operand in options[number].operands:
                if operand not in seen_classes:
                    seen_classes.add(operand)
                    todo.append(operand)
    return live


def _is_angle(store: Store, value: Value) -> bool:
    return value in store.angles or store.rotors.known_rotor(value) is not None


def _options(store: Store, classes: Classes, index: int) -> list[Option]:
    node = store.algebra.nodes[index]
    op = node.op
    values = [Value(index, result) for result in range(len(node.definition.results))]
    exact = [classes.exact(v) for v in node.operands]
    if op == "guard":
        return []
    if op == "rotate" and node.m == 1:
        exact[2] = classes.turn(node.operands[2])
    if op == "wrap":
        exact[0] = classes.turn(node.operands[0])
    angle = node.angle
    results = tuple((classes.exact(v), classes.turn(v)) for v in values)
    found = [Option(op, node.params, tuple(exact), results, index)]
    sums = op in _SUMS or (op == "cmul" and node.factor.denominator == 1)
    sums = sums or (op == "shift" and node.exponent >= 0 and node.exponent.denominator == 1)
    if sums and all(_is_angle(store, v) for v in (values[0], *node.operands)):
        turns = tuple(classes.turn(v) for v in node.operands)
        found.append(Option(op, node.params, turns, ((classes.turn(values[0]),),), index))
    principal = angle is not None and op == "vector" and store.constant(node.operands[2]) == 0
    own = values[angle or 0]
    interval = store.range(own)
    inside = interval is not None and interval.magnitude <= INSIDE and _is_angle(store, own)
    if principal or inside:
        # A principal value: any angle equal to it modulo 2 pi gives it by a wrap.
        found.append(Option("wrap", (), (classes.turn(own),), ((classes.exact(own),),), index, own.result))
    return found
