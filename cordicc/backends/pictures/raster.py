"""SVG pictures as PNG and PDF, by CairoSVG if the user has it."""

from __future__ import annotations

import math
import re
from typing import Any

from cordicc.base.diagnostics import Diagnostic, InvalidInput

FORMATS = ("svg", "png", "pdf")
PNG_SCALE = 2.0
"""Pixels of a PNG for each of the SVG."""

MAX_PNG_SIDE = 32_767
"""Pixels of a side, which is what Cairo can do."""

MAX_PNG_PIXELS = 1 << 28
"""Of the whole picture; each takes four bytes of memory while it is drawn."""

_SIZE = re.compile(r'<svg [^>]*?width="([0-9.]+)" height="([0-9.]+)"')


def convert(svg: str, kind: str) -> str | bytes:
    """Return a picture as `svg`, `png` or `pdf`; the same bytes for the same picture.

    Raises:
        InvalidInput: CairoSVG, or the Cairo library that it calls, is not installed (E650), or a PNG would be
            too large (E654).
    """
    if kind == "svg":
        return svg
    if kind == "png":
        _check_size(svg)
    cairosvg, cairo = _cairo(kind)
    if kind == "png":
        made: bytes = cairosvg.svg2png(bytestring=svg.encode(), scale=PNG_SCALE)
        return made
    surface_kind: Any = cairosvg.surface.PDFSurface

    class Undated(surface_kind):  # type: ignore[misc]
        """A PDF that does not say when it was made."""

        def surface_class(self, *arguments: Any) -> Any:
            surface = cairo.PDFSurface(*arguments)
            surface.set_metadata(cairo.PDF_METADATA_CREATE_DATE, "")
            return surface

    converted: bytes = Undated.convert(bytestring=svg.encode())
    return converted


def _check_size(svg: str) -> None:
    """Raise InvalidInput for a picture that is too large for PNG."""
    size = _SIZE.match(svg)
    assert size is not None
    width, height = (math.ceil(float(side) * PNG_SCALE) for side in size.groups())
    if max(width, height) <= MAX_PNG_SIDE and width * height <= MAX_PNG_PIXELS:
        return
    limit = (
        f"a side has at most {MAX_PNG_SIDE:,}"
        if max(width, height) > MAX_PNG_SIDE
        else f"there are at most {MAX_PNG_PIXELS:,}"
    )
    message = f"as a PNG the picture would have {width:,} x {height:,} pixels, of which {limit}"
    hint = "write .svg or .pdf, or fold datapath and graph into rows by another --width"
    raise InvalidInput([Diagnostic("E654", message, hint=hint)])


def _cairo(kind: str) -> tuple[Any, Any]:
    try:
        import cairocffi
        import cairosvg
    except (ImportError, OSError) as error:  # OSError: the package is there, the library it loads is not
        reason = (str(error).splitlines() or [type(error).__name__])[0]
        raise InvalidInput(
            [
                Diagnostic(
                    "E650",
                    f"{kind.upper()} pictures take CairoSVG, which cannot be used: {reason}",
                    hint="pip install 'cordicc[pictures]', or write an .svg",
                )
            ]
        ) from None
    return cairosvg, cairocffi
