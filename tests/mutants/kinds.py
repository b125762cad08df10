"""Mistakes in where things are: majorants, voxels, boxes, surfaces, lights, cameras, units."""

from __future__ import annotations

from tests.mutants.sin import Sin, device

MAJORANT, WALK = "tests/kernels/test_majorant.py", "tests/kernels/test_majorant_walk.py"
WALKS = f"{WALK}::test_walks_spend_optical_depth_as_the_oracle_does"

SINS = (
    Sin(
        "majorant's cell off by one",
        device("majorant/grid.h"),
        "floor(o + near * d), last)",
        "floor(o + near * d) + 1.f, last)",
        (WALKS,),
    ),
    Sin(
        "optical depth spent anew in every cell",
        device("majorant/grid.h"),
        "depth = pick(depth, depth - spent, walking);",
        "",
        (WALKS,),
    ),
    Sin(
        "the bound of the cell before",
        device("majorant/grid.h"),
        "walk->bound = pick(walk->bound, ahead.bound, walking);",
        "",
        (WALKS,),
    ),
    Sin(
        "majorant without the footprint of the interpolation",
        device("volume/media.py"),
        "0.5 if field.nearest else 1.0",
        "0.5",
        (f"{MAJORANT}::test_grid_bounds_what_it_covers",),
    ),
    Sin(
        "majorant not scaled",
        device("majorant/grid.py"),
        "return result * medium.scale",
        "return result",
        (f"{MAJORANT}::test_grid_bounds_what_it_covers",),
    ),
    Sin(
        "majorant of several grids is the last one's",
        device("majorant/grid.py"),
        "total[layer] += largest[",
        "total[layer] = largest[",
        (f"{MAJORANT}::test_grid_bounds_what_it_covers",),
    ),
    Sin(
        "densities relative to the majorant before it was raised",
        device("repair.py"),
        '"mean_free_path", "volume_grid": "relative"}',
        '"mean_free_path"}',
        ("tests/kernels/test_majorant_repair.py::test_a_majorant_too_low_is_raised",),
    ),
    Sin(
        "voxels half a cell off",
        device("volume/grid.h"),
        "real raised = x + 0.5f +",
        "real raised = x + 1.f +",
        ("tests/analytic/test_laws.py::test_beer_lambert_through_a_grid_per_pixel",),
    ),
    Sin(
        "voxels half a cell off, many media",
        device("volume/field.h"),
        "real raised = x + 0.5f +",
        "real raised = x +",
        ("tests/kernels/test_volume_media.py::test_one_tap_lookups_are_right_in_the_mean",),
    ),
    Sin(
        "trilinear weights the wrong way round",
        device("volume/field.h"),
        "weight[1] = x + 0.5f - to_real(raised);",
        "weight[1] = 1.f - (x + 0.5f - to_real(raised));",
        ("tests/kernels/test_volume_media.py::test_one_grid_with_an_albedo_grid_and_temperatures",),
    ),
    Sin(
        "rays end a thousandth before a box's face",
        device("core/box.h"),
        "return larger(t, (real)0.f);",
        "return larger(t - 1e-3f, (real)0.f);",
        ("tests/kernels/test_shape.py::test_distance_to_the_face_ahead",),
    ),
    Sin(
        "a grid's sides in the order of its file",
        device("volume/grid.py"),
        "np.array([width, height, depth], float)",
        "np.array([depth, height, width], float)",
        ("tests/analytic/test_laws.py::test_beer_lambert_through_a_grid_per_pixel",),
    ),
    Sin(
        "planes between voxels for those at their middles",
        device("core/cells.h"),
        "floor(p - offset) + (1 + offset)",
        "floor(p) + 1",
        ("tests/kernels/test_transmittance.py::test_grids_are_exact_at_any_thickness",),
    ),
    Sin(
        "normal flipped",
        device("surface/rectangle.py"),
        "np.copysign(1 / np.linalg.norm(n), n @ out)",
        "-np.copysign(1 / np.linalg.norm(n), n @ out)",
        ("tests/analytic/test_layers.py::test_a_wall",),
    ),
    Sin(
        "rays leave on the wrong side of a surface",
        device("surface/point.h"),
        "copysign(at.error, vector_dot(direction, at.geometric))",
        "copysign(at.error, -vector_dot(direction, at.geometric))",
        ("tests/kernels/test_surface.py::test_points_lie_within_their_error_and_rays_leave_for_good",),
    ),
    Sin(
        "a point's light falls off with the distance",
        device("light/point.h"),
        "inverse * inverse",
        "inverse",
        ("tests/kernels/test_light.py::test_point_and_spot",),
    ),
    Sin(
        "parallel light from the other side",
        device("light/directional.py"),
        "np.asarray(-direction / np.linalg.norm(direction))",
        "np.asarray(direction / np.linalg.norm(direction))",
        ("tests/analytic/test_closed_forms.py::test_a_wall_lit_through_a_grid",),
    ),
    Sin(
        "irradiance taken over the sun's disk without its cosine",
        device("light/sun.py"),
        "math.sin(math.radians(light.angular_radius)) ** 2)",
        "math.radians(light.angular_radius) ** 2)",
        ("tests/kernels/test_light.py::test_sun_radiance_is_that_of_its_irradiance",),
    ),
    Sin(
        "pixels half of one off",
        device("integrator/volumetric_path_full.cl"),
        "(to_real(x) + 0.5f + filter_offset",
        "(to_real(x) + filter_offset",
        ("tests/analytic/test_layers.py::test_a_wall",),
    ),
    Sin(
        "intensity scaled as a radiance times a length",
        device("space.py"),
        "-2 * self.length_exponent",
        "-self.length_exponent",
        ("tests/kernels/test_light.py::test_intensities_in_other_units_give_the_same_picture",),
    ),
    Sin(
        "coefficients scaled as lengths",
        device("space.py"),
        "np.ldexp(values, self.length_exponent)",
        "np.ldexp(values, -self.length_exponent)",
        ("tests/analytic/test_laws.py::test_beer_lambert_in_a_constant_medium",),
    ),
    Sin(
        "depth left in the kernel's units",
        device("layers.py"),
        '{"depth": length}',
        '{"depth": 0}',
        ("tests/kernels/test_layers.py::test_units",),
    ),
)
