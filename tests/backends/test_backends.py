"""The pictures, the report and the script: well-formed, complete, legible, the same every time."""

from __future__ import annotations

import ast
import re
import sys
import xml.etree.ElementTree as ET
from itertools import combinations, pairwise

import pytest

from cordicc.backends import escaping, labels, script
from cordicc.backends.palette import DARK, INK, LOOKS, MUTED, OTHER
from cordicc.backends.pictures import (
    datapath,
    graph_view,
    layout,
    placing,
    routing,
    schedule_chart,
    svg,
    wire_paths,
    wiring,
)
from cordicc.backends.pictures.diagram import PAGE_WIDTH
from cordicc.plan.model import Plan
from tests.support import hand_plans as plans
from tests.support.hard_plans import ALL, shared
from tests.support.selection import quick

SVG = "{http://www.w3.org/2000/svg}"
PICTURES = (datapath, schedule_chart, graph_view)


@pytest.fixture(params=ALL, ids=str)
def plan(request: pytest.FixtureRequest) -> Plan:
    return ALL[request.param]


def texts(root: ET.Element) -> list[tuple[float, float, float, float, str]]:
    """Return the boxes of all texts, by the module's own width estimate."""
    found = []
    for node in root.iter(f"{SVG}text"):
        size = float(node.attrib["font-size"])
        text = node.text or ""
        width = svg.text_width(text, size, bold="font-weight" in node.attrib)
        shift = {"start": 0.0, "middle": 0.5, "end": 1.0}[node.attrib["text-anchor"]]
        left, base = float(node.attrib["x"]) - shift * width, float(node.attrib["y"])
        found.append((left, base - 0.75 * size, left + width, base + 0.2 * size, text))
    return found


@pytest.mark.parametrize("view", PICTURES, ids=lambda view: view.__name__.rpartition(".")[2])
class TestPictures:
    def test_well_formed_and_white(self, view, plan):
        root = ET.fromstring(view.render(plan))
        assert root.tag == f"{SVG}svg"
        ground = next(root.iter(f"{SVG}rect"))
        assert ground.attrib["fill"] == "#ffffff"
        assert ground.attrib["width"] == root.attrib["width"]

    def test_deterministic(self, view, plan):
        assert view.render(plan) == view.render(plan)

    def test_complete(self, view, plan):
        ids = [
            node.attrib["data-id"]
            for node in ET.fromstring(view.render(plan)).iter()
            if "data-id" in node.attrib
        ]
        assert len(ids) == len(set(ids))
        wanted = {f"op.{op.id}" for op in plan.operations}
        if view is not graph_view:
            wanted |= {f"fifo.{fifo.id}" for fifo in plan.fifos}
        if view is not schedule_chart:
            wanted |= {f"out.{escaping.clean(name)}" for name in plan.outputs}
        assert wanted <= set(ids)

    def test_labels_do_not_overlap(self, view, plan):
        root = ET.fromstring(view.render(plan))
        for a, b in combinations(texts(root), 2):
            apart = a[2] <= b[0] or b[2] <= a[0] or a[3] <= b[1] or b[3] <= a[1]
            assert apart, f"{a[4]!r} over {b[4]!r}"

    def test_labels_are_not_cut(self, view, plan):
        root = ET.fromstring(view.render(plan))
        width, height = float(root.attrib["width"]), float(root.attrib["height"])
        for left, top, right, bottom, text in texts(root):
            assert left >= 0, text
            assert right <= width, text
            assert 0 <= top < bottom <= height, text

    def test_boxes_have_tooltips(self, view):
        root = ET.fromstring(view.render(plans.wheel()))
        group = next(node for node in root.iter() if node.attrib.get("data-id") == "op.o5")
        title = group.find(f"{SVG}title")
        assert title is not None
        assert title.text.splitlines() == [
            "o5: hyperbolic vectoring on standard2",
            "equation: beta",
            "cycles 48–92",
            "operands: x = o4.norm, y = o3.value, z = 0.0",
            "results: o5.norm, not used",
            "parameters: m = -1, sign = 1",
        ]


class TestLayout:
    @pytest.mark.parametrize("width", [None, PAGE_WIDTH])
    @pytest.mark.parametrize("view", [datapath, graph_view], ids=["datapath", "graph"])
    @pytest.mark.parametrize("seed", quick(range(8), 0, 1))
    def test_wires_are_unambiguous(self, view, seed, width):
        for band in view.diagram(plans.puma(seed), width).bands:
            self.check_wires(band)

    @staticmethod
    def check_wires(band):
        boxes = {s.box.id: (*band.layout.places[s.box.id], s.box.width, s.box.height) for s in band.shapes}
        for (_, a), (_, b) in combinations(boxes.items(), 2):
            assert a[0] >= b[0] + b[2] or b[0] >= a[0] + a[2] or a[1] >= b[1] + b[3] or b[1] >= a[1] + a[3]
        lines = [
            (number, min(x1, x2), max(x1, x2), min(y1, y2), max(y1, y2))
            for number, wire in enumerate(band.layout.wires)
            for (x1, y1), (x2, y2) in wire.segments
            if (x1, y1) != (x2, y2)
        ]
        for name, (x, y, width, height) in boxes.items():
            for _, x1, x2, y1, y2 in lines:
                assert not (x1 < x + width and x2 > x and y1 < y + height and y2 > y), name
        for a, b in combinations(lines, 2):
            if a[0] == b[0]:
                continue
            touch_x, touch_y = a[1] <= b[2] and b[1] <= a[2], a[3] <= b[4] and b[3] <= a[4]
            both_level, both_upright = a[3] == a[4] and b[3] == b[4], a[1] == a[2] and b[1] == b[2]
            assert not ((both_level or both_upright) and touch_x and touch_y)

    @pytest.mark.parametrize("width", [None, PAGE_WIDTH])
    @pytest.mark.parametrize("seed", quick(range(4), 0))
    def test_every_wire_joins_its_ports(self, seed, width):
        for band in datapath.diagram(plans.puma(seed), width).bands:
            shapes = {shape.box.id: shape.box for shape in band.shapes}
            places = band.layout.places
            for net, wire in zip(band.nets, band.layout.wires, strict=True):
                ends = {point for segment in wire.segments for point in segment}
                for pin in net.sinks:
                    x, y = places[pin.box]
                    assert (x, y + shapes[pin.box].inputs[pin.port]) in ends
                x, y = places[net.source.box]
                box = shapes[net.source.box]
                assert (x + box.width, y + box.outputs[net.source.port]) in ends

    def test_time_runs_to_the_right(self):
        plan = plans.puma()
        for width in (None, PAGE_WIDTH):
            bands = datapath.diagram(plan, width).bands
            places = {
                shape.box.id: (row, band.layout.places[shape.box.id][0])
                for row, band in enumerate(bands)
                for shape in band.shapes
            }
            ordered = sorted(
                (op.start, places[f"op.{op.id}"]) for op in plan.operations if op.finish > op.start
            )
            for (early, before), (late, after) in combinations(ordered, 2):
                assert before < after if early < late else before == after

    def test_cyclic_constraints_are_cut_by_a_jog(self):
        channel = routing.route([routing.Crossing(0, 0, (80,)), routing.Crossing(1, 80, (0,))])
        jogs = [turn for found in channel.routes for turn in found.turns if turn[2] is not None]
        assert len(jogs) == 1
        assert jogs[0][1] not in (0, 80)

    def test_layers_follow_arcs_and_survive_cycles(self):
        assert layout.forced_layers({"a": 0, "b": 0, "c": 5}, [("a", "b"), ("b", "c")]) == {
            "a": 0,
            "b": 1,
            "c": 5,
        }
        assert set(layout.forced_layers({"a": 0, "b": 0}, [("a", "b"), ("b", "a")])) == {"a", "b"}

    def test_order_removes_a_crossing(self):
        nodes = [placing.Vertex(0, 16), placing.Vertex(0, 16), placing.Vertex(1, 16), placing.Vertex(1, 16)]
        edges = [placing.Edge(0, 8, 3, 8), placing.Edge(1, 8, 2, 8)]
        first, second = placing.order(nodes, edges, [[0, 1], [2, 3]])
        assert [first.index(0), first.index(1)] == [second.index(3), second.index(2)]


class TestFolding:
    """A wide diagram in rows: nothing is lost, and rows fit a page."""

    @pytest.mark.parametrize("view", [datapath, graph_view], ids=["datapath", "graph"])
    @pytest.mark.parametrize("seed", quick(range(8), 0, 1))
    def test_rows_fit_a_page(self, view, seed):
        bands = view.diagram(plans.puma(seed, small=60), PAGE_WIDTH).bands
        assert len(bands) > 1
        assert all(band.layout.width <= PAGE_WIDTH for band in bands)

    @pytest.mark.parametrize("seed", quick(range(8), 0, 1))
    def test_rows_have_the_connections_of_the_plan(self, seed):
        plan = plans.puma(seed)
        wanted = {(net.source.box, sink.box) for net in wiring.nets(plan) for sink in net.sinks}
        found, shown = set(), []
        for band in datapath.diagram(plan, PAGE_WIDTH).bands:
            shapes = {shape.box.id: shape for shape in band.shapes}
            shown += [name for name, shape in shapes.items() if not shape.source]
            for net in band.nets:
                source = shapes[net.source.box]
                ends = [to for sink in net.sinks for to in shapes[sink.box].leads_to or (sink.box,)]
                found |= {(source.source or source.box.id, end) for end in ends}
        assert found == wanted
        assert len(shown) == len(set(shown))
        connected = {name for pair in wanted for name in pair}
        assert connected <= set(shown)

    def test_narrow_diagrams_stay_in_one_row(self):
        assert len(datapath.diagram(plans.wheel(), PAGE_WIDTH).bands) == 1
        assert len(datapath.diagram(plans.puma(), None).bands) == 1

    def test_branches_follow_the_wire(self):
        segments = [((0, 0), (20, 0)), ((20, -8), (20, 16)), ((20, -8), (40, -8)), ((20, 16), (40, 16))]
        assert wire_paths.branches(segments, (0, 0), [(40, -8), (40, 16)]) == [
            [(0, 0), (20, 0), (20, -8), (40, -8)],
            [(0, 0), (20, 0), (20, 16), (40, 16)],
        ]
        assert wire_paths.branches([((0, 0), (40, 0))], (0, 0), [(40, 0)]) == [[(0, 0), (40, 0)]]

    @pytest.mark.parametrize("seed", quick(range(4), 0))
    def test_each_end_of_a_wire_has_its_way(self, seed):
        for band in datapath.diagram(plans.puma(seed), PAGE_WIDTH).bands:
            boxes = {shape.box.id: shape.box for shape in band.shapes}
            for net, wire in zip(band.nets, band.layout.wires, strict=True):
                box = boxes[net.source.box]
                x, y = band.layout.places[box.id]
                ends = [
                    (
                        band.layout.places[pin.box][0],
                        band.layout.places[pin.box][1] + boxes[pin.box].inputs[pin.port],
                    )
                    for pin in net.sinks
                ]
                start = (x + box.width, y + box.outputs[net.source.port])
                for end, way in zip(ends, wire_paths.branches(wire.segments, start, ends), strict=True):
                    assert way[0] == start
                    assert way[-1] == end
                    assert all(a[0] == b[0] or a[1] == b[1] for a, b in pairwise(way))


class TestPalette:
    """Kinds can be told apart without colour, and texts read, on paper and in the dark."""

    @staticmethod
    def luminance(colour):
        parts = [int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)]
        parts = [p / 12.92 if p <= 0.04045 else ((p + 0.055) / 1.055) ** 2.4 for p in parts]
        return sum(w * p for w, p in zip((0.2126, 0.7152, 0.0722), parts, strict=True))

    def lightness(self, colour):
        return 116 * self.luminance(colour) ** (1 / 3) - 16

    def contrast(self, first, second):
        low, high = sorted((self.luminance(first), self.luminance(second)))
        return (high + 0.05) / (low + 0.05)

    def test_units_differ_in_grey(self):
        kinds = ["standard", "implicit", "mul", "cmul", "add", "shift", "sign"]
        for (_, a), (_, b) in combinations([(k, LOOKS[k]) for k in kinds] + [("", OTHER)], 2):
            shapes = (a.dash, a.inner, a.radius) != (b.dash, b.inner, b.radius)
            assert shapes or abs(self.lightness(a.fill) - self.lightness(b.fill)) >= 7, (a.label, b.label)

    @pytest.mark.parametrize("theme", [lambda colour: colour, DARK.__getitem__], ids=["light", "dark"])
    def test_texts_stand_out(self, theme):
        for look in (*LOOKS.values(), OTHER):
            assert self.contrast(theme(look.fill), theme(INK)) >= 7, look.label
            assert self.contrast(theme(look.fill), theme(MUTED)) >= 4.5, look.label
            assert self.contrast(theme("#ffffff"), theme(look.stroke)) >= 3, look.label

    def test_every_colour_has_a_dark_one(self, plan):
        for view in PICTURES:
            used = set(re.findall(r'(?:fill|stroke)="(#[0-9a-f]+)"', view.render(plan)))
            assert used <= set(DARK), view.__name__


class TestLabels:
    @pytest.mark.parametrize(
        ("text", "shown"),
        [("1/3", "0.333333"), ("-0x1.8p+1", "−3"), ("0.25", "0.25"), ("pi", "pi"), ("1/0", "1/0")],
    )
    def test_constants(self, text, shown):
        assert labels.constant(text) == shown

    @pytest.mark.parametrize(
        ("op", "operands", "shown"),
        [
            ("add", ("x", -0.5), "− 0.5"),
            ("add", (0.5, "x"), "+ 0.5"),
            ("sub", (0.5, "x"), "0.5 − a"),
            ("sub", ("x", -0.5), "+ 0.5"),
            ("mul", ("x", "x"), "×"),
        ],
    )
    def test_symbols_hold_constants(self, op, operands, shown):
        builder = plans.Builder("one", {"x": (0, 1)})
        (value,) = builder.add(op, *operands)
        assert labels.symbol(builder.plan({"y": value}).operations[0]) == shown

    @pytest.mark.parametrize(
        ("count", "shown"), [(0, "0"), (1, "100 ns"), (62, "6.2 µs"), (10**5, "10 ms"), (10**8, "10 s")]
    )
    def test_seconds(self, count, shown):
        assert labels.seconds(count, 10e6) == shown

    def test_fitted_text_fits(self):
        short = svg.fitted("W" * 50, 10, 60)
        assert short.endswith("…")
        assert svg.text_width(short, 10) <= 60

    def test_operations_on_a_shared_unit_get_lanes(self):
        rows = {row.name: row for row in schedule_chart.unit_rows(shared(), 4.0)}
        assert [[bar.id for bar in lane] for lane in rows["standard1"].lanes] == [
            ["op.o4", "op.o6"],
            ["op.o7"],
        ]


class TestScript:
    def test_runs_the_plan_beside_it(self, plan, tmp_path, monkeypatch):
        text = script.render(plan)
        ast.parse(text)
        calls = []
        monkeypatch.setitem(sys.modules, "cordicc.cli", type("Cli", (), {"main": staticmethod(calls.append)}))
        path = tmp_path / "simulate.py"
        path.write_text(text, encoding="utf-8")
        monkeypatch.setattr(sys, "argv", [str(path), "--random", "5"])
        with pytest.raises(SystemExit):
            exec(compile(text, str(path), "exec"), {"__name__": "__main__", "__file__": str(path)})
        assert calls == [["simulate", str(tmp_path.resolve() / "plan.json"), "--random", "5"]]
