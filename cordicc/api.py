"""The Python interface: what `import cordicc` offers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from os.path import isdir, isfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cordicc import artefacts, pipeline
from cordicc.backends.labels import headline
from cordicc.backends.pictures import raster
from cordicc.backends.pictures.diagram import PAGE_WIDTH
from cordicc.backends.report.page import fragment
from cordicc.backends.rtl.reset_style import RESETS, USUAL_RESET
from cordicc.base.diagnostics import Diagnostic, InvalidInput
from cordicc.base.files import read_text, write_file
from cordicc.emulate import checking
from cordicc.emulate import cycle as cycle_run
from cordicc.emulate import functional as functional_run
from cordicc.ir.problem import Problem
from cordicc.plan.file import dump, parse
from cordicc.plan.model import Plan
from cordicc.readback import check_plan
from cordicc.schedule.request import Limits
from cordicc.targets.target import DEFAULT_TARGET
from cordicc.targets.target_file import Asked


@dataclass(frozen=True, slots=True)
class Picture:
    """A picture as SVG, which notebooks show."""

    svg: str

    def _repr_svg_(self) -> str:
        return self.svg

    def converted(self, suffix: str) -> str | bytes:
        """Return the picture in the format of a file name's end: `.svg`, `.png`, `.pdf`; none means SVG.

        Raises:
            InvalidInput: another suffix (E651), what PNG and PDF take is not installed (E650), or the picture
                is too large for PNG (E654).
        """
        kind = suffix.removeprefix(".").lower() or "svg"
        if kind not in raster.FORMATS:
            message = f"pictures are written as .{', .'.join(raster.FORMATS)}, not '{suffix}'"
            raise InvalidInput([Diagnostic("E651", message)])
        return raster.convert(self.svg, kind)

    def save(self, path: str | Path) -> None:
        """Write the picture; raises InvalidInput as `converted`, or if the file cannot be written."""
        write_file(Path(path), self.converted(Path(path).suffix))


@dataclass(frozen=True, slots=True, repr=False)
class RunnablePlan(Plan):
    """A hardware plan that can be run, and that notebooks show: `cordicc.Plan`."""

    @classmethod
    def of(cls, data: Plan) -> RunnablePlan:
        """Return plan data with the methods of this class."""
        return cls(**{f.name: getattr(data, f.name) for f in fields(Plan)})

    def simulate(
        self, inputs: Mapping[str, ArrayLike], *, cycle_accurate: bool = False
    ) -> dict[str, NDArray[Any]]:
        """Run the plan, bit-true, on samples.

        Args:
            inputs: an array of shape (n,) for each input of the problem.
            cycle_accurate: execute units, pipelines and FIFOs clock by clock; the same bits, slower.

        Returns:
            An array of shape (n,) for each output, float64, NaN for invalid samples, and `valid`, bool.

        Raises:
            InvalidInput: an input is missing, unknown, or of another length than the others.
        """
        run = cycle_run.run if cycle_accurate else functional_run.run
        arrays = self._arrays(inputs)
        return run(self, self.arithmetic, arrays)

    def check_values(
        self, inputs: Mapping[str, ArrayLike], outputs: Mapping[str, ArrayLike] | None = None
    ) -> dict[str, NDArray[np.float64]]:
        """Return the checks of the problem on samples: 0 on perfect outputs.

        Args:
            inputs: as of `simulate`.
            outputs: what `simulate` returned for them; None: the plan is run.

        Returns:
            An array of shape (n,) for each check, NaN where the sample is invalid or the check has no value.

        Raises:
            InvalidInput: as `simulate`, or an output or `valid` is missing or of another length.
        """
        arrays = self._arrays(inputs)
        found = self.simulate(inputs) if outputs is None else {n: np.asarray(x) for n, x in outputs.items()}
        count = len(next(iter(arrays.values()), ()))
        wrong = [n for n in (*self.outputs, "valid") if n not in found or found[n].shape != (count,)]
        if wrong:
            raise InvalidInput(
                Diagnostic("E610", f"output '{n}' is missing or too short or long") for n in wrong
            )
        return checking.check_values(self.problem, arrays, found)

    def _arrays(self, inputs: Mapping[str, ArrayLike]) -> dict[str, NDArray[np.float64]]:
        names = self.problem.input_names
        wrong = [f"input '{n}' is missing" for n in names if n not in inputs]
        wrong += [f"there is no input '{n}'" for n in inputs if n not in names]
        arrays = {n: np.atleast_1d(np.asarray(inputs[n], dtype=np.float64)) for n in names if n in inputs}
        if any(a.ndim != 1 for a in arrays.values()) or len({len(a) for a in arrays.values()}) > 1:
            wrong.append("the inputs are not one-dimensional arrays of one length")
        if wrong:
            raise InvalidInput(Diagnostic("E610", message) for message in wrong)
        return arrays

    def picture(self, view: str = "datapath", width: float | None = PAGE_WIDTH) -> Picture:
        """Return a picture of the plan.

        Args:
            view: `datapath`, `schedule` or `graph`.
            width: datapath and graph are folded into rows of about so many pixels; None: one row.

        Raises:
            InvalidInput: an unknown view.
        """
        if view not in artefacts.VIEWS:
            message = f"there is no view '{view}': {', '.join(artefacts.VIEWS)}"
            raise InvalidInput([Diagnostic("E652", message)])
        return Picture(artefacts.picture(self, view, width))

    def report(self) -> str:
        """Return the page `report.html`."""
        return artefacts.report_page(self)

    def emit(self, name: str, samples: int | None = None, reset: str = USUAL_RESET.port) -> dict[str, str]:
        """Return the texts of one of `cordicc.artefacts.ARTEFACTS` by file name, `c` for example.

        Args:
            name: of the artefact.
            samples: of `verilog` and `verilog-vectors`, how many samples are drawn at random; None: 500.
            reset: of `verilog`, the port by which a core is reset: `rst`, `rst_n`, `arst` or `arst_n`.

        Raises:
            InvalidInput: an unknown name (E653) or reset (E656).
            Unattainable: it has no form for this plan.
        """
        if name not in artefacts.ARTEFACTS:
            message = f"there is no artefact '{name}': {', '.join(artefacts.ARTEFACTS)}"
            raise InvalidInput([Diagnostic("E653", message)])
        made = artefacts.ARTEFACTS[name]
        if reset not in RESETS:
            message = f"there is no reset '{reset}': {', '.join(RESETS)}"
            raise InvalidInput([Diagnostic("E656", message)])
        counts = [samples] if made.samples and samples is not None else []
        return dict(made.emit(self, *counts, reset=RESETS[reset]))

    def __repr__(self) -> str:
        """Return name and key figures on one line."""
        return f"<Plan {self.name}: {headline(self)}>"

    def _repr_html_(self) -> str:
        return fragment(self)

    def to_json(self) -> str:
        """Return the text of plan.json."""
        return dump(self)


def compile(
    problem: str | Path,
    *,
    target: str = DEFAULT_TARGET,
    units: str = "auto",
    minimize: str = "processors",
    ii: int = 1,
    max_processors: int | None = None,
    max_latency: int | None = None,
    certify: bool | None = None,
    copies: int = 1,
    effort: float = 1.0,
    width: int | None = None,
    clock_hz: float | None = None,
) -> RunnablePlan:
    """Compile a problem file to a plan; the options are those of `cordicc compile`.

    Raises:
        InvalidInput: the file, the target or an option is invalid.
        Unattainable: no plan within the limits.
    """
    limits = Limits(minimize, ii, max_processors, max_latency)
    options = pipeline.Options(target, units, limits, certify, copies, effort, Asked(width, clock_hz))
    return RunnablePlan.of(pipeline.compile_file(Path(problem), options).plan)


def check(problem: str | Path) -> tuple[Problem, list[Diagnostic]]:
    """Read a problem file and return it with its warnings; raises InvalidInput with all its errors."""
    loaded = pipeline.read_problem(Path(problem))
    return loaded.problem, list(loaded.warnings)


def load_plan(path: str | Path) -> RunnablePlan:
    """Read plan.json back, or that of a folder, with everything checked; raises InvalidInput."""
    file = Path(path)
    # Unlike the methods of Path these functions raise nothing for a name that is too long.
    if isdir(file) and isfile(file / "plan.json"):
        file = file / "plan.json"
    return RunnablePlan.of(check_plan(parse(read_text(file), str(file))))
