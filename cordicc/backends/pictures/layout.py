"""Layered layout of boxes joined by nets: positions, and orthogonal wires that never cross a box.

Layers run from left to right.  A net that spans several layers passes each through a gap between boxes;
between layers it turns in a channel (`routing`).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from cordicc.backends.pictures import placing
from cordicc.backends.pictures.placing import Edge, Vertex
from cordicc.backends.pictures.routing import GRID, Channel, Crossing, Route, route

GAP = 2 * GRID
CHANNEL_MARGIN = 14

MOST_TRACKS_ESTIMATED = 40
"""Tracks that a channel is estimated to need at the most; most nets pass in a straight line."""

Point = tuple[int, int]


@dataclass(frozen=True, slots=True)
class Box:
    """A box to place.  Ports are offsets from its top; they and the height are multiples of the raster."""

    id: str
    layer: int
    width: int
    height: int
    inputs: tuple[int, ...] = ()
    outputs: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True)
class Pin:
    """A port of a box, counted from the top."""

    box: str
    port: int


@dataclass(frozen=True, slots=True)
class Net:
    """One driver and the ports it feeds, all in later layers."""

    name: str
    source: Pin
    sinks: tuple[Pin, ...]


@dataclass(frozen=True, slots=True)
class Wire:
    """A drawn net: straight segments, and the points where it branches."""

    net: str
    segments: tuple[tuple[Point, Point], ...]
    dots: tuple[Point, ...]


@dataclass(frozen=True, slots=True)
class Layout:
    """Positions of the upper left corners, left edge and width of each layer, wires, and total size."""

    places: Mapping[str, Point]
    columns: tuple[tuple[int, int], ...]
    wires: tuple[Wire, ...]
    width: int
    height: int


def forced_layers(wished: Mapping[str, int], arcs: Iterable[tuple[str, str]]) -> dict[str, int]:
    """Return the least layers, none below the wish, in which each arc goes to a later layer.

    Arcs of a cycle are given up once layers exceed what an acyclic graph can need.
    """
    layers = dict(wished)
    limit = max(layers.values(), default=0) + len(layers)
    arcs = [(source, target) for source, target in arcs if source in layers and target in layers]
    for _ in range(len(layers)):
        late = [(s, t) for s, t in arcs if layers[t] <= layers[s] < limit]
        if not late:
            break
        for source, target in late:
            layers[target] = max(layers[target], layers[source] + 1)
    return layers


def compact(layers: Mapping[str, int]) -> dict[str, int]:
    """Renumber layers from 0 without gaps."""
    ranks = {layer: rank for rank, layer in enumerate(sorted(set(layers.values())))}
    return {name: ranks[layer] for name, layer in layers.items()}


def arrange(boxes: Sequence[Box], nets: Sequence[Net]) -> Layout:
    """Place `boxes` and route `nets`.  Sinks not in a later layer than their driver are left out."""
    graph = _Graph(boxes, nets)
    layers = placing.order(graph.nodes, graph.edges, graph.layers)
    tops = placing.heights(graph.nodes, graph.edges, layers, GAP, GRID)
    channels = [route(crossings) for crossings in graph.crossings(tops)]
    widths = [0] * len(graph.layers)
    for box in boxes:
        widths[box.layer] = max(widths[box.layer], box.width)
    columns: list[tuple[int, int]] = []
    x = 0
    for index, width in enumerate(widths):
        columns.append((x, width))
        x += width + (_channel_width(channels[index]) if index < len(channels) else 0)
    places = {box.id: (columns[box.layer][0], tops[index]) for index, box in enumerate(boxes)}
    height = max((tops[index] + node.height for index, node in enumerate(graph.nodes)), default=0)
    return Layout(places, tuple(columns), tuple(graph.wires(tops, columns, channels)), x, height)


def estimated_columns(boxes: Sequence[Box], nets: Sequence[Net]) -> tuple[tuple[int, int], ...]:
    """Return about where the columns of a layout would be, in linear time: left edge and width of each."""
    depth = max((box.layer for box in boxes), default=-1) + 1
    layer = {box.id: box.layer for box in boxes}
    starting, ending = [0] * (depth + 1), [0] * (depth + 1)
    for net in nets:
        starting[layer[net.source.box]] += 1
        ending[max((layer[pin.box] for pin in net.sinks), default=layer[net.source.box])] += 1
    columns: list[tuple[int, int]] = []
    x = crossing = 0
    for index in range(depth):
        width = max((box.width for box in boxes if box.layer == index), default=0)
        columns.append((x, width))
        crossing += starting[index] - ending[index]
        x += width + 2 * CHANNEL_MARGIN + GRID * min(crossing, MOST_TRACKS_ESTIMATED)
    return tuple(columns)


def _channel_width(channel: Channel) -> int:
    return 2 * CHANNEL_MARGIN + GRID * max(channel.tracks - 1, 0)


class _Graph:
    """Nodes and edges between adjacent layers: the boxes in their order, then passing nets."""

    def __init__(self, boxes: Sequence[Box], nets: Sequence[Net]) -> None:
        self.boxes = boxes
        self.nets = nets
        self.index = {box.id: index for index, box in enumerate(boxes)}
        self.nodes = [Vertex(box.layer, box.height) for box in boxes]
        self.edges: list[Edge] = []
        self.net_edges: dict[int, list[list[Edge]]] = {}
        depth = max((box.layer for box in boxes), default=-1) + 1
        self.layers: placing.Layers = [[] for _ in range(depth)]
        for index, box in enumerate(boxes):
            self.layers[box.layer].append(index)
        for number, net in enumerate(nets):
            self._thread(number, net)

    def _thread(self, number: int, net: Net) -> None:
        """Add the net's edges, layer by layer, with a passing node in each layer it crosses."""
        source = self.index[net.source.box]
        node, offset = source, self.boxes[source].outputs[net.source.port]
        first = self.nodes[source].layer
        targets: dict[int, list[tuple[int, int]]] = {}
        for pin in net.sinks:
            sink = self.index[pin.box]
            if self.nodes[sink].layer > first:
                targets.setdefault(self.nodes[sink].layer, []).append(
                    (sink, self.boxes[sink].inputs[pin.port])
                )
        last = max(targets, default=first)
        steps: list[list[Edge]] = []
        for layer in range(first + 1, last + 1):
            ends = [Edge(node, offset, *end) for end in targets.get(layer, [])]
            if layer < last:
                self.nodes.append(Vertex(layer, 0))
                self.layers[layer].append(len(self.nodes) - 1)
                ends.append(Edge(node, offset, len(self.nodes) - 1, 0))
                node, offset = len(self.nodes) - 1, 0
            steps.append(ends)
            self.edges += ends
        self.net_edges[number] = steps

    def steps(self) -> Iterable[tuple[int, int, list[Edge]]]:
        """Yield net, layer on the left, and edges of every net in every channel."""
        for number, steps in self.net_edges.items():
            first = self.nodes[self.index[self.nets[number].source.box]].layer
            for step, edges in enumerate(steps):
                yield number, first + step, edges

    def crossings(self, tops: Sequence[int]) -> list[list[Crossing]]:
        """Return what crosses the channel after each layer but the last one."""
        found: list[list[Crossing]] = [[] for _ in self.layers[1:]]
        for number, layer, edges in self.steps():
            left = tops[edges[0].source] + edges[0].source_offset
            right = sorted(tops[edge.target] + edge.target_offset for edge in edges)
            found[layer].append(Crossing(number, left, tuple(right)))
        return found

    def wires(self, tops: Sequence[int], columns: Sequence[Point], channels: Sequence[Channel]) -> list[Wire]:
        """Return each net as segments and branch points."""
        drawn: dict[int, tuple[list[tuple[Point, Point]], list[Point]]] = {}
        routes = [{found.net: found for found in channel.routes} for channel in channels]
        for number, layer, edges in self.steps():
            segments, dots = drawn.setdefault(number, ([], []))
            left, width = columns[layer]
            source = edges[0].source
            start = left + (self.boxes[source].width if source < len(self.boxes) else 0)
            end = columns[layer + 1][0]
            found = routes[layer].get(number)
            if found is None:
                height = tops[source] + edges[0].source_offset
                segments.append(((start, height), (end, height)))
            else:
                _draw(found, start, left + width + CHANNEL_MARGIN, end, segments, dots)
        return [Wire(self.nets[number].name, tuple(s), tuple(d)) for number, (s, d) in drawn.items()]


def _draw(
    found: Route, start: int, base: int, end: int, segments: list[tuple[Point, Point]], dots: list[Point]
) -> None:
    """Add a route's segments: the stub from `start`, the trunk, the stubs to `end`."""
    x = base + GRID * found.track
    turned = [turn for _, turn, _ in found.turns]
    low, high = min([found.left, *turned]), max([found.left, *turned])
    segments.append(((start, found.left), (x, found.left)))
    segments.append(((x, low), (x, high)))
    for height, turn, jog in found.turns:
        if jog is None:
            segments.append(((x, height), (end, height)))
        else:
            bend = base + GRID * jog
            segments += [
                ((x, turn), (bend, turn)),
                ((bend, turn), (bend, height)),
                ((bend, height), (end, height)),
            ]
    for height in sorted({found.left, *turned}):
        arms = (height == found.left) + (height in turned) + (height > low) + (height < high)
        if arms > 2:
            dots.append((x, height))
