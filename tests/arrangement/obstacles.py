#!/usr/bin/env python3
"""Compares random obstacles with an exact arrangement: a point is covered if the rings of any polygon wind around it.

    python3 -m pip install -r tests/arrangement/requirements.txt
    cargo build --release -p tiletool
    python3 tests/arrangement/obstacles.py --seed 1 --seconds 60

Polygons have corners on small integer grids. They are nested, overlapping, touching, inside out, repeated, or have holes. Each
round builds them with `tiletool build`, with `--crossings error` or `split`, and checks:

- the result of the build. An error must be expected, and must name the first polygon that is inside out, or a crossing;
- each triangle: whether it is a hole, by the winding number of each polygon around its centroid, in rational numbers;
- the area of all holes, by shapely's arrangement of the same rings;
- the status of paths between points in obstacles and outside;
- `verify --deep --obstacles`;
- without crossings, the same for `constrain` on a file that has the first polygons only.

A crossing point is rounded, which bends its lines by less than 1e-9 here. If lines were split, centroids and points nearer to a line
than MARGIN are not checked. The last line has the totals; the exit code is 1 if a round failed.
"""

import argparse
import json
import math
import os
import random
import subprocess
import sys
import tempfile
import time
from collections import Counter
from fractions import Fraction
from pathlib import Path

from shapely import polygonize, union_all
from shapely.geometry import GeometryCollection, LineString, Point

MARGIN = 1e-6
LIMIT = 60


class Wrong(Exception):
    """The tool gave a wrong result."""


# --- polygons: a feature is a list of polygons, a polygon a list of rings, a ring a list of corners ---


def edges(ring):
    return [(a, b) for a, b in zip(ring, ring[1:] + ring[:1]) if a != b]


def double_area(ring):
    return sum(a[0] * b[1] - b[0] * a[1] for a, b in edges(ring))


def turn(a, b, c):
    value = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    return (value > 0) - (value < 0)


def directed(polygon):
    """Returns the edges of a polygon's rings: outer rings counter-clockwise, inner ones clockwise."""
    result = []
    outer_area = double_area(polygon[0]) if polygon else 0
    for number, ring in enumerate(polygon):
        area = double_area(ring)
        if number == 0:
            result += edges(ring[::-1] if area < 0 else ring)
        elif area != 0 and outer_area != 0:
            result += edges(ring[::-1] if area > 0 else ring)
    return result


def winding(lines, p):
    """Returns the winding number of closed lines around a point that is on none of them."""
    count = 0
    for a, b in lines:
        if a[1] <= p[1] < b[1]:
            count += turn(a, b, p) > 0
        elif b[1] <= p[1] < a[1]:
            count -= turn(a, b, p) < 0
    return count


def crossing(a, b, c, d):
    """Returns the point where two segments cross in their interiors, or None."""
    one, other = turn(a, b, c), turn(a, b, d)
    if one * other >= 0 or turn(c, d, a) * turn(c, d, b) >= 0:
        return None
    v = (b[0] - a[0]) * (d[1] - a[1]) - (b[1] - a[1]) * (d[0] - a[0])
    w = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    v, w = abs(v), abs(w)
    return (Fraction(v * c[0] + w * d[0], v + w), Fraction(v * c[1] + w * d[1], v + w))


def all_edges(polygon):
    return [edge for ring in polygon for edge in edges(ring)]


def crossings(one, other=None):
    """Returns the points where edges of `one` cross each other, or cross those of `other` if it is given."""
    if other is None:
        pairs = ((s, t) for i, s in enumerate(one) for t in one[:i])
    else:
        pairs = ((s, t) for s in one for t in other)
    points = (crossing(*s, *t) for s, t in pairs)
    return {point for point in points if point}


def faces(lines):
    """Returns the bounded faces of an arrangement of lines, by shapely."""
    if not lines:
        return []
    noded = union_all([LineString(line) for line in lines])
    return list(polygonize([noded]).geoms)


def inside(face):
    point = face.representative_point()
    return (Fraction(point.x), Fraction(point.y))


def net(lines):
    """Returns the lines without those that occur equally often in both directions, which do not change winding numbers."""
    counts = Counter()
    for a, b in lines:
        counts[min(a, b), max(a, b)] += 1 if a < b else -1
    return [line for line, count in counts.items() if count != 0]


def is_inverted(polygon):
    """Returns whether the winding number of a polygon is negative somewhere."""
    lines = directed(polygon)
    return any(winding(lines, inside(face)) < 0 for face in faces(lines))


def cover(features):
    """Returns the covered area, by shapely."""
    parts = []
    for polygon in (polygon for feature in features for polygon in feature):
        lines = directed(polygon)
        parts += [face for face in faces(lines) if winding(lines, inside(face)) != 0]
    return union_all(parts) if parts else GeometryCollection()


class Rule:
    """Decides whether a point is covered, in rational numbers."""

    def __init__(self, features):
        polygons = [polygon for feature in features for polygon in feature]
        self.directed = [directed(polygon) for polygon in polygons]
        lines = {tuple(sorted(edge)) for polygon in polygons for edge in all_edges(polygon)}
        self.lines = union_all([LineString(line) for line in lines]) if lines else GeometryCollection()

    def covers(self, point):
        return any(winding(lines, point) != 0 for lines in self.directed)

    def is_near(self, point):
        return not self.lines.is_empty and self.lines.distance(Point(float(point[0]), float(point[1]))) < MARGIN


# --- random obstacles ---


class Town:
    """Makes random polygons on a grid."""

    def __init__(self, rng):
        self.rng = rng
        self.size = rng.choice([4, 6, 8, 12, 20])
        self.polygons = []

    def spot(self):
        return (self.rng.randint(0, self.size), self.rng.randint(0, self.size))

    def rectangle(self, within=None):
        left, low, right, top = within or (0, 0, self.size, self.size)
        if right - left < 1 or top - low < 1:
            return [self.spot(), self.spot()]
        x = sorted(self.rng.sample(range(left, right + 1), 2))
        y = sorted(self.rng.sample(range(low, top + 1), 2))
        return [(x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1])]

    def with_holes(self):
        outer = self.rectangle()
        box = (outer[0][0], outer[0][1], outer[-2][0], outer[-2][1])
        holes = []
        for _ in range(self.rng.randint(1, 3)):
            kind = self.rng.random()
            if kind < 0.7:
                holes.append(self.rectangle(box))
            elif kind < 0.8 and holes:
                hole = holes[-1]
                holes.append(self.rectangle((hole[0][0], hole[0][1], hole[-2][0], hole[-2][1])))
            elif kind < 0.9:
                holes.append(list(outer))
            else:
                holes.append(self.rectangle())
        return [outer] + holes

    def ring(self):
        return [[self.spot() for _ in range(self.rng.randint(3, 8))]]

    def star(self):
        corners = list({self.spot() for _ in range(self.rng.randint(3, 9))})
        x = sum(p[0] for p in corners) / len(corners) + 0.01
        y = sum(p[1] for p in corners) / len(corners) + 0.003
        return [sorted(corners, key=lambda p: math.atan2(p[1] - y, p[0] - x))]

    def bow(self):
        """Returns two lobes with a common corner."""
        middle = self.spot()
        lobe = [self.spot() for _ in range(self.rng.randint(2, 3))]
        other = [self.spot() for _ in range(self.rng.randint(2, 3))]
        return [[middle] + lobe + [middle] + other]

    def symmetric(self):
        """Returns lobes that cancel out."""
        x, y = self.spot()
        w, h = self.rng.randint(1, 4), self.rng.randint(1, 4)
        ring = [(x - w, y - h), (x - w, y + h), (x, y), (x + w, y - h), (x + w, y + h), (x, y)]
        return [ring if self.rng.random() < 0.5 else [p for p in ring if p != (x, y)]]

    def several_times(self):
        rings = self.rng.choice([self.star, self.ring, self.bow])()
        return [rings[0] * self.rng.randint(2, 3)] + rings[1:]

    def spiky(self):
        ring = self.rng.choice([self.star, lambda: [self.rectangle()]])()[0]
        at = self.rng.randrange(len(ring))
        way = [self.spot() for _ in range(self.rng.randint(1, 2))]
        return [ring[: at + 1] + way + way[-2::-1] + ring[at:]]

    def again(self):
        if not self.polygons:
            return self.ring()
        polygon = self.rng.choice(self.polygons)
        kind = self.rng.random()
        if kind < 0.5:
            return polygon
        if kind < 0.7:
            return [ring[::-1] for ring in polygon]
        return [self.rectangle()] + [ring for ring in polygon]

    def polygon(self):
        makers = [
            (self.with_holes, 4),
            (self.ring, 3),
            (self.star, 4),
            (self.bow, 4),
            (self.symmetric, 1),
            (self.several_times, 1),
            (self.spiky, 2),
            (self.again, 2),
            (lambda: [self.rectangle()], 4),
        ]
        make = self.rng.choices([maker for maker, _ in makers], [weight for _, weight in makers])[0]
        polygon = make()
        if self.rng.random() < 0.3:
            polygon = [ring[::-1] for ring in polygon]
        if self.rng.random() < 0.2:
            at = self.rng.randrange(len(polygon[0])) if polygon[0] else 0
            polygon = [polygon[0][at:] + polygon[0][:at]] + polygon[1:]
        return polygon

    def features(self, may_cross):
        wanted = self.rng.randint(1, 7)
        lines, features = [], []
        for _ in range(40):
            polygon = self.polygon()
            own = all_edges(polygon)
            if not may_cross and (crossings(own) or crossings(own, lines)):
                continue
            lines += own
            self.polygons.append(polygon)
            if features and self.rng.random() < 0.25:
                features[-1].append(polygon)
            else:
                features.append([polygon])
            if len(self.polygons) == wanted:
                break
        return features


# --- the tool ---


def geojson(features):
    def closed(polygon):
        return [[list(p) for p in ring + ring[:1]] for ring in polygon]

    def geometry(feature):
        if len(feature) == 1:
            return {"type": "Polygon", "coordinates": closed(feature[0])}
        return {"type": "MultiPolygon", "coordinates": [closed(polygon) for polygon in feature]}

    members = [{"type": "Feature", "properties": {}, "geometry": geometry(feature)} for feature in features]
    return json.dumps({"type": "FeatureCollection", "features": members})


class Tool:
    def __init__(self, program, folder):
        self.program = program
        self.folder = folder

    def run(self, *args):
        command = [str(self.program)] + [str(arg) for arg in args]
        done = subprocess.run(command, cwd=self.folder, capture_output=True, text=True, timeout=LIMIT)
        if done.returncode not in (0, 1):
            raise Wrong(f"{' '.join(command)}: exit code {done.returncode}: {done.stderr}")
        return done

    def must(self, *args):
        done = self.run(*args)
        if done.returncode != 0:
            raise Wrong(f"{' '.join(str(arg) for arg in args)}: {done.stderr}")
        return done.stdout

    def triangles(self, file, *args):
        out = self.folder / "out.geojson"
        out.unlink(missing_ok=True)
        self.must("export", file, "-o", out, *args)
        shapes = [feature["geometry"] for feature in json.loads(out.read_text())["features"]]
        # If all points are collinear there are edges only.
        rings = [shape["coordinates"][0] for shape in shapes if shape["type"] == "Polygon"]
        return {tuple(tuple(p) for p in ring[:3]) for ring in rings}


def area_of(triangle):
    return double_area([tuple(map(Fraction, p)) for p in triangle]) / 2


def check_file(tool, file, obstacles, points, rule, covered, is_split):
    """Compares the triangles, the area and the verification of a file with the rule."""
    everything = tool.triangles(file, "--all")
    free = tool.triangles(file)
    for triangle in everything:
        middle = tuple(sum(Fraction(p[axis]) for p in triangle) / 3 for axis in (0, 1))
        if is_split and rule.is_near(middle):
            continue
        if rule.covers(middle) == (triangle in free):
            what = "free, but a polygon covers it" if triangle in free else "a hole, but no polygon covers it"
            raise Wrong(f"triangle {triangle} is {what}")
    holes = float(sum(area_of(triangle) for triangle in everything - free))
    if everything and abs(holes - covered.area) > 1e-6:
        raise Wrong(f"holes have an area of {holes}, and obstacles one of {covered.area}")
    against = ["--against", points] if points else []
    for path in obstacles:
        against += ["--obstacles", path]
    tool.must("verify", "--deep", file, *against)
    return bool(everything)


def check_paths(tool, file, rng, size, rule):
    """Compares the status of paths with the rule."""
    def point():
        return (rng.randint(-4, 4 * size + 4) / 4 + 0.0625, rng.randint(-4, 4 * size + 4) / 4 + 0.03125)

    ways = [(point(), point()) for _ in range(12)]
    exact = [[tuple(map(Fraction, p)) for p in way] for way in ways]
    ways = [way for way, ends in zip(ways, exact) if not any(rule.is_near(end) for end in ends)]
    if not ways:
        return 0
    batch = tool.folder / "ways.csv"
    batch.write_text("".join(f"{a[0]},{a[1]},{b[0]},{b[1]}\n" for a, b in ways))
    lines = tool.must("query", "path", file, "--batch", batch, "--csv").splitlines()[1:]
    if len(lines) != len(ways):
        raise Wrong(f"{len(ways)} paths were requested, but {len(lines)} were answered")
    for way, line in zip(ways, lines):
        status = line.split(",")[4]
        is_inside = any(rule.covers(tuple(map(Fraction, end))) for end in way)
        if (status == "inside_obstacle") != is_inside or status not in ("ok", "unreachable", "inside_obstacle"):
            raise Wrong(f"the status of the path {way} is {status}")
    return len(ways)


def expected_error(features, vertices):
    """Returns the error of a build that does not split: None, a polygon that is inside out (its feature), or crossing lines."""
    first, first_if_uncrossed = None, None
    for number, feature in enumerate(features):
        for polygon in feature:
            if not is_inverted(polygon):
                continue
            lines = directed(polygon)
            corners = {end for edge in net(lines) for end in edge}
            if crossings(net(lines)) - corners:
                first_if_uncrossed = number if first_if_uncrossed is None else first_if_uncrossed
            else:
                first = number if first is None else first
    if first is not None:
        return ("inverted", first)
    everything = [edge for feature in features for polygon in feature for edge in all_edges(polygon)]
    if crossings(everything) - vertices:
        return ("crossing", None)
    if first_if_uncrossed is not None:
        return ("inverted", first_if_uncrossed)
    return None


def check_error(done, expected):
    kind, feature = expected
    wanted = f"feature {feature} (counted from 0) is inside out" if kind == "inverted" else "cross"
    if done.returncode != 1 or wanted not in done.stderr or "panicked" in done.stderr:
        raise Wrong(f"the build should fail with “{wanted}”: exit code {done.returncode}, {done.stderr}")


def options(rng):
    result = ["--threads", rng.choice([1, 2])]
    if rng.random() < 0.5:
        result += ["--tile-vertices", rng.choice([4, 9, 30]), "--memory", rng.choice(["1MiB", "64MiB"])]
    return result


def check_constrain(tool, rng, features, rule, covered):
    """Adds the last polygons to a file of the first ones, and checks the result."""
    size = max((abs(v) for feature in features for p in feature for r in p for s in r for v in s), default=1) + 9
    frame = tool.folder / "frame.csv"
    frame.write_text(f"{-size},{-size}\n{size},{-size}\n{size},{size}\n{-size},{size}\n")
    first, rest = tool.folder / "first.geojson", tool.folder / "rest.geojson"
    at = rng.randint(0, len(features) - 1)
    first.write_text(geojson(features[:at]))
    rest.write_text(geojson(features[at:]))
    file = tool.folder / "edited.tiles"
    tool.must("build", frame, "--obstacles", first, "-o", file, "--force", *options(rng))
    before = file.read_bytes()
    done = tool.run("constrain", file, "--obstacles", rest)
    expected = expected_error(features[at:], set())
    if expected:
        number = expected[1]
        wanted = f"feature {number} (counted from 0): it is inside out"
        if done.returncode != 1 or wanted not in done.stderr or file.read_bytes() != before:
            raise Wrong(f"constrain should fail with “{wanted}”: exit code {done.returncode}, {done.stderr}")
    elif done.returncode != 0:
        if "there are no lines in these files" not in done.stderr:
            raise Wrong(f"constrain: {done.stderr}")
    else:
        check_file(tool, file, [first, rest], frame, rule, covered, False)


def round_of(seed, program, totals):
    rng = random.Random(seed)
    with tempfile.TemporaryDirectory() as folder:
        tool = Tool(program, Path(folder))
        town = Town(rng)
        may_cross, splits = rng.random() < 0.5, rng.random() < 0.5
        features = town.features(may_cross)
        if not features:
            return
        totals["polygons"] += len(town.polygons)
        obstacles = tool.folder / "obstacles.geojson"
        obstacles.write_text(geojson(features))
        points, vertices = None, {end for f in features for p in f for ring in p for end in ring}
        # Lines may cross in a vertex.
        if rng.random() < 0.4:
            grid = [(x, y) for x in range(-1, town.size + 2) for y in range(-1, town.size + 2)]
            points = tool.folder / "points.csv"
            points.write_text("".join(f"{x},{y}\n" for x, y in grid))
            vertices |= set(grid)
        file = tool.folder / "town.tiles"
        mode = ["--crossings", "split"] if splits else []
        given = [points] if points else []
        done = tool.run("build", *given, "--obstacles", obstacles, "-o", file, *mode, *options(rng))
        expected = None if splits else expected_error(features, vertices)
        if expected:
            totals["errors"] += 1
            return check_error(done, expected)
        if done.returncode != 0:
            raise Wrong(f"the build fails: {done.stderr}")
        rule, covered = Rule(features), cover(features)
        # Without triangles there are no paths.
        if check_file(tool, file, [obstacles], points, rule, covered, splits):
            totals["paths"] += check_paths(tool, file, rng, town.size, rule)
        if not may_cross and not splits and rng.random() < 0.5:
            check_constrain(tool, rng, features, rule, covered)


def main():
    parser = argparse.ArgumentParser(description="Compares random obstacles with an exact arrangement.")
    parser.add_argument("--seed", type=int, default=1, help="seed of the first round; each later round takes the next number")
    parser.add_argument("--seconds", type=float, default=10, help="starts no round after this time")
    parser.add_argument("--rounds", type=int, default=None, help="runs at most this number of rounds")
    default = Path(__file__).resolve().parents[2] / "target" / "release" / "tiletool"
    parser.add_argument("--tool", type=Path, default=default, help="the program tiletool")
    args = parser.parse_args()
    program = args.tool.resolve()
    if not os.access(program, os.X_OK):
        sys.exit(f"{program} is not a program; build it with: cargo build --release -p tiletool")
    end = time.monotonic() + args.seconds
    totals = {"polygons": 0, "errors": 0, "paths": 0}
    rounds, failed = 0, 0
    while time.monotonic() < end and (args.rounds is None or rounds < args.rounds):
        seed = args.seed + rounds
        rounds += 1
        try:
            round_of(seed, program, totals)
        except (Wrong, subprocess.TimeoutExpired) as error:
            failed += 1
            print(f"{error}\nrepeat it with: python3 {sys.argv[0]} --seed {seed} --rounds 1", file=sys.stderr)
    counts = ", ".join(f"{count} {name}" for name, count in totals.items())
    print(f"obstacles: {rounds} rounds, {counts}, {failed} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
