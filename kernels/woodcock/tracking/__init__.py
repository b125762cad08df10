"""Free flights and transmittances along a ray. One kind a file: `<kind>.h` for devices, `<kind>.py` its oracle."""
