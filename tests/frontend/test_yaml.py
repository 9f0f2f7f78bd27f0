"""The tree of YAML nodes: places, limits, refusals."""

import pytest

from cordicc.base.diagnostics import Report, Source
from cordicc.frontend.document.yamltree import MAX_DEPTH, NodeKind, Places, read_tree


def tree(text):
    report = Report(Source("f.yaml", text))
    return read_tree(report.source, report), report


def scalar(text):
    root, report = tree(text)
    assert not report.diagnostics
    return root.pairs[0][1], Places(report.source)


def test_scalars_keep_their_text():
    root, _ = tree("a: off\nb: 1e-5\nc: [no, y, ~]\n")
    assert [v.value for _, v in root.pairs[:2]] == ["off", "1e-5"]
    assert [v.value for v in root.pairs[2][1].items] == ["no", "y", "~"]
    assert root.pairs[2][1].items[2].is_null
    assert root.kind is NodeKind.MAPPING


@pytest.mark.parametrize(
    ("text", "word", "line", "column"),
    [
        ("k: y = one + two\n", "two", 1, 14),
        ("k: 'y = one + two'\n", "two", 1, 15),
        ("k: 'it''s two'\n", "two", 1, 11),
        ('k: "one + two"\n', "two", 1, 11),
        ("k: one\n   + two\n", "two", 2, 6),
        ('k: "one\n   + two"\n', "two", 2, 6),
        ("k: >-\n  one\n  + two\n", "two", 3, 5),
        ("k: |\n  one\n  + two\n", "two", 3, 5),
        ("k: >2\n    one\n  two\n", "two", 3, 3),
        ("k: &anchor one + two\n", "two", 1, 18),
        ("k: one\r\n   + two\r\n", "two", 2, 6),
    ],
)
def test_offsets_map_to_places(text, word, line, column):
    node, places = scalar(text)
    at = node.value.index(word)
    span = places.within(node, at, at + len(word))
    assert (span.line, span.column, span.end_column) == (line, column, column + len(word))


def test_escaped_text_has_the_place_of_the_scalar():
    node, places = scalar('k: "one\\x20+ two"\n')
    assert places.within(node, 6, 9) == node.span


def test_aliases_share_nodes_and_count():
    root, report = tree("a: &x [1, 2]\nb: *x\n")
    assert root.pairs[0][1] is root.pairs[1][1]
    assert root.size == 9
    assert not report.diagnostics


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("", "E208"),
        ("# only a comment\n", "E208"),
        ("a: [1\n", "E101"),
        ("a: b: c\n", "E101"),
        ("\ta: 1\n", "E101"),
        ("a: *nowhere\n", "E101"),
        ("a: &x [*x]\n", "E103"),
        ("a: 1\n---\nb: 2\n", "E103"),
        ("a: !!python/object:os.system x\n", "E103"),
        ("a: !mine x\n", "E103"),
        ("? [a]\n: 1\n", "E103"),
        ("a: 1\nb: 2\na: 3\n", "E102"),
        ("a: \x00\n", "E105"),
        ("a: \x1b[31m\n", "E105"),
        ("a: \u2028b\n", "E105"),
        ("[" * 10_000, "E104"),
        ("- " * 10_000, "E104"),
        ('a: "\\UFFFFFFFF"\n', "E101"),
        ("%YAML 9.9\n---\na: 1\n", "E101"),
    ],
)
def test_refusals(text, code):
    _, report = tree(text)
    assert code in [d.code for d in report.diagnostics]


def test_both_places_of_a_duplicate_key():
    _, report = tree("a: 1\nb: 2\na: 3\n")
    (diagnostic,) = report.diagnostics
    assert (diagnostic.span.line, diagnostic.message) == (3, "the key 'a' occurs twice, first on line 1")


def test_bomb_is_refused():
    lines = ["a0: &a0 [x, x, x, x, x, x, x, x, x, x]"]
    lines += [f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 10)}]" for i in range(1, 10)]
    _, report = tree("\n".join(lines))
    assert [d.code for d in report.diagnostics] == ["E104"]


def test_depth_is_counted_through_aliases():
    lines = ["a0: &a0 [x]"] + [f"a{i}: &a{i} [*a{i - 1}]" for i in range(1, MAX_DEPTH + 1)]
    _, report = tree("\n".join(lines))
    assert [d.code for d in report.diagnostics] == ["E104"]
