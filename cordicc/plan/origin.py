"""What a plan was made from and for: the problem, the target, the options, enough to run and to judge it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field

from cordicc.arith.unit.arithmetic import Arithmetic
from cordicc.base.diagnostics import Diagnostic
from cordicc.ir.facts import InputFacts
from cordicc.ir.graph import Graph
from cordicc.ir.problem import InputSpec, Problem
from cordicc.ir.sampling import Workspace
from cordicc.targets.target import Target


@dataclass(frozen=True, slots=True)
class PlanInput:
    """An input and its closed range, as doubles; `unit` is a label.

    `scale` is what one of the unit is in the numbers of samples, None where nothing is converted.
    """

    name: str
    lo: float
    hi: float
    unit: str | None = None
    scale: float | None = None

    @classmethod
    def of(cls, spec: InputSpec) -> PlanInput:
        """Return the record of an input."""
        scale = None if spec.scale is None else float(spec.scale)
        return cls(spec.name, float(spec.lo), float(spec.hi), spec.unit, scale)


@dataclass(frozen=True, slots=True)
class PlanEquation:
    """An equation as written, and the name that it defines."""

    target: str
    text: str


@dataclass(frozen=True, slots=True)
class PlanOutput:
    """An output: whether it is an angle in radians, delivered in (-pi, pi], and the error that is allowed."""

    name: str
    is_angle: bool = False
    wrap: bool = False
    max_error: float | None = None


@dataclass(frozen=True, slots=True)
class PlanCheck:
    """A check as written, its unit, a label, and the largest magnitude that is allowed.

    One that nobody `asked` for is the residual of a `solve`.
    """

    name: str
    text: str
    unit: str | None = None
    max: float | None = None
    asked: bool = True


@dataclass(frozen=True, slots=True)
class PlanProblem:
    """The problem as its plan records it.

    `program` is the graph of the equations as written, `samples` the columns of the problem's own samples
    by input, `warnings` what was told of the problem and of the plan, each with its code.  `assumptions` are
    as written, `facts` the same so that samples can be tested for them, of every copy.  `check_program` is
    the graph of the checks over the inputs and the delivered outputs.
    """

    name: str
    program: Graph
    description: str = ""
    inputs: tuple[PlanInput, ...] = ()
    constants: Mapping[str, float] = field(default_factory=dict)
    equations: tuple[PlanEquation, ...] = ()
    outputs: tuple[PlanOutput, ...] = ()
    assumptions: tuple[str, ...] = ()
    samples: Mapping[str, tuple[float, ...]] | None = None
    warnings: tuple[str, ...] = ()
    facts: InputFacts = field(default_factory=InputFacts)
    checks: tuple[PlanCheck, ...] = ()
    check_program: Graph = field(default_factory=lambda: Graph((), {}))

    @classmethod
    def of(cls, problem: Problem, warnings: Sequence[Diagnostic]) -> PlanProblem:
        """Return the record of a problem, with the warnings that came up."""
        return cls(
            name=problem.name,
            program=problem.graph,
            description=problem.description,
            inputs=tuple(map(PlanInput.of, problem.inputs)),
            constants={name: float(value) for name, value in problem.constants.items()},
            equations=tuple(PlanEquation(e.target, e.text) for e in problem.equations),
            outputs=tuple(
                PlanOutput(o.name, o.is_angle, o.wrap, None if o.max_error is None else float(o.max_error))
                for o in problem.outputs
            ),
            assumptions=tuple(fact.text for fact in problem.assumptions),
            samples=None if problem.samples is None else dict(problem.samples.columns),
            warnings=tuple(map(told, warnings)),
            facts=problem.facts,
            checks=tuple(
                PlanCheck(c.name, c.text, c.unit, None if c.max is None else float(c.max), c.asked)
                for c in problem.checks
            ),
            check_program=problem.check_graph,
        )

    @property
    def input_names(self) -> tuple[str, ...]:
        """Return the names of the inputs, in order of declaration."""
        return tuple(item.name for item in self.inputs)

    @property
    def angles(self) -> dict[str, bool]:
        """Return, by output, whether it is an angle."""
        return {output.name: output.is_angle for output in self.outputs}

    def check(self, name: str) -> PlanCheck:
        """Return the check of that name; raises KeyError."""
        return {check.name: check for check in self.checks}[name]

    @property
    def workspace(self) -> Workspace:
        """Return where samples of the inputs are drawn from."""
        return Workspace({item.name: (item.lo, item.hi) for item in self.inputs}, self.samples)


def told(warning: Diagnostic) -> str:
    """Return a warning as a plan records it."""
    return f"{warning.code}: {warning.message}"


@dataclass(frozen=True, slots=True)
class PlanUnitKind:
    """A kind of unit of the target: cycles of latency, by stage too, adders, area in adder equivalents.

    A unit takes an operation every `initiation_interval` cycles.
    """

    latency: int
    adders: int = 0
    area: float = 0.0
    stages: Mapping[str, int] = field(default_factory=dict)
    initiation_interval: int = 1


@dataclass(frozen=True, slots=True)
class PlanTarget:
    """The target of a plan: clock in Hz, arithmetic, area of a FIFO bit in adder equivalents, unit kinds.

    `device` is the name of the chip, None where the target names none.
    """

    name: str
    clock_hz: float
    arithmetic: Arithmetic
    description: str = ""
    angle_unit: str = "rad"
    fifo_area_per_bit: float = 0.0
    units: Mapping[str, PlanUnitKind] = field(default_factory=dict)
    device: str | None = None

    @classmethod
    def of(cls, target: Target) -> PlanTarget:
        """Return what a plan records of a target."""
        return cls(
            target.name,
            target.clock_hz,
            target.machine(),
            target.description,
            target.angle_unit,
            target.fifo_area_per_bit,
            {
                kind: PlanUnitKind(
                    unit.latency, unit.adders, unit.area, unit.stages, unit.initiation_interval
                )
                for kind, unit in target.units.items()
            },
            None if target.device is None else target.device.name,
        )


@dataclass(frozen=True, slots=True)
class PlanOptions:
    """What the user asked for: the options of `cordicc compile`, by the names of the Python interface.

    `file` and `target` are names without folders, `effort` is None for the usual, `width` (bits) and `clock`
    (hertz) for those of the target.  `time_limit_struck`
    tells that the emergency stop ended a search: such a plan is not reproducible.
    """

    file: str = ""
    target: str = ""
    units: str = "auto"
    minimize: str = "processors"
    ii: int = 1
    max_processors: int | None = None
    max_latency: int | None = None
    certify: bool | None = None
    effort: float | None = None
    copies: int = 1
    width: int | None = None
    clock: float | None = None
    time_limit_struck: bool = False

    @property
    def recorded(self) -> dict[str, str | int | float | bool | None]:
        """Return the options by name as plans record them: what is seldom used only where it is."""
        seldom = {"copies": 1, "width": None, "clock": None, "time_limit_struck": False}
        return {
            name: value for name, value in asdict(self).items() if name not in seldom or value != seldom[name]
        }
