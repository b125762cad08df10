"""The ray equation L′ + σ_t L = q where it is stiff: problems, methods, what they cost.

problems.py   rays with known σ_t and q, their exact radiance, and the scenes that say the same
methods.py    explicit and implicit Euler, RK4, ray marching, scipy's Radau: in float64
device.py     the renderer's integrators on those scenes, with their evaluations counted
measure.py    the numbers
figure.py     the figure
page.py       the page: page.md with the numbers filled in
"""
