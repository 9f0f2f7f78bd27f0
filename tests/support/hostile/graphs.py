"""Hostile graphs for `cordicc schedule`."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from typing import Any

from tests.support.hostile.cases import Case, Content


def graph(operations: int, edges: Iterable[Sequence[int]], **more: Any) -> str:
    """Return a graph of operations of one kind."""
    data = {
        "kinds": {"a": {"latency": 3}},
        "operations": [{"id": f"o{i}", "kind": "a"} for i in range(operations)],
        "edges": [[f"o{i}", f"o{j}"] for i, j in edges],
        **more,
    }
    return json.dumps(data)


def later(operations: int, edges: Iterable[Sequence[int]], **more: Any) -> Callable[[], str]:
    """Return what writes a large graph: written at once, they would delay every run."""
    return partial(graph, operations, edges, **more)


def chain(count: int) -> list[tuple[int, int]]:
    return [(i, i + 1) for i in range(count - 1)]


def dense(count: int) -> list[tuple[int, int]]:
    return [(i, j) for j in range(count) for i in range(j)]


LIMITED = {"kinds": {"a": {"latency": 3, "limit": 2}}}
SMALL = graph(3, [(0, 1), (1, 2)])

CONTENTS: dict[str, tuple[Content | Callable[[], Content], tuple[str, ...]]] = {
    "nothing": ("", ("E801",)),
    "null": ("null", ("E801",)),
    "a list": ("[]", ("E801",)),
    "an empty object": ("{}", ("E801",)),
    "no operations": (graph(0, []), ()),
    "deep lists": ("[" * 100_000, ("E801",)),
    "deep objects": ('{"kinds": ' * 50_000, ("E801",)),
    "NaN": (SMALL.replace("3}", "NaN}"), ("E801",)),
    "Infinity": (SMALL.replace("3}", "Infinity}"), ("E801",)),
    "a latency of 10^400": (SMALL.replace("3}", "1" + "0" * 400 + "}"), ("E801",)),
    "a latency of 1e400": (SMALL.replace("3}", "1e400}"), ("E801",)),
    "a latency of 10^9": (SMALL.replace("3}", "1000000000}"), ("E801",)),
    "a negative latency": (SMALL.replace("3}", "-3}"), ("E801",)),
    "a latency of true": (SMALL.replace("3}", "true}"), ("E801",)),
    "an interval of 0": (graph(3, [], initiation_interval=0), ("E801",)),
    "an interval of 10^9": (graph(3, [], initiation_interval=10**9), ("E801",)),
    "an interval of a million": (graph(3, [(0, 1)], initiation_interval=10**6, **LIMITED), ()),
    "an unknown goal": (graph(3, [], minimize="__import__"), ("E801",)),
    "a key twice": ('{"kinds": {}, "kinds": {}}', ("E801",)),
    "an id twice": (SMALL.replace('"o1", "kind"', '"o0", "kind"'), ("E802",)),
    "an unknown id": (graph(3, [(0, 7)]), ("E802",)),
    "an id of a megabyte": (SMALL.replace('"o1"', '"' + "o" * (1 << 20) + '"'), ("E801",)),
    "an id that drives a terminal": (SMALL.replace('"o1"', '"\\u001b[2J"'), ("E801",)),
    "half a surrogate pair": (SMALL.replace('"o1"', '"\\ud800"'), ("E801",)),
    "a circle": (graph(3, [(0, 1), (1, 2), (2, 0)]), ("E802",)),
    "an edge to itself": (graph(3, [(1, 1)]), ("E802",)),
    "a circle of 100,000": (later(100_000, [*chain(100_000), (99_999, 0)]), ("E802",)),
    "a limit of 0": (graph(3, [], kinds={"a": {"latency": 3, "limit": 0}}), ("E803",)),
    "too small a limit": (graph(9, [], **LIMITED), ("E803",)),
    "100,000 kinds": (
        later(0, [], kinds={f"k{i}": {"latency": 1} for i in range(100_000)}),
        ("E801",),
    ),
    "300,000 operations": (later(300_000, []), ("E801",)),
    "a million edges twice": (later(2, [(0, 1)] * 1_000_001), ("E801",)),
    "a chain of 20,000": (later(20_000, chain(20_000)), ()),
    "20,000 side by side": (later(20_000, []), ()),
    "a star of 20,000": (later(20_000, [(0, i) for i in range(1, 20_000)]), ()),
    "one edge 20,000 times": (later(2, [(0, 1)] * 20_000), ()),
    "every edge of 300": (later(300, dense(300)), ()),
    "a chain of 3,000 on two units": (later(3_000, chain(3_000), initiation_interval=1500, **LIMITED), ()),
    "every edge of 60 on two units": (later(60, dense(60), initiation_interval=30, **LIMITED), ()),
    "latencies of 100,000 in a chain": (
        later(2_000, chain(2_000), kinds={"a": {"latency": 100_000}}), (),
    ),
    "latencies of 0": (later(2_000, chain(2_000), kinds={"a": {"latency": 0}}), ()),
    "Latin-1": (b'{"kinds": {"\xe9": 1}}', ("E600",)),
    "random bytes": (bytes((i * 7919 + i // 3) % 256 for i in range(100_000)), ("E600", "E801")),
}  # fmt: skip

CASES = [
    Case(f"graph: {name}", ("schedule", "g.json", "-o", "o.json"), {"g.json": content}, codes)
    for name, (content, codes) in CONTENTS.items()
]
