"""Volumes: where the medium is and how dense. One kind a file: `<kind>.h` for devices, `<kind>.py` its oracle."""
