"""The chosen options as a graph, with the guards that keep its conditions."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from cordicc.ir.graph import Graph, Value
from cordicc.rewrite.exact.algebra import Algebra
from cordicc.rewrite.exact.values import Store
from cordicc.rewrite.search.conditions import Requirement
from cordicc.rewrite.search.costs import UNITS
from cordicc.rewrite.search.extraction import Extraction
from cordicc.rewrite.search.options import Alternatives, Option

_UNIT_WORDS = {
    "rotate": "a rotation",
    "vector": "a vectoring",
    "lightcone": "a vectoring",
    "implicit": "an implicit equation",
}


def rebuild(
    store: Store,
    choice: Alternatives,
    needs: Sequence[Requirement],
    extraction: Extraction,
    graph: Graph,
) -> tuple[Graph, dict[int, tuple[str, ...]], dict[Value, Value]]:
    """Return the graph of an extraction, the steps that lead to its nodes, and its values in the store."""
    builder = Algebra()
    for node in graph.nodes:
        if node.op == "input":
            builder.emit("input", (), node.params)
    made: dict[int, tuple[Value, ...]] = {}
    steps: dict[int, tuple[str, ...]] = {}
    sources: dict[Value, Value] = {}

    def value_of(wanted: int) -> Value:
        todo = [wanted]
        while todo:
            number = extraction.provider[todo[-1]]
            option = choice.options[number]
            pending = [k for k in option.operands if extraction.provider[k] not in made]
            if number in made or not pending:
                todo.pop()
                if number not in made:
                    operands = [result_of(k) for k in option.operands]
                    builder.origin = store.algebra.nodes[option.node].origin
                    before = len(builder.nodes)
                    made[number] = builder.apply(option.op, operands, option.params)
                    why = _steps(store, option)
                    for index in range(before, len(builder.nodes)):
                        steps.setdefault(index, why)
                    for result, value in enumerate(made[number]):
                        sources.setdefault(value, option.value(result))
            else:
                todo += pending
        return result_of(wanted)

    def result_of(k: int) -> Value:
        number = extraction.provider[k]
        results = choice.options[number].results
        return made[number][next(r for r, ks in enumerate(results) if k in ks)]

    outputs = {name: value_of(k) for name, k in choice.wanted.items()}
    first = next(iter(outputs))
    kept = outputs[first]
    used = _used(builder, outputs.values())
    chosen_guards = set(extraction.guards)
    for index, need in enumerate(needs):
        met = [value_of(k) for k, o in need.met_by if extraction.provider.get(k) == o]
        if met:
            # One that an output takes anyway needs no guard.
            subject, condition = next((v for v in met if v in used), met[0]), "any"
        elif index in chosen_guards and need.subject is not None:
            subject, condition = value_of(need.subject), need.condition
        else:
            raise AssertionError("a condition is lost")
        if condition != "any" or subject not in used:
            kept = builder.guard(kept, subject, condition)
            used |= _used(builder, [subject])
    outputs[first] = kept
    live = Graph(tuple(builder.nodes), outputs).live()
    kept_nodes = [i for i, node in enumerate(builder.nodes) if i in live or node.op == "input"]
    told = {new: steps[old] for new, old in enumerate(kept_nodes) if steps.get(old)}
    new_index = {old: new for new, old in enumerate(kept_nodes)}
    known = {Value(new_index[v.node], v.result): s for v, s in sources.items() if v.node in new_index}
    return builder.build(outputs), told, known


def facts_of(store: Store, choice: Alternatives, extraction: Extraction, certain: int) -> frozenset[str]:
    """Return the facts that the chosen operations rest on; more may be named, none is left out.

    The first `certain` nodes of the store are the equations as they stand, which rest on no fact.  Where
    another node stands for one of them, both rest on what they and their operands were simplified by.
    """
    chosen = {choice.options[number].node for number in extraction.provider.values()}
    members: dict[Value, set[int]] = {}
    for index in {*chosen, *range(certain)}:
        for r in range(len(store.algebra.nodes[index].definition.results)):
            members.setdefault(store.find(Value(index, r)), set()).add(index)
    equal = [each for each in members.values() if len(each) > 1 and not each.isdisjoint(chosen)]
    new = {index for index in chosen if index >= certain}
    todo, seen, facts = sorted(new.union(*equal)), set[int](), frozenset[str]()
    while todo:
        index = todo.pop()
        if index not in seen:
            seen.add(index)
            facts |= store.rests.get(index, frozenset())
            todo += [v.node for v in store.algebra.nodes[index].operands]
    return facts


def _steps(store: Store, option: Option) -> tuple[str, ...]:
    """Return the steps that lead to a CAU or to a sum of angles."""
    if option.op == "wrap":
        return ("equal modulo `2*pi` to the angle that is wanted, and wrapped",)
    angle = store.rotors.known_rotor(Value(option.node)) is not None
    if option.op not in UNITS and not (option.op in ("add", "sub") and angle):
        return ()
    rests = tuple(f"rests on the fact `{fact}`" for fact in sorted(store.rests.get(option.node, ())))
    return (*store.why.get(option.node, ()), *_taken_for(store, option), *rests)


def _taken_for(store: Store, option: Option) -> tuple[str, ...]:
    """Return a sentence for each result that stands for what another kind of unit would make."""
    node = store.algebra.nodes[option.node]
    sentences = []
    for result, name in enumerate(node.definition.results):
        own = store.find(Value(option.node, result))
        for index, other in enumerate(store.algebra.nodes):
            same = [r for r in range(len(other.definition.results)) if store.find(Value(index, r)) == own]
            if same and other.op in UNITS and other.op != node.op:
                what = f"{other.definition.results[same[0]]} of {_UNIT_WORDS[other.op]}"
                sentences.append(f"its {name} equals the {what} in `{other.origin}`, by algebra")
                break
    return tuple(sentences)


def _used(builder: Algebra, values: Iterable[Value]) -> set[Value]:
    """Return the values on the way to others, themselves included."""
    todo = list(values)
    found = set(todo)
    seen: set[int] = set()
    while todo:
        index = todo.pop().node
        if index not in seen:
            seen.add(index)
            found.update(builder.nodes[index].operands)
            todo.extend(builder.nodes[index].operands)
    return found
