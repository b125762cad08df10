"""What surfaces are made of. One kind a file: `<kind>.h` for devices, `<kind>.py` its numbers and oracle."""
