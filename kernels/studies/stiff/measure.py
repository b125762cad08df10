"""The numbers of the study; `Effort` says how many there are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from studies.stiff import device as ours
from studies.stiff.methods import METHODS, radau, solve
from studies.stiff.problems import Problem, constant, foils, grid, jumps, layers, ramp, slab, transparent
from woodcock.device import Device

OURS = "exponential integrator"
RADAU = "Radau"
#: Relative error that table 2 asks for.
WANTED = 1e-3
TOLERANCES = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
#: h σ_t at which the explicit methods are looked at: their limits are 2 and 2.785….
STABILITY = (0.5, 1.0, 1.5, 1.9, 2.1, 2.7, 2.9, 4.0)
STIFF = 1e4


class Point(NamedTuple):
    """error: relative; bound: what the method itself says of it, relative, NaN if nothing."""

    evaluations: int
    error: float
    bound: float = np.nan


Curves = dict[str, list[Point]]


@dataclass(frozen=True)
class Effort:
    """steps: of the methods with fixed steps; decades: of σ_t; paths: samples of each of 32² pixels."""

    steps: tuple[int, ...] = tuple(2**k + 1 for k in range(21))
    decades: tuple[float, ...] = tuple(10.0**k for k in range(-2, 9))
    tolerances: tuple[float, ...] = TOLERANCES
    paths: tuple[int, ...] = (2, 8, 32, 128, 512)


@dataclass
class Numbers:
    """stability: by method, errors at each of STABILITY; reached: by method, evaluations to WANTED for each σ_t, None
    where all were not enough; constant: ours there; curves: by problem; orders: by what is solved and method; clear:
    (σ_t, 1 - exp in float32, in float64, ours); random: by label, the exact L and runs of more and more paths;
    behind: (σ_t, value and standard error of random paths over the exact L, ours); walked: see `walks`; reference:
    Radau's errors.
    """

    effort: Effort
    platform: str
    precision: str
    stability: dict[str, list[float]] = field(default_factory=dict)
    reached: dict[str, list[int | None]] = field(default_factory=dict)
    constant: list[Point] = field(default_factory=list)
    curves: dict[str, Curves] = field(default_factory=dict)
    orders: dict[str, dict[str, float]] = field(default_factory=dict)
    clear: list[tuple[float, float, float, Point]] = field(default_factory=list)
    random: dict[str, tuple[float, list[ours.Result]]] = field(default_factory=dict)
    reference: dict[str, float] = field(default_factory=dict)
    behind: list[tuple[float, float, float, Point]] = field(default_factory=list)
    walked: tuple[float, float, float] = (0.0, 0.0, 0.0)


def measure(device: Device, effort: Effort) -> Numbers:
    numbers = Numbers(effort, device.platform, "double" if device.doubles else "float")
    stability(numbers)
    stiffness(numbers, device)
    for problem in (jumps(), foils(2.0**-16), ramp()):
        numbers.curves[problem.name] = curves(problem, device, effort)
    orders(numbers)
    clear(numbers, device)
    random(numbers, device)
    behind(numbers, device)
    walks(numbers, device)
    for problem in (constant(1.0), constant(1e8), transparent(1e-8), jumps(), foils(), ramp()):
        numbers.reference[f"{problem.name}, σ_t ≤ {problem.sigma.max():.0e}"] = relative(radau(problem)[0], problem)
    return numbers


def relative(value: float, problem: Problem) -> float:
    exact = problem.exact()
    return abs(value - exact) / exact


def point(method: str, problem: Problem, n: int) -> Point:
    value, evaluations = solve(method, problem, n)
    return Point(evaluations, relative(value, problem))


def stepped(problem: Problem, device: Device, tolerance: float) -> Point:
    """Ours."""
    result = ours.emission_absorption(device, problem, tolerance)
    return Point(result.evaluations, relative(result.value, problem), result.error / problem.exact())


def stability(numbers: Numbers) -> None:
    """Isothermal, of the σ_t STIFF: what the error is when the steps are a little shorter or longer than the limit."""
    problem = constant(STIFF)
    for method in METHODS:
        counts = [round(STIFF / z) for z in STABILITY]
        numbers.stability[method] = [point(method, problem, n).error for n in counts]


def stiffness(numbers: Numbers, device: Device) -> None:
    """Isothermal, σ_t of all decades: evaluations until the error is WANTED or less, and what ours does there."""
    problems = [constant(sigma) for sigma in numbers.effort.decades]
    ladder = sorted({round(2 ** (k / 4)) for k in range(4 * numbers.effort.steps[-1].bit_length())})
    for method in METHODS:
        numbers.reached[method] = [_first(method, problem, ladder) for problem in problems]
    numbers.reached[RADAU] = [
        next((found[1] for t in TOLERANCES if relative((found := radau(problem, t))[0], problem) <= WANTED), None)
        for problem in problems
    ]
    numbers.constant = [stepped(problem, device, 1e-4) for problem in problems]
    numbers.reached[OURS] = [p.evaluations if p.error <= WANTED else None for p in numbers.constant]


def _first(method: str, problem: Problem, ladder: Sequence[int]) -> int | None:
    """Of the ladder's step counts the first that is right, by bisection: errors here fall with every step that is added
    once the method is stable, and are larger where it is not."""
    low, high = 0, len(ladder)
    while low < high:
        middle = (low + high) // 2
        right = point(method, problem, ladder[middle]).error <= WANTED
        low, high = (low, middle) if right else (middle + 1, high)
    return solve(method, problem, ladder[low])[1] if low < len(ladder) else None


def curves(problem: Problem, device: Device, effort: Effort) -> Curves:
    found = {method: [point(method, problem, n) for n in effort.steps] for method in METHODS}
    found[RADAU] = []
    for tolerance in effort.tolerances:
        value, evaluations = radau(problem, tolerance)
        found[RADAU].append(Point(evaluations, relative(value, problem)))
    found[OURS] = [stepped(problem, device, tolerance) for tolerance in effort.tolerances]
    return found


def orders(numbers: Numbers) -> None:
    """By which power of the steps' length errors fall: smooth, across jumps, and where steps miss or resolve a foil."""
    steps, foil_width = numbers.effort.steps, 2.0**-16
    asked = {
        "constant, σ_t = 1": (constant(1.0), [n for n in steps if 8 < n < 200]),
        "ramp": (ramp(), [n for n in steps if n > 30]),
        "jumps": (jumps(), [n for n in steps if n > 30]),
        "foils, h above their width": (foils(foil_width), [n for n in steps if 30 < n < 0.1 / foil_width]),
        "foils, h below their width": (foils(foil_width), [n for n in steps if n > 4 / foil_width]),
    }
    for label, (problem, counts) in asked.items():
        numbers.orders[label] = {m: order([point(m, problem, n).error for n in counts], counts) for m in METHODS}


def order(errors: Sequence[float], counts: Sequence[int]) -> float:
    """Least squares; infinite if the method is exact, NaN if it blows up or there are too few."""
    if len(counts) < 3 or max(errors) > 1e5:
        return np.nan
    if max(errors) < 1e-9:
        return np.inf
    good = [(n, e) for n, e in zip(counts, errors, strict=True) if e > 1e-12]
    return float(-np.polyfit(*np.log(np.array(good).T), 1)[0])


def clear(numbers: Numbers, device: Device) -> None:
    """q = 1 and σ_t towards 0: (1 - exp(-σ_t)) q / σ_t as it stands, in float32 and float64, and ours."""
    for sigma in (1e-4, 1e-8, 1e-12, 1e-16, 1e-30, 0.0):
        problem = transparent(sigma)
        naive = []
        for real in (np.float32, np.float64):
            with np.errstate(invalid="ignore"):
                naive.append(relative(float((real(1) - np.exp(-real(sigma))) / real(sigma)), problem))
        numbers.clear.append((sigma, naive[0], naive[1], stepped(problem, device, 1e-4)))


def random(numbers: Numbers, device: Device) -> None:
    """Delta tracking of emission, and ratio tracking of transmittance, by more and more paths."""

    def runs(label: str, problem: Problem, paths: Sequence[int], layer: str = "", majorant: int | None = None) -> None:
        found = [ours.volumetric_path(device, problem, n, layer=layer, majorant=majorant) for n in paths]
        numbers.random[label] = problem.exact(), found

    paths = numbers.effort.paths
    for sigma in (1e-2, 1e2, 1e5, 1e8):
        runs(f"delta, constant σ_t = {sigma:.0e}", constant(sigma), paths)
    runs("delta, jumps to 1e5, one majorant", jumps(1e5), [2])
    runs("delta, jumps to 1e5, majorant of 256 cells", jumps(1e5), paths[:2], majorant=256)
    runs("exponential clocks, jumps to 1e5, boxes", jumps(1e5, boxes=True), paths)
    runs("delta, ramp, majorant of 256 cells", ramp(), paths[:-1], majorant=256)
    runs("exponential clocks, foils of σ_t = 3e4", foils(2.0**-16), paths)
    for cells in (16, 256, 4096):
        runs(f"ratio, foil of σ_t = {cells}", foil(cells), paths[:-1], "transmittance", 256)


def behind(numbers: Numbers, device: Device) -> None:
    """An isothermal opaque half, seen through a clear one: mean free paths down to less than float32 adds to ½."""
    for sigma in (1e4, 1e6, 1e8):
        media = [slab(0, 0.5, 1e-3, 1e-3), slab(0.5, 1, sigma, sigma)]
        problem = layers("behind", [0, 0.5, 1], [1e-3, sigma], [1e-3, sigma], lambda folder, media=media: media)
        found, exact = ours.volumetric_path(device, problem, numbers.effort.paths[-1]), problem.exact()
        step = stepped(problem, device, 1e-4)
        numbers.behind.append((sigma, found.value / exact, found.error / exact, step))


def foil(cells: int) -> Problem:
    """One voxel of so many, of optical depth 1, in front of light: L is its transmittance, exp(-1)."""
    sigma = np.zeros(cells)
    sigma[cells // 3] = cells
    light = {"lights": [{"kind": "constant", "radiance": 1}]}
    edges, none = np.arange(cells + 1) / cells, np.zeros(cells)
    return layers("foil", edges, sigma, none, lambda folder: [grid(folder, sigma, none)], behind=1.0, scene=light)


def walks(numbers: Numbers, device: Device) -> None:
    """A million steps of 1e-8 from ½ in float32: without the rest of each sum, with it, and where they ought to end."""
    steps, step = 1_000_000, 1e-8
    ends = [ours.advanced(device, steps, step, compensated=compensated) for compensated in (False, True)]
    numbers.walked = ends[0], ends[1], 0.5 + steps * step
