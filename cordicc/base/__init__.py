"""What every folder may use: diagnostics and codes, whole files, tables of text, the names of arrays.

Nothing here knows of kinematics or CORDIC.
"""
