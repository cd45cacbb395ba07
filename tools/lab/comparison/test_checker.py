#!/usr/bin/env python3
"""Tests that the checker accepts what is Delaunay, and refuses what is not: tools/lab/comparison/test_checker.py runs them."""

import random
import unittest
from itertools import combinations

from checker import check, hull, in_circle, turn, whole

SQUARE = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
# The fourth point is inside the circle of the first three, so only the diagonal 1-3 is Delaunay.
KITE = [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.5, 1.5)]


def by_definition(points):
    """Returns the triangles whose circles have no point inside: of points of which no four are on a circle."""
    exact = whole(points)
    found = []
    for a, b, c in combinations(range(len(points)), 3):
        if turn(exact[a], exact[b], exact[c]) < 0:
            b, c = c, b
        others = (p for number, p in enumerate(exact) if number not in (a, b, c))
        if all(in_circle(exact[a], exact[b], exact[c], p) < 0 for p in others):
            found.append((a, b, c))
    return found


class Accepts(unittest.TestCase):
    def test_both_diagonals_of_a_square(self):
        self.assertTrue(check(SQUARE, [(0, 1, 2), (0, 2, 3)]).correct())
        self.assertTrue(check(SQUARE, [(0, 1, 3), (1, 2, 3)]).correct())

    def test_triangles_by_definition(self):
        for seed in range(20):
            numbers = random.Random(seed)
            points = [(numbers.random(), numbers.random()) for _ in range(12)]
            self.assertTrue(check(points, by_definition(points)).correct())

    def test_duplicates_and_points_on_a_side_of_the_hull(self):
        points = [*SQUARE, (0.5, 0.0), (0.5, 0.0)]
        self.assertTrue(check(points, [(0, 5, 3), (4, 1, 2), (4, 2, 3)]).correct())

    def test_points_on_a_line_without_triangles(self):
        self.assertTrue(check([(0.0, 0.0), (1.0, 1.0), (3.0, 3.0)], []).correct())

    def test_polygons_in_any_order(self):
        self.assertTrue(check(SQUARE, [(0, 2, 1), (0, 2, 3)], polygons=True).correct())

    def test_a_constraint_that_is_not_delaunay(self):
        self.assertTrue(check(KITE, [(0, 1, 2), (0, 2, 3)], segments=[(0, 2)]).correct())


class Refuses(unittest.TestCase):
    def refuse(self, said, points, corners, **more):
        self.assertIn(said, str(check(points, corners, **more)))

    def test_the_other_diagonal(self):
        self.assertTrue(check(KITE, [(0, 1, 3), (1, 2, 3)]).correct())
        self.refuse("2 wrong triangles", KITE, [(0, 1, 2), (0, 2, 3)])

    def test_any_flipped_edge(self):
        numbers = random.Random(7)
        points = [(numbers.random(), numbers.random()) for _ in range(12)]
        triangles, exact, flips = by_definition(points), whole(points), 0
        for one, other in combinations(triangles, 2):
            shared = set(one) & set(other)
            if len(shared) != 2:
                continue
            c, d = (set(one) - shared).pop(), (set(other) - shared).pop()
            a, b = (corner for corner in shared)
            if turn(exact[c], exact[d], exact[a]) < 0:
                a, b = b, a
            if turn(exact[c], exact[d], exact[a]) * turn(exact[d], exact[c], exact[b]) <= 0:
                continue
            flips += 1
            rest = [triangle for triangle in triangles if triangle not in (one, other)]
            self.assertFalse(check(points, [*rest, (c, d, a), (d, c, b)]).correct())
        self.assertGreater(flips, 5)

    def test_an_error_in_the_last_bit(self):
        # The last point is inside the circle by one unit of the last place.
        points = [(1e6, 0.0), (1e6 + 1, 0.0), (1e6 + 1, 1.0), (1e6, 1 - 2.0**-53)]
        self.refuse("2 wrong triangles", points, [(0, 1, 2), (0, 2, 3)])
        self.assertTrue(check(points, [(0, 1, 3), (1, 2, 3)]).correct())

    def test_a_missing_triangle(self):
        self.refuse("does not fill the hull", SQUARE, [(0, 1, 2)])

    def test_a_clockwise_triangle(self):
        self.refuse("2 wrong triangles", SQUARE, [(0, 2, 1), (0, 2, 3)])

    def test_a_flat_triangle_at_the_hull(self):
        points = [*SQUARE, (0.5, 0.0)]
        self.refuse("2 wrong triangles", points, [(0, 4, 1), (0, 1, 2), (0, 2, 3)])

    def test_a_triangle_that_is_there_twice(self):
        self.refuse("2 wrong triangles, overlaps", SQUARE, [(0, 1, 2), (0, 1, 2), (0, 2, 3)])

    def test_a_point_that_is_no_corner(self):
        self.refuse("1 missing points", [*SQUARE, (0.5, 0.25)], [(0, 1, 2), (0, 2, 3)])

    def test_a_point_on_the_hull_that_is_no_corner(self):
        self.refuse("1 missing points", [*SQUARE, (0.5, 0.0)], [(0, 1, 2), (0, 2, 3)])

    def test_a_corner_that_is_moved(self):
        moved = [*SQUARE[:2], (1.0, 1 + 2.0**-52), SQUARE[3]]
        self.refuse("1 corners that are no points", SQUARE, [(0, 1, 3), (1, 2, 3)], vertices=moved)

    def test_a_segment_that_is_no_edge(self):
        self.refuse("1 missing segments", KITE, [(0, 1, 3), (1, 2, 3)], segments=[(0, 2)])

    def test_triangles_of_points_on_a_line(self):
        self.refuse("wrong", [(0.0, 0.0), (1.0, 1.0), (3.0, 3.0)], [(0, 1, 2)])


class Hull(unittest.TestCase):
    def test_points_within_sides_are_on_it(self):
        points = [(0, 0), (1, 0), (2, 0), (2, 1), (2, 2), (1, 1), (0, 2)]
        self.assertEqual(hull(points), [(0, 0), (1, 0), (2, 0), (2, 1), (2, 2), (0, 2)])


if __name__ == "__main__":
    unittest.main()
