"""Order and height of nodes in a layered drawing: barycentre sweeps, then monotone L1 regression."""

from __future__ import annotations

from bisect import bisect_right, insort
from collections.abc import Sequence
from dataclasses import dataclass

SWEEPS = 12
MOST_EDGES = 20_000
"""Of a drawing whose order and heights are improved; beyond, none is readable, and it takes minutes."""


@dataclass(frozen=True, slots=True)
class Vertex:
    """A vertex of one layer: a box, or the place where a net passes (height 0)."""

    layer: int
    height: int

    @property
    def passes(self) -> bool:
        """Whether this is a passing net."""
        return self.height == 0


@dataclass(frozen=True, slots=True)
class Edge:
    """A connection between nodes of adjacent layers, with the heights of its ends inside the nodes."""

    source: int
    source_offset: int
    target: int
    target_offset: int


Layers = list[list[int]]


def order(nodes: Sequence[Vertex], edges: Sequence[Edge], layers: Layers) -> Layers:
    """Reorder each layer so that few edges cross; a large drawing keeps the order of `layers`."""
    if len(edges) > MOST_EDGES:
        return layers
    best, best_count = layers, _count(nodes, edges, layers)
    current = layers
    for sweep in range(SWEEPS):
        current = _sweep(nodes, edges, current, forward=sweep % 2 == 0)
        count = _count(nodes, edges, current)
        if count < best_count:
            best, best_count = current, count
    return best


def _ranks(nodes: Sequence[Vertex], layers: Layers) -> dict[int, int]:
    return {node: index for layer in layers for index, node in enumerate(layer)}


def _point(nodes: Sequence[Vertex], ranks: dict[int, int], node: int, offset: int) -> float:
    return ranks[node] + offset / (nodes[node].height + 1)


def _sweep(nodes: Sequence[Vertex], edges: Sequence[Edge], layers: Layers, *, forward: bool) -> Layers:
    ranks = _ranks(nodes, layers)
    around: dict[int, list[tuple[int, int]]] = {}
    for edge in edges:
        if forward:
            around.setdefault(edge.target, []).append((edge.source, edge.source_offset))
        else:
            around.setdefault(edge.source, []).append((edge.target, edge.target_offset))
    result = [list(layer) for layer in layers]
    indices = range(len(layers)) if forward else range(len(layers) - 1, -1, -1)
    for index in indices:
        keys = {
            node: _mean([_point(nodes, ranks, *end) for end in around.get(node, [])], ranks[node])
            for node in result[index]
        }
        result[index].sort(key=lambda node: (keys[node], ranks[node]))
        for rank, node in enumerate(result[index]):
            ranks[node] = rank
    return result


def _mean(values: Sequence[float], otherwise: float) -> float:
    return sum(values) / len(values) if values else otherwise


def _count(nodes: Sequence[Vertex], edges: Sequence[Edge], layers: Layers) -> int:
    """Count edge crossings between adjacent layers."""
    ranks = _ranks(nodes, layers)
    channels: dict[int, list[tuple[float, float]]] = {}
    for edge in edges:
        start = _point(nodes, ranks, edge.source, edge.source_offset)
        end = _point(nodes, ranks, edge.target, edge.target_offset)
        channels.setdefault(nodes[edge.source].layer, []).append((start, end))
    total = 0
    for pairs in channels.values():
        seen: list[float] = []
        for _, end in sorted(pairs):
            total += len(seen) - bisect_right(seen, end)
            insort(seen, end)
    return total


def heights(
    nodes: Sequence[Vertex], edges: Sequence[Edge], layers: Layers, gap: int, pass_gap: int
) -> list[int]:
    """Choose the top of each node so that wires run straight; the order within layers stays.

    All heights, gaps and offsets are multiples of the raster, hence so are the results, from 0 on.  In a
    large drawing layers are only centred.
    """
    tops = [0] * len(nodes)
    for layer in layers:
        _centre(nodes, layer, tops, gap, pass_gap)
    if len(edges) > MOST_EDGES:
        least = min(tops, default=0)
        return [top - least for top in tops]
    neighbours: dict[int, list[tuple[int, int, bool]]] = {}
    for edge in edges:
        shift = edge.source_offset - edge.target_offset
        neighbours.setdefault(edge.target, []).append((edge.source, shift, True))
        neighbours.setdefault(edge.source, []).append((edge.target, -shift, False))
    for sweep in range(SWEEPS):
        forward = sweep % 2 == 0
        for layer in layers if forward else reversed(layers):
            wishes = {
                node: [
                    (tops[other] + shift, _weight(nodes, node, other, agrees=before == forward))
                    for other, shift, before in neighbours.get(node, [])
                ]
                for node in layer
            }
            _stack(nodes, layer, tops, wishes, gap, pass_gap)
    least = min(tops, default=0)
    return [top - least for top in tops]


def _centre(nodes: Sequence[Vertex], layer: Sequence[int], tops: list[int], gap: int, pass_gap: int) -> None:
    """Set the tops of a layer one below the other, that of the node in the middle to 0."""
    offsets = _offsets(nodes, layer, gap, pass_gap)
    for node, offset in zip(layer, offsets, strict=True):
        tops[node] = offset - offsets[len(offsets) // 2]


def _offsets(nodes: Sequence[Vertex], layer: Sequence[int], gap: int, pass_gap: int) -> list[int]:
    """Return how far below the first node of a layer each one has to be."""
    offset, offsets = 0, []
    for index, node in enumerate(layer):
        if index:
            above = nodes[layer[index - 1]]
            offset += above.height + (pass_gap if above.passes and nodes[node].passes else gap)
        offsets.append(offset)
    return offsets


def _weight(nodes: Sequence[Vertex], node: int, other: int, *, agrees: bool) -> int:
    long = 3 if nodes[node].passes and nodes[other].passes else 1
    return long * (4 if agrees else 1)


def _stack(
    nodes: Sequence[Vertex],
    layer: Sequence[int],
    tops: list[int],
    wishes: dict[int, list[tuple[int, int]]],
    gap: int,
    pass_gap: int,
) -> None:
    """Set the tops of a layer to the weighted L1 optimum that keeps order and gaps.

    Pool adjacent violators: after subtracting what must lie above, tops have to ascend.
    """
    offsets = _offsets(nodes, layer, gap, pass_gap)
    blocks: list[tuple[int, int, list[tuple[int, int]]]] = []
    for node, offset in zip(layer, offsets, strict=True):
        wanted = wishes.get(node) or [(tops[node], 1)]
        pool = [(top - offset, weight) for top, weight in wanted]
        value, size = _median(pool), 1
        while blocks and blocks[-1][0] >= value:
            _, members, other = blocks.pop()
            pool = other + pool
            value, size = _median(pool), size + members
        blocks.append((value, size, pool))
    values = [value for value, size, _ in blocks for _ in range(size)]
    for node, value, shift in zip(layer, values, offsets, strict=True):
        tops[node] = value + shift


def _median(pool: list[tuple[int, int]]) -> int:
    half = sum(weight for _, weight in pool) / 2
    seen = 0
    for value, weight in sorted(pool):
        seen += weight
        if seen >= half:
            return value
    raise AssertionError("a block without wishes")
