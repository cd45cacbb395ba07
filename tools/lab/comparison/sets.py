"""Small sets of points that are difficult: they are exact binary numbers, the same on every machine."""

import math

import numpy


def circle():
    """Returns points whose distance from the centre is 1 but for rounding, so circles pass by them closely."""
    angles = numpy.arange(1000) * (2 * math.pi / 1000)
    return numpy.column_stack([numpy.cos(angles), numpy.sin(angles)])


def circle_exact():
    """Returns all points of whole numbers at distance 5^4 * 13^2 * 17 from the centre."""
    radius = 5**4 * 13**2 * 17
    found = set()
    for x in range(radius + 1):
        square = radius * radius - x * x
        y = math.isqrt(square)
        if y * y == square:
            found |= {(x, y), (x, -y), (-x, y), (-x, -y)}
    return numpy.array(sorted(found), float)


def grid(side=40, step=1.0, x=0.0, y=0.0):
    """Returns a square grid in random order."""
    points = numpy.stack(numpy.meshgrid(numpy.arange(side), numpy.arange(side)), axis=-1).reshape(-1, 2)
    numpy.random.default_rng(1).shuffle(points)
    return points * step + [x, y]


def line():
    return numpy.column_stack([numpy.arange(1000.0), 3 * numpy.arange(1000.0)])


def duplicates():
    """Returns 250 positions, each eight times."""
    numbers = numpy.random.default_rng(2)
    return numbers.permutation(numpy.repeat(numbers.random((250, 2)), 8, axis=0))


def clusters():
    """Returns clusters of a few metres, kilometres apart, in projected coordinates with steps of 1 mm."""
    numbers = numpy.random.default_rng(3)
    centres = numbers.integers(-20_000, 20_000, (20, 1, 2)) + numpy.array([5e5, 4e6])
    return numpy.round(centres + numbers.normal(0, 2, (20, 100, 2)), 3).reshape(-1, 2)


def nudged():
    """Returns runs of points on straight lines, each coordinate moved by at most one unit of the last place."""
    numbers = numpy.random.default_rng(4)
    runs = []
    for _ in range(10):
        start, step = numbers.random(2) + 1, (numbers.random(2) - 0.5) / 200
        points = start + numpy.arange(100)[:, None] * step
        towards = numbers.choice([-numpy.inf, numpy.inf], points.shape)
        runs.append(numpy.where(numbers.random(points.shape) < 0.5, numpy.nextafter(points, towards), points))
    return numpy.concatenate(runs)


def nudged_line():
    """Returns the points i/10, i/10, most of which are moved by one unit of the last place."""
    numbers = numpy.random.default_rng(5)
    points = numpy.repeat(numpy.arange(1, 501)[:, None] / 10, 2, axis=1)
    towards = numbers.choice([-numpy.inf, numpy.inf], points.shape)
    return numpy.where(numbers.random(points.shape) < 0.5, numpy.nextafter(points, towards), points)


def far_scales():
    """Returns points at distances from 1e-12 to 1e12 around the origin."""
    numbers = numpy.random.default_rng(6)
    angles, distances = numbers.random(1000) * 2 * math.pi, 10 ** (numbers.random(1000) * 24 - 12)
    return numpy.column_stack([distances * numpy.cos(angles), distances * numpy.sin(angles)])


def uniform():
    return numpy.random.default_rng(7).random((2000, 2))


def sets():
    """Returns the sets for Delaunay triangulations, by what the table calls them."""
    return {
        "uniform, for comparison": uniform(),
        "square grid": grid(),
        "grid in steps of 1 mm at 5e5, 4e6": grid(step=1e-3, x=5e5, y=4e6),
        "circle, rounded": circle(),
        "circle, exactly": circle_exact(),
        "on a line": line(),
        "nearly on a line, by an ulp": nudged_line(),
        "ten lines, by an ulp": nudged(),
        "each position eight times": duplicates(),
        "clusters at 5e5, 4e6, steps of 1 mm": clusters(),
        "distances from 1e-12 to 1e12": far_scales(),
    }


def segments_of_grid():
    """Returns a grid, and parallel segments through 20 of its points each, none of which are edges of squares."""
    points = numpy.stack(numpy.meshgrid(numpy.arange(40), numpy.arange(40)), axis=-1).reshape(-1, 2).astype(float)
    return points, numpy.array([(y * 40, (y + 19) * 40 + 38) for y in range(0, 21, 3)], "u4")


def segments_of_circle():
    """Returns rounded points on a circle and near-parallel chords between them."""
    points = circle()
    return points, numpy.array([(i, 1000 - i) for i in range(5, 496, 5)], "u4")


def segments_of_nudged():
    """Returns points by an ulp beside a line, and segments that pass every other one."""
    order = numpy.arange(0, 498, 2)
    return nudged_line(), numpy.column_stack([order, order + 2]).astype("u4")


def constrained_sets():
    """Returns the sets of points and segments."""
    return {
        "grid, 7 segments through 20 points each": segments_of_grid(),
        "circle, rounded, 99 chords": segments_of_circle(),
        "nearly on a line, 249 segments past every other point": segments_of_nudged(),
    }
