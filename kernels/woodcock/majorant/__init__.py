"""Majorants: bounds on σ_t. One kind a file: `<kind>.h` for devices, `<kind>.py` its oracle."""
