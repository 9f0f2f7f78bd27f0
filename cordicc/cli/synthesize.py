"""`cordicc synthesize`: a plan built for a chip, and what that showed written beside its estimate."""

from __future__ import annotations

from os.path import isdir
from pathlib import Path

import click

from cordicc.cli.arguments import NOT_NEGATIVE, force_option, json_option, plan_argument
from cordicc.cli.console import show, stages, tell
from cordicc.cli.streams import deliver
from cordicc.targets.device import DEFAULT_DEVICE, DEVICES

_REPORT = "report.html"


@click.command("synthesize")
@plan_argument()
@click.option(
    "--tool",
    type=click.Choice(["yosys", "nextpnr"]),
    help="The last program to run: yosys counts cells, nextpnr places and routes them.  [default: nextpnr "
    "where there is one for the device]",
)
@click.option(
    "--device",
    type=click.Choice(list(DEVICES)),
    help=f"The chip.  [default: that of the plan's target, else {DEFAULT_DEVICE}]",
)
@click.option("--seed", type=NOT_NEGATIVE, default=1, show_default=True, help="Seed of placing.")
@force_option()
@json_option("what was found")
def command(plan: Path, tool: str | None, device: str | None, seed: int, force: bool, as_json: bool) -> None:
    """Build the Verilog of a plan for a chip: LUT, FF, DSP, RAM, clock and slowest path.

    PLAN is a plan.json or its folder. What is found is written into it, and into the report beside it. yosys
    and nextpnr are those of the system or of PyPI (pip install 'cordicc[synthesis]'), the newest of each.

    \b
    cordicc synthesize build/arm
    cordicc synthesize build/arm/plan.json --device artix7-100t --json
    """  # noqa: D301
    import json
    from dataclasses import replace

    from cordicc.api import load_plan
    from cordicc.artefacts import report_page
    from cordicc.backends.synthesis.build import built
    from cordicc.backends.synthesis.families import FAMILIES
    from cordicc.backends.text.area_facts import area_facts
    from cordicc.base.text_tables import Facts, Sheet
    from cordicc.cli.results import require_own, write_results
    from cordicc.plan.file import dump
    from cordicc.plan.plain_data import as_dict

    loaded = load_plan(plan)
    file = plan / "plan.json" if isdir(plan) else plan
    names = [file.name, *([_REPORT] if (file.parent / _REPORT).is_file() else [])]
    if not force:
        require_own(file.parent, names)  # told before the work
    chip = DEVICES.get(device or loaded.target.device or "", DEVICES[DEFAULT_DEVICE])
    if tool == "nextpnr" and FAMILIES[chip.family].router is None:
        raise click.BadParameter(f"there is no nextpnr for {chip.name}", param_hint="--tool")
    with stages(as_json) as enter:
        found, warnings = built(loaded, chip, place=tool != "yosys", seed=seed, enter=enter)
    tell(warnings)
    made = replace(loaded, synthesis=found)
    files = {file.name: dump(made)}
    if _REPORT in names:
        files[_REPORT] = report_page(made)
    write_results(file.parent, files, force=force)
    if as_json:
        data = as_dict(made)
        wanted = {key: data[key] for key in ("name", "target", "area", "clock_hz", "synthesis")}
        deliver(json.dumps(wanted, indent=2, sort_keys=True, ensure_ascii=False) + "\n")
    else:
        written = f"  wrote {file.parent}: {', '.join(files)}"
        show(Sheet(f"{made.name} on {chip.name}", (Facts(tuple(area_facts(made))), "", written)))
