"""Mistakes in Python after the kernels: statistics, films, ranges of samples, pictures."""

from __future__ import annotations

from tests.mutants.sin import Sin, device

FILM = "tests/kernels/test_film.py"
MERGED = f"{FILM}::test_merging_is_the_film_of_all_samples"
WIDTHS = "tests/analytic/test_widths.py::test_a_range_is_the_merge_of_its_parts"

SINS = (
    Sin(
        "a range may count twice",
        device("film.py"),
        "if joined and start < joined[-1][1]:",
        "if joined and stop < joined[-1][0]:",
        (f"{FILM}::test_no_sample_counts_twice",),
    ),
    Sin(
        "M2 merged without what lies between the means",
        device("film.py"),
        "delta += self.m2 + other.m2",
        "delta = self.m2 + other.m2",
        (MERGED,),
    ),
    Sin(
        "M2 merged with the wrong count",
        device("film.py"),
        "delta *= share * self.count[..., None]",
        "delta *= share * other.count[..., None]",
        (MERGED,),
    ),
    Sin(
        "means merged in halves",
        device("film.py"),
        "mean = delta * share",
        "mean = delta * 0.5",
        (MERGED,),
    ),
    Sin(
        "variance over n, not n - 1",
        device("film.py"),
        "n * (n - 1)",
        "n * n",
        (MERGED,),
    ),
    Sin(
        "variance of a sample, not of the mean",
        device("film.py"),
        "n * (n - 1)",
        "n - 1",
        (MERGED,),
    ),
    Sin(
        "the variance of layers counts as the beauty's",
        device("film.py"),
        'squares = self.layer("").variance()',
        "squares = self.variance()[..., -self.channels :]",
        (f"{FILM}::test_layers_are_films_and_the_beauty_alone_counts",),
    ),
    Sin(
        "luminance of green for blue",
        device("film.py"),
        "np.array([0.2126, 0.7152, 0.0722])",
        "np.array([0.2126, 0.0722, 0.7152])",
        (f"{FILM}::test_luminance_is_that_of_rec_709",),
    ),
    Sin(
        "the mean's error as if channels were independent",
        device("film.py"),
        "deviation = np.sqrt(variance) @ weights(self.channels)",
        "deviation = np.sqrt(variance @ weights(self.channels) ** 2)",
        (f"{FILM}::test_error_of_the_mean_holds_for_channels_that_vary_together",),
    ),
    Sin(
        "the last launch of a batch is a whole one",
        device("render.py"),
        "min(stop, first + LARGEST_LAUNCH)",
        "first + LARGEST_LAUNCH",
        ("tests/kernels/test_render.py",),
    ),
    Sin(
        "squares in the units of radiance",
        device("render.py"),
        "m2 * 4.0**self._exponents",
        "m2 * 2.0**self._exponents",
        ("tests/analytic/test_laws.py::test_radiance_scales",),
    ),
    Sin(
        "what rounding leaves of sums is dropped",
        device("launch.py"),
        "sums[:, part + 1]",
        "0 * sums[:, part + 1]",
        (WIDTHS,),
    ),
    Sin(
        "what rounding leaves of a square is dropped",
        device("core/moments.h"),
        "fma(x, x, -square)",
        "(real)0.f",
        ("tests/kernels/test_moments.py",),
    ),
    Sin(
        "sums in single precision",
        device("core/moments.h"),
        "*high = s + error;",
        "*high = s, error = (real)0.f;",
        (WIDTHS,),
    ),
    Sin(
        "M2 of a launch without the mean's square",
        device("launch.py"),
        "squares -= total",
        "squares -= 0 * total",
        (WIDTHS,),
    ),
    Sin(
        "what the series leaves out is bounded one order late",
        device("report.py"),
        "norm ** (last + 1)",
        "norm ** (last + 2)",
        ("tests/kernels/test_report.py::test_a_series_that_was_cut",),
    ),
    Sin(
        "channels named blue, green, red",
        device("layers.py"),
        '("R", "G", "B") if channels == 3',
        '("B", "G", "R") if channels == 3',
        ("tests/kernels/test_layers.py::test_names_in_order",),
    ),
    Sin(
        "channels of the EXR in the wrong order",
        device("image.py"),
        "np.stack([pixels.astype(np.float32) for pixels in layers.values()]",
        "np.stack([pixels.astype(np.float32) for pixels in reversed(layers.values())]",
        ("tests/kernels/test_image.py::test_exr_round_trip",),
    ),
    Sin(
        "previews blue for red",
        device("image.py"),
        'tone_map(film.layer("").mean), np.float32)',
        'tone_map(film.layer("").mean)[..., ::-1], np.float32)',
        ("tests/kernels/test_image.py::test_previews_show_colours_as_they_are",),
    ),
    Sin(
        "pictures read blue for red",
        device("picture.py"),
        "index - first for index in channels",
        "index - first for index in reversed(channels)",
        ("tests/kernels/test_light_image.py::test_reading",),
    ),
)
