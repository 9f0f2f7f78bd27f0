"""Whether a chip has room for a plan."""

from __future__ import annotations

from cordicc.base.diagnostics import Diagnostic, Severity
from cordicc.plan.area import Area
from cordicc.targets.device import Device

_NAMES = {"lut": "LUT", "ff": "FF", "dsp": "DSP", "ram_bits": "bits of RAM"}


def too_large(area: Area, device: Device, about: str = "") -> list[Diagnostic]:
    """Return a warning (W422) if a device has not what a plan takes; `about` stands before the figures."""
    beyond = [
        f"{about}{taken:,} of {there:,} {_NAMES[figure]}"
        for figure, there in device.capacity.items()
        if (taken := getattr(area, figure)) > there
    ]
    if not beyond:
        return []
    message = f"the plan is too large for {device.part}: it takes {', '.join(beyond)}"
    hint = "a larger device, a longer interval (--ii), or fewer bits (--width)"
    return [Diagnostic("W422", message, None, hint, Severity.WARNING)]
