"""Emission: ε, what media radiate per length. One kind a file: `<kind>.h` for devices, `<kind>.py` its oracle."""
