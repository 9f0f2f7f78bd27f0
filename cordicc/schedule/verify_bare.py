"""Independent verification of the schedule of a bare graph, from its question and answer as plain data."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from typing import Any


def verify_bare(question: Mapping[str, Any], answer: Mapping[str, Any]) -> None:
    """Raise AssertionError unless an answer keeps all that its question asks.

    Both are in the JSON form of `cordicc schedule`.  Covered: every operation is scheduled and has a unit
    of its kind and of no other, dependences, no operation on a unit that another one keeps, limits,
    latency, FIFO words, bounds.  Takes linear time.
    """
    kinds = question["kinds"]
    kind = {operation["id"]: operation["kind"] for operation in question["operations"]}
    interval = question.get("initiation_interval", 1)
    start, unit = answer["start"], answer["unit"]
    assert start.keys() == unit.keys() == kind.keys(), "the operations differ"
    finish = {}
    for id, cycle in start.items():
        assert isinstance(cycle, int), f"'{id}' starts in cycle {cycle}"
        assert cycle >= 0, f"'{id}' starts in cycle {cycle}"
        finish[id] = cycle + kinds[kind[id]]["latency"]
        right = unit[id].startswith(kind[id]) and unit[id].removeprefix(kind[id]).isdigit()
        assert right, f"'{id}' is on unit '{unit[id]}'"
    wait: dict[str, int] = {}
    for producer, taker in question["edges"]:
        cycles = start[taker] - finish[producer]
        assert cycles >= 0, f"'{taker}' starts {-cycles} cycles before '{producer}' is done"
        wait[producer] = max(wait.get(producer, 0), cycles)
    kept = {name: item.get("initiation_interval", 1) for name, item in kinds.items()}
    busy = Counter(
        (unit[id], (cycle + later) % interval)
        for id, cycle in start.items()
        for later in range(kept[kind[id]])
    )
    shared = next((place for place, count in busy.items() if count > 1), None)
    assert shared is None, f"unit '{shared and shared[0]}' has several operations in a slot"
    of_kind: dict[str, str] = {}
    for id, name in unit.items():
        assert of_kind.setdefault(name, kind[id]) == kind[id], f"unit '{name}' is of several kinds"
    used = Counter(of_kind.values())
    for name, item in kinds.items():
        limit = item.get("limit")
        assert limit is None or used[name] <= limit, f"{used[name]} units of kind '{name}', limit {limit}"
    latency = max(finish.values(), default=0)
    assert answer["latency"] == latency, f"latency {answer['latency']}, expected {latency}"
    words = sum(wait.values())
    assert answer["fifo_words"] == words, f"FIFO words {answer['fifo_words']}, expected {words}"
    figures = {"latency": latency, "fifo_words": words, "processors": sum(used.values())}
    for name, bound in answer["bounds"].items():
        assert bound <= figures[name], f"{name}: {figures[name]} is below its bound {bound}"
        optimal = answer["optimal"][name]
        assert not optimal or bound == figures[name], f"{name}: called optimal with bound {bound}"
