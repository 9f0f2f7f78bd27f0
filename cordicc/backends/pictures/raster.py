"""SVG pictures as PNG and PDF, by CairoSVG if the user has it."""

from __future__ import annotations

from typing import Any

from cordicc.base.diagnostics import Diagnostic, InvalidInput

FORMATS = ("svg", "png", "pdf")
PNG_SCALE = 2.0
"""Pixels of a PNG for each of the SVG."""


def convert(svg: str, kind: str) -> str | bytes:
    """Return a picture as `svg`, `png` or `pdf`; the same bytes for the same picture.

    Raises:
        InvalidInput: CairoSVG, or the Cairo library that it calls, is not installed (E650).
    """
    if kind == "svg":
        return svg
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
