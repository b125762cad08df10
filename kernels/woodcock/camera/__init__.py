"""Cameras: the ray of a film coordinate. One kind a file: `<kind>.h` for devices, `<kind>.py` its oracle."""
