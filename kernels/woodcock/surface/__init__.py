"""Surfaces, the boundary of the equation. One kind a file: `<kind>.h` for devices, `<kind>.py` its numbers and oracle;
`build.py` and `hierarchy.py` lay them out, `compose.py` writes the calls between the kinds in use.
"""
