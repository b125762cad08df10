"""Mistakes in how errors are measured, and in what is said of how they fall."""

from __future__ import annotations

from tests.mutants.sin import Sin, device

METRICS = "tests/kernels/test_metrics.py"
REFERENCE = "tests/kernels/test_reference.py"
REPORT = "tests/kernels/test_report.py"
SERIES = "tests/kernels/test_series.py"

SINS = (
    Sin(
        "relative errors depend on the unit of radiance",
        device("metrics.py"),
        "return EPSILON * _mean(picture) ** 2",
        "return EPSILON",
        (f"{METRICS}::test_relative_errors_have_no_unit",),
    ),
    Sin(
        "the reference's noise counts as the picture's",
        device("metrics.py"),
        "max(square - noise(variance), 0.0)",
        "max(square, 0.0)",
        (f"{METRICS}::test_error_against_a_noisy_reference",),
    ),
    Sin(
        "FLIP's exposures do not follow the reference",
        device("metrics.py"),
        "white = float(_luminance(reference).max())",
        "white = 1.0",
        (f"{METRICS}::test_flip_has_no_unit",),
    ),
    Sin(
        "the bias of a noisy reference is the picture's",
        device("series.py"),
        "*([] if its is None else [its])",
        "*[]",
        (f"{SERIES}::test_against_a_reference",),
    ),
    Sin(
        "efficiency is over the error, not its square",
        device("series.py"),
        "else film.rmse() ** 2",
        "else film.rmse()",
        (f"{SERIES}::test_efficiency",),
    ),
    Sin(
        "shared samples count as independent",
        device("reference.py"),
        "if self.seed == seed else self",
        "if self.seed == -1 else self",
        (REFERENCE,),
    ),
    Sin(
        "a line through points has one more degree of freedom",
        device("regression.py"),
        "freedom = len(x) - 2",
        "freedom = len(x) - 1",
        (f"{SERIES}::test_generalised_least_squares",),
    ),
    Sin(
        "points count as independent",
        device("convergence.py"),
        "return np.asarray(1 / np.maximum.outer(samples, samples))",
        "return np.diag(1 / samples)",
        (f"{SERIES}::test_bands_hold_the_slope_as_often_as_they_say",),
    ),
    Sin(
        "true errors are averages over samples",
        device("convergence.py"),
        "curve = Curve(*points, _drifting(points[0]))",
        "return Curve(*points, _averaging(points[0]))",
        (f"{SERIES}::test_bands_narrow_as_series_grow",),
    ),
    Sin(
        "samples count as normal",
        device("convergence.py"),
        "+ excess * _averaging(",
        "+ 0 * _averaging(",
        (f"{SERIES}::test_bands_hold_the_slope_as_often_as_they_say",),
    ),
    Sin(
        "points below the reference's noise count",
        device("convergence.py"),
        'a["mse"] > (a["reference_mse"] or 0)',
        'a["mse"] > 0',
        (f"{SERIES}::test_a_noisy_reference_is_no_bias",),
    ),
    Sin(
        "the slope is over samples",
        device("convergence.py"),
        "line = curve.over(curve.seconds)",
        "line = curve.over(curve.samples)",
        (f"{SERIES}::test_a_device_that_changes_its_speed_is_no_bias",),
    ),
    Sin(
        "an excess over what the samples tell is no bias",
        device("convergence.py"),
        "if not (more or _off(line) > 0):",
        "if True:",
        (f"{SERIES}::test_a_bias_is_flagged_by_a_reference_alone",),
    ),
    Sin(
        "a contract that was missed is met",
        device("certificate.py"),
        'if contract["met"] else "failed"',
        'if contract["met"] else "passed"',
        (f"{REPORT}::test_the_contract",),
    ),
)
