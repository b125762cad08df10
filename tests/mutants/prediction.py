"""Mistakes in what is said of a render before it is made, and in comparisons."""

from __future__ import annotations

from tests.mutants.sin import Sin, device

PREDICT = "tests/kernels/test_predict.py"
COMPARISONS = "tests/server/test_comparisons.py"

SINS = (
    Sin(
        "a variance for a standard error",
        device("pilot.py"),
        "return math.sqrt(total / known) / squares.size",
        "return total / known / squares.size",
        (f"{PREDICT}::test_samples_are_by_the_variance_over_the_square_of_the_error",),
    ),
    Sin(
        "samples by the error, not by its square",
        device("pilot.py"),
        "middle = self.demand / error**2",
        "middle = self.demand / error",
        (f"{PREDICT}::test_samples_are_by_the_variance_over_the_square_of_the_error",),
    ),
    Sin(
        "the view's pixels for the picture's",
        device("pilot.py"),
        "Tempo(mean / share,",
        "Tempo(mean,",
        (f"{PREDICT}::test_overhead_is_told_from_samples",),
    ),
    Sin(
        "a coarse view's variance for the picture's",
        device("pilot.py"),
        "(float(self.variance.mean()) - self.coarse) / mean**2",
        "float(self.variance.mean()) / mean**2",
        (f"{PREDICT}::test_what_a_coarse_view_adds_is_taken_off",),
    ),
    Sin(
        "tails end with the pilot",
        device("pilot.py"),
        "high = self.demand * (math.exp(min(half, 50.0)) + more)",
        "high = self.demand * math.exp(min(half, 50.0))",
        (f"{PREDICT}::test_intervals_hold_for_heavy_tails",),
    ),
    Sin(
        "a launch's output without its squares",
        device("predict.py"),
        "16 * channels * rendered",
        "8 * channels * rendered",
        (f"{PREDICT}::test_memory_is_what_is_allocated",),
    ),
    Sin(
        "the variance of a mean for M2",
        "server/woodcock_server/comparisons/service.py",
        "* count * (count - 1)",
        "* count",
        (f"{COMPARISONS}::test_a_film_is_what_its_picture_says",),
    ),
    Sin(
        "variants share their random numbers",
        "kernels/woodcock/compare/vary.py",
        "(first + k) % (1 << 32)",
        "first % (1 << 32)",
        (f"{COMPARISONS}::test_a_comparison_is_a_job_for_each_variant",),
    ),
)
