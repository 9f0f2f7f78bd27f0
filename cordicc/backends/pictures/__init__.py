"""Pictures as SVG, converted to PNG and PDF where asked for."""
