"""The worked examples of D. Marsh, Applied Geometry for Computer Graphics and CAD, 2005."""

import json
from math import atan, atan2, cos, pi, sin, sqrt
from pathlib import Path

import numpy as np
import pytest

from splinearm.kinematics import DHConvention, DHLink, homogeneous, plane, solve_elbows

BOOK = json.loads((Path(__file__).parents[1] / "data" / "marsh_examples.json").read_text())
CASES = {case["id"]: case for case in BOOK["cases"]}
QUADRILATERAL = np.array(list(BOOK["quadrilateral"].values()))


def area(points):
    x, y = np.transpose(points)
    return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))


def test_every_example_of_the_book_is_tested_here():
    tested = {"1.4", "1.8", "1.11", "1.14", "1.15", "1.16", "1.17", "1.8.2", "2.1"}
    assert set(CASES) == tested | {"line", "lemma 1.5", "area"}


def test_example_1_4_an_affine_map_by_its_six_coefficients():
    k = CASES["1.4"]["coeff"]
    T = plane.from_parts([[k["a"], k["b"]], [k["d"], k["e"]]], [k["c"], k["f"]])
    np.testing.assert_array_equal(plane.apply(T, CASES["1.4"]["points"]), CASES["1.4"]["images"])


@pytest.mark.parametrize(
    ("case", "T"),
    [
        ("1.8", plane.translation((2.0, 1.0))),
        ("1.11", plane.scaling((2.0, 0.5))),
        ("1.14", plane.rotation(pi / 2)),
        ("1.16", plane.shear((2.0 / sqrt(5.0), 1.0 / sqrt(5.0)), 1.5)),
    ],
)
def test_examples_1_8_to_1_16_move_the_quadrilateral_as_printed(case, T):
    np.testing.assert_allclose(plane.apply(T, QUADRILATERAL), CASES[case]["images"], atol=1e-15)


def test_example_1_15_shear_along_x():
    image = plane.apply(plane.shear_along_x(0.7), [3.0, 2.0])
    np.testing.assert_allclose(image, [3.0 + 0.7 * 2.0, 2.0])
    np.testing.assert_array_equal(plane.shear((1.0, 0.0), 0.7), plane.shear_along_x(0.7))


def test_example_1_16_has_the_printed_matrix_transposed():
    T = plane.shear((2.0, 1.0), 1.5)
    np.testing.assert_allclose(T[:2, :2], np.transpose(CASES["1.16"]["row_matrix"]), atol=1e-15)


def test_example_1_17_rotation_then_scaling_has_the_printed_matrix_transposed():
    T = plane.concatenate(plane.rotation(pi / 3), plane.scaling((6.0, 2.0)))
    np.testing.assert_allclose(T[:2, :2], np.transpose(CASES["1.17"]["row_matrix"]), atol=1e-14)


@pytest.mark.parametrize("convention", DHConvention)
def test_section_1_8_2_link_angles_against_the_x_axis_are_sums_of_joint_angles(dh_arm, convention):
    d, X, Y, theta1, theta2 = 0.3, 0.25, 0.04, 0.7, 1.9
    if convention is DHConvention.STANDARD:
        rows, tool = [("one", d, 0, 0, 0), ("two", 0, 0, 0, 0)], (X, Y, 0.0)
    else:
        rows, tool = [("one", 0, 0, 0, 0), ("two", d, 0, 0, 0)], (X, Y, 0.0)
    T_flange_tool = np.eye(4)
    T_flange_tool[:3, 3] = tool
    arm = dh_arm([DHLink(*row) for row in rows], convention, T_flange_tool=T_flange_tool)
    p = arm.fk([theta1, theta2 - theta1])[:3, 3]
    closed = (
        X * cos(theta2) - Y * sin(theta2) + d * cos(theta1),
        X * sin(theta2) + Y * cos(theta2) + d * sin(theta1),
        0.0,
    )
    np.testing.assert_allclose(p, closed, atol=1e-15)


def test_section_1_8_2_is_undone_by_the_closed_form():
    d, X, theta1, theta2 = 0.3, 0.25, 0.7, 1.9
    tip = (X * cos(theta2) + d * cos(theta1), X * sin(theta2) + d * sin(theta1))
    down = solve_elbows(d, X, tip).down
    np.testing.assert_allclose(down, [theta1, theta2 - theta1], atol=1e-14)


def test_example_2_1_homogeneous_points_and_their_cartesian_ones():
    case = CASES["2.1"]
    np.testing.assert_allclose(homogeneous.to_cartesian(case["homogeneous"]), case["cartesian"])


def test_the_angle_between_lines_has_the_printed_tangent():
    a, b = np.array([1.0, 2.0, 3.0]), np.array([-2.0, 5.0, 1.0])
    tangent = (a[0] * b[1] - b[0] * a[1]) / (a[0] * b[0] + a[1] * b[1])
    assert homogeneous.angle_between_lines(a, b) == pytest.approx(atan(tangent), abs=1e-15)


def test_lines_are_parallel_exactly_when_the_printed_products_agree():
    assert homogeneous.are_parallel([2.0, 3.0, 1.0], [-4.0, -6.0, 5.0], tolerance=0.0)
    assert not homogeneous.are_parallel([2.0, 3.0, 1.0], [-4.0, -6.000001, 5.0])


def test_lemma_1_5_gives_the_image_of_a_line():
    a, b, c, d, e, f = 2.0, 3.0, 4.0, 5.0, 6.0, 7.0
    A, B, C = 1.5, -2.0, 0.75
    image = homogeneous.image(plane.from_parts([[a, b], [d, e]], [c, f]), [A, B, C])
    lemma = [
        e * A - d * B,
        a * B - b * A,
        (b * f - c * e) * A - (a * f - c * d) * B + (a * e - b * d) * C,
    ]
    np.testing.assert_allclose(image, lemma, rtol=1e-13)


def test_the_area_grows_by_the_determinant():
    T = plane.from_parts([[2.0, 3.0], [5.0, 6.0]], [4.0, 7.0])
    assert plane.area_factor(T) == pytest.approx(2.0 * 6.0 - 3.0 * 5.0)
    image = plane.apply(T, QUADRILATERAL)
    assert area(image) == pytest.approx(plane.area_factor(T) * area(QUADRILATERAL))


def test_the_angle_of_a_line_is_that_of_its_direction():
    x_axis, line = [0.0, 1.0, 0.0], homogeneous.line_through([0, 0, 1], [2, 1, 1])
    assert homogeneous.angle_between_lines(x_axis, line) == pytest.approx(atan2(1.0, 2.0))
