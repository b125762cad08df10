"""Shapes that homogeneous media fill. One kind a file: `<kind>.h` for devices, `<kind>.py` its oracle."""
