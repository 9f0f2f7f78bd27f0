"""The artefacts of a plan, one module each, with `render(plan) -> str`."""
