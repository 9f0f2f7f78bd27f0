"""`cordicc schedule`: a bare graph of operations, scheduled."""

from __future__ import annotations

from pathlib import Path

import click

from cordicc.cli.arguments import (
    FILE,
    is_stdout,
    output_option,
    require_unread,
    time_limit_option,
    write_or_print,
)
from cordicc.cli.streams import say


@click.command("schedule")
@click.argument("graph", type=FILE, metavar="GRAPH.json")
@output_option("Write here instead of stdout.", "OUT.json")
@time_limit_option("Emergency stop of searches.")
def command(graph: Path, output: Path | None, time_limit: float | None) -> None:
    """Schedule a bare graph of operations.

    GRAPH.json has initiation_interval, minimize (latency, fifo or processors), kinds (latency,
    limit, and initiation_interval of units that are no pipelines),
    operations (id and kind) and edges.  FIFO words are the longest waits of the values, in cycles.

    \b
    cordicc schedule graph.json -o schedule.json
    """  # noqa: D301
    import json

    from cordicc.base.files import read_text
    from cordicc.schedule.bare import parse_graph, schedule_graph
    from cordicc.schedule.solver.engine import Effort
    from cordicc.schedule.verify_bare import verify_bare

    require_unread("-o", output, graph)
    text = read_text(graph)
    answer = schedule_graph(parse_graph(text, str(graph)), Effort(words=10.0, seconds=time_limit))
    verify_bare(json.loads(text), answer)
    write_or_print(output, json.dumps(answer, indent=1, sort_keys=True, ensure_ascii=False) + "\n")
    if is_stdout(output):
        return
    for name, bound in answer["bounds"].items():
        proven = "proven optimal" if answer["optimal"][name] else f"at least {bound}"
        figure = answer[name] if name in answer else len(set(answer["unit"].values()))
        say(f"{name.replace('_', ' ')} {figure} ({proven})")
