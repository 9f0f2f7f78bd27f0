"""What every folder may use: diagnostics and codes, files that appear whole or not at all, tables of text.

Nothing here knows of kinematics or CORDIC.
"""
