"""Artefacts of a plan, a folder for each kind. What several of them share stands here."""
