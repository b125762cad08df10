"""Mistakes in what is rendered next: contracts, judges, pieces, launches over some of the pixels."""

from __future__ import annotations

from tests.mutants.sin import Sin, device

CONTRACT = "tests/kernels/test_contract.py"
RENDER = "tests/kernels/test_render.py"
RANGES = "tests/server/test_ranges.py"

SINS = (
    Sin(
        "pixels decide on themselves",
        device("judging.py"),
        "np.roll(ring, -1)",
        "ring",
        (f"{CONTRACT}::test_a_pixel_is_never_judged_by_its_own_colour",),
    ),
    Sin(
        "judges are judged by those they judge",
        device("judging.py"),
        "(board == following) & np.isfinite",
        "(board != colour) & np.isfinite",
        (f"{CONTRACT}::test_a_pixel_is_never_judged_by_its_own_colour",),
    ),
    Sin(
        "judges are taken for sure of themselves",
        device("judging.py"),
        "(mean + error)[np.ix_",
        "mean[np.ix_",
        (f"{CONTRACT}::test_judges_that_differ_ask_for_a_standard_error_more",),
    ),
    Sin(
        "rounds go on for what the aim leaves",
        device("judging.py"),
        "(asked > samples)",
        "(asked / AIM**2 > samples)",
        (f"{CONTRACT}::test_what_is_met_within_the_aim_is_left_alone",),
    ),
    Sin(
        "the pilot is rendered and not counted",
        device("contract.py"),
        "needed - film.count, 0,",
        "needed, 0,",
        (f"{CONTRACT}::test_numbers_are_what_the_error_asks_for",),
    ),
    Sin(
        "a sample means two things",
        device("contract.py"),
        "Piece(start + last, start + samples,",
        "Piece(start, start + samples,",
        (f"{CONTRACT}::test_a_round_asks_for_every_sample_once",),
    ),
    Sin(
        "what is done is handed out",
        device("contract.py"),
        "pieces.append(Piece(start, min(first, end), None))",
        "pieces.append(Piece(start, end, None))",
        (f"{CONTRACT}::test_a_round_of_samples_is_what_is_missing",),
    ),
    Sin(
        "a sample between two ranges is lost",
        device("contract.py"),
        "[Piece(middle, self.stop, self.pixels)]",
        "[Piece(middle + 1, self.stop, self.pixels)]",
        (f"{CONTRACT}::test_pieces_are_cut_anywhere",),
    ),
    Sin(
        "a list's pixels are put into the picture in order",
        device("render.py"),
        "picture[pixels] = values",
        "picture[np.sort(pixels)] = values",
        (f"{RENDER}::test_a_pixel_is_the_same_in_a_list",),
    ),
    Sin(
        "random numbers by the place in the list",
        device("program.py"),
        'f", gather(int, pixels, {lane})" if layout.listed',
        'f", {lane}" if layout.listed',
        (f"{RENDER}::test_a_pixel_is_the_same_in_a_list",),
    ),
    Sin(
        "faults of lanes beyond the list",
        device("launch.py"),
        "faults[:, :pixels]",
        "faults",
        (f"{RENDER}::test_faults_are_those_of_the_pixels_in_the_list",),
    ),
    Sin(
        "a launch over some pixels counts as one over all",
        device("render.py"),
        "film.mean_luminance())) if pixels is None else film",
        "film.mean_luminance()))",
        (f"{RENDER}::test_launches_of_some_pixels_are_no_batches",),
    ),
    Sin(
        "launches are held against pixels with more samples",
        device("certificate.py"),
        "launches * (by_variances / pixels if pixels > 0 else film.mean_samples**-0.5)",
        "launches * film.samples**-0.5",
        ("tests/kernels/test_certificate.py::test_launches_are_compared_with_pixels_that_have_more_samples",),
    ),
    Sin(
        "few pixels are taken to cost as much as all",
        device("pace.py"),
        "self.rate = samples * pixels /",
        "self.rate = samples /",
        (f"{RANGES}::test_few_pixels_take_less_time",),
    ),
)
