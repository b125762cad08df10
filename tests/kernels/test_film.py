"""Films merge by Chan's rule, know their samples, and come back from disk whole or not at all."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.conftest import Rng
from tests.statistics import accept_mean, accept_squares

from woodcock.batches import Batches
from woodcock.faults import Faults
from woodcock.film import LUMINANCE, Film, FilmError, join

FAULTS = Faults(nan=1, infinite=2, negative=3, unfinished=4, violations=2, touched=1.5, repaired=3)


def film(values: np.ndarray, start: int, bound: np.ndarray | None = None) -> Film:
    """The film of samples (n, h, w, c); channels beyond the third are orders of scattering."""
    n = len(values)
    mean = values.mean(axis=0)
    names = ("R", "G", "B", *(f"order.{order}.{c}" for order in ("0", "rest") for c in "RGB"))[: mean.shape[-1]]
    return Film(
        np.full(mean.shape[:2], n, np.uint32),
        mean,
        ((values - mean) ** 2).sum(axis=0),
        names if len(names) > 1 else ("Y",),
        ((start, start + n),),
        FAULTS,
        Batches(1, 0.0, n, float(mean.mean())),
        bound,
    )


def test_merging_is_the_film_of_all_samples() -> None:
    values = np.random.default_rng(1).lognormal(3, 2, (37, 4, 5, 3))
    parts = [film(values[a:b], a) for a, b in ((0, 5), (5, 6), (20, 37), (6, 20))]
    merged = Film.empty(5, 4, parts[0].names)
    for part in parts:
        merged = merged.merge(part)
    whole = film(values, 0)
    assert merged.ranges == whole.ranges
    assert merged.samples == 37
    assert np.array_equal(merged.count, whole.count)
    assert np.allclose(merged.mean, whole.mean, rtol=1e-14)
    assert np.allclose(merged.m2, whole.m2, rtol=1e-13)
    assert (merged.rejected, merged.violations) == (40, 8)
    assert merged.faults == FAULTS + FAULTS + FAULTS + FAULTS
    assert np.allclose(merged.variance(), values.var(axis=0, ddof=1) / 37)


def test_pixels_may_have_different_numbers_of_samples() -> None:
    """Each has the statistics of its own samples: 16 of the left pixels, 6 of the right ones."""
    values = np.random.default_rng(9).lognormal(0, 1, (16, 2, 4, 3))
    left = np.array([True, True, False, False])
    some = film(values[6:], 6)
    some = replace(some, count=some.count * left, mean=some.mean * left[:, None], m2=some.m2 * left[:, None])
    merged = film(values[:6], 0).merge(some)
    assert merged.samples == 16
    assert merged.mean_samples == 11
    assert np.array_equal(merged.count, np.where(left, 16, 6)[None].repeat(2, 0))
    for own, of in ((left, values[:, :, left]), (~left, values[:6][:, :, ~left])):
        assert np.allclose(merged.mean[:, own], of.mean(axis=0))
        assert np.allclose(merged.variance()[:, own], of.var(axis=0, ddof=1) / len(of))


def test_deviation_is_the_error_of_one_sample_of_every_pixel() -> None:
    values = np.random.default_rng(10).exponential(1, (50, 4, 6, 3))
    one = film(values, 0)
    assert one.mean_luminance_deviation() == pytest.approx(one.mean_luminance_error() * np.sqrt(50))
    half = replace(one, count=one.count.copy(), m2=one.m2.copy())
    half.count[:2] = 5
    half.m2[:2] *= 4 / 49
    assert half.mean_luminance_deviation() == pytest.approx(one.mean_luminance_deviation())
    assert half.mean_luminance_error() > 1.5 * one.mean_luminance_error()


def test_no_sample_counts_twice() -> None:
    values = np.ones((4, 2, 2, 1))
    with pytest.raises(FilmError, match="samples 2 to 4 would count twice"):
        film(values, 0).merge(film(values, 2))
    with pytest.raises(FilmError, match="cannot be merged"):
        film(values, 0).merge(Film.empty(3, 2, ("Y",)))
    with pytest.raises(FilmError, match="cannot be merged"):
        film(values, 0).merge(Film.empty(2, 2, ("depth.Z",)))


def test_ranges_join() -> None:
    assert join(((0, 2), (4, 6)), ((2, 4), (9, 10))) == ((0, 6), (9, 10))


def test_error_is_unknown_below_two_samples() -> None:
    assert np.isnan(film(np.ones((1, 2, 2, 1)), 0).rmse())
    assert film(np.ones((2, 2, 2, 1)), 0).rmse() == 0


def test_error_predicts_the_spread_of_pictures(rng: Rng) -> None:
    """rmse is the standard error that repeated films really have."""
    random = rng(5)
    films = [film(random.exponential(1, (16, 8, 8, 3)), 0) for _ in range(200)]
    said, spread = np.mean([f.variance() for f in films], axis=0), np.var([f.mean for f in films], axis=0, ddof=1)
    accept_mean((said - spread).reshape(-1), 0)
    squares = [(f.variance() @ LUMINANCE).mean() for f in films]
    assert [f.rmse() for f in films] == pytest.approx(np.sqrt(squares), rel=1e-12)


def test_layers_are_films_and_the_beauty_alone_counts() -> None:
    values = np.random.default_rng(4).random((8, 2, 3, 9))
    values[..., 3:6] *= 100
    whole = film(values, 0)
    assert whole.channels == 3
    for layer, first in (("", 0), ("order.0", 3), ("order.rest", 6)):
        part, expected = whole.layer(layer), film(values[..., first : first + 3], 0)
        assert part.names == ("R", "G", "B")
        assert part.ranges == whole.ranges
        assert np.array_equal(part.mean, expected.mean)
        assert part.rmse() == expected.rmse()
    assert whole.rmse() == whole.layer("").rmse()
    assert whole.mean_luminance() == whole.layer("").mean_luminance()


def test_error_of_the_mean_holds_for_channels_that_vary_together(rng: Rng) -> None:
    """Grey samples in three channels: the spread of repeated films' mean luminance is what is said."""
    random = rng(6)
    films = [film(random.exponential(1, (16, 8, 8, 1)).repeat(3, -1), 0) for _ in range(400)]
    said, spread = np.mean([f.mean_luminance_error() ** 2 for f in films]), np.var([f.mean_luminance() for f in films])
    accept_squares(len(films) * spread / said, len(films) - 1)


def test_bounds_merge_as_means_do() -> None:
    """Without noise a film has a bound in place of a variance, however its values differ over a pixel."""
    values = np.random.default_rng(8).random((4, 2, 2, 3))
    low, high = (np.full((2, 2, 3), bound) for bound in (0.1, 0.4))
    one, two = film(values[:1], 0, low), film(values[1:], 1, high)
    merged = Film.empty(2, 2, one.names).merge(one).merge(two)
    assert merged.bound is not None
    assert np.allclose(merged.bound, 0.1 / 4 + 0.4 * 3 / 4)
    assert merged.deterministic
    assert merged.rmse() == pytest.approx(0.325)
    assert (merged.variance() == 0).all()
    assert np.allclose(merged.mean, values.mean(axis=0))
    with pytest.raises(FilmError, match="one without cannot be merged"):
        one.merge(film(values[1:], 1))
    assert not Film.empty(2, 2, one.names).merge(film(values, 0)).deterministic


@pytest.mark.parametrize("bound", [None, np.full((4, 5, 3), 0.5)], ids=["noise", "bound"])
def test_saved_films_come_back(tmp_path: Path, bound: np.ndarray | None) -> None:
    path = tmp_path / "film.npz"
    one = film(np.random.default_rng(2).random((3, 4, 5, 3)), 7, bound)
    one.save(path)
    two = Film.load(path)
    assert (two.ranges, two.names) == (one.ranges, one.names)
    assert (two.faults, two.batches) == (one.faults, one.batches)
    for name in ("count", "mean", "m2", "bound"):
        assert np.array_equal(getattr(one, name), getattr(two, name))
    assert [file.name for file in tmp_path.iterdir()] == ["film.npz"]


@pytest.mark.parametrize("kept", [0, 10, 100, -1])
def test_a_torn_film_is_a_clear_error(tmp_path: Path, kept: int) -> None:
    path = tmp_path / "film.npz"
    film(np.ones((3, 4, 5, 3)), 0).save(path)
    path.write_bytes(path.read_bytes()[:kept])
    with pytest.raises(FilmError, match="not a film"):
        Film.load(path)


def test_a_film_with_a_flipped_bit_is_that_film_or_a_clear_error(tmp_path: Path) -> None:
    """Each bit of one byte in sixteen, and of those that tell how some of the parts are packed."""
    path = tmp_path / "film.npz"
    one = film(np.random.default_rng(2).random((3, 1, 2, 3)), 7)
    one.save(path)
    whole = path.read_bytes()
    headers = [at for mark in (b"PK\1\2", b"PK\3\4", b"PK\5\6") for at in starts(whole, mark)]
    for at in sorted({*range(0, len(whole), 16), *(start + byte for start in headers[::4] for byte in range(12))}):
        for bit in range(8):
            path.write_bytes(whole[:at] + bytes([whole[at] ^ 1 << bit]) + whole[at + 1 :])
            try:
                two = Film.load(path)
            except FilmError as error:
                assert "not a film" in str(error)  # noqa: PT017 - or it can be loaded
            else:
                assert (two.ranges, two.names) == (one.ranges, one.names)
                assert all(np.array_equal(getattr(one, name), getattr(two, name)) for name in ("count", "mean", "m2"))


def starts(content: bytes, mark: bytes) -> list[int]:
    return [at for at in range(len(content)) if content.startswith(mark, at)]


def test_a_failed_save_leaves_the_old_film(tmp_path: Path) -> None:
    path = tmp_path / "film.npz"
    film(np.ones((3, 4, 5, 3)), 0).save(path)
    old = path.read_bytes()
    broken = Film(np.ones((1, 1)), np.ones((1, 1, 1)), np.ones((1, 1, 1)), ("Y",), (("a", "b"),))  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="invalid literal"):
        broken.save(path)
    assert path.read_bytes() == old
    assert len(list(tmp_path.iterdir())) == 1


def test_luminance_is_that_of_rec_709() -> None:
    """Of its red, green and blue, by the standard's own numbers; errors weigh the same way."""
    values = np.array([[1.0, 2.0, 4.0], [3.0, 2.0, 8.0]])[:, None, None].repeat(2, axis=1).repeat(2, axis=2)
    whole = film(values, 0)
    assert whole.mean_luminance() == pytest.approx(0.2126 * 2 + 0.7152 * 2 + 0.0722 * 6)
    assert whole.rmse() == pytest.approx(np.sqrt(0.2126 * 1 + 0.7152 * 0 + 0.0722 * 4))
