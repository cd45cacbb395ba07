"""The course of a build: its parts, its end, its errors, its files, and how it goes on after an interruption."""

from __future__ import annotations

import threading

import numpy as np
import pytest
from conftest import collection

import delaunay_tiles as dt

XY = np.random.default_rng(21).uniform(0, 9, (500, 2))
# So little memory that a build of many points has many blocks.
BLOCKS = {"memory": "12MiB", "tile_vertices": 4096, "threads": 1}

WALL = [[(1, 1), (8, 8)]]


def test_a_block_finishes_its_build(tmp_path):
    with dt.Builder(tmp_path / "t.tiles", tile_vertices=64) as builder:
        builder.add_lines(WALL, "walls")
        builder.add_sites(XY[:2])
        builder.add_points(XY[:100], name="first")
        builder.add_points(iter(XY[100:]))
        assert builder.summary is None and not (tmp_path / "t.tiles").exists()
    dt.build(XY, tmp_path / "u.tiles", walls=WALL, sites=XY[:2])
    assert builder.summary.points == 500 and builder.summary.sites == 2 and builder.summary.tiles > 4
    assert dt.open(tmp_path / "t.tiles").digest() == dt.open(tmp_path / "u.tiles").digest()
    with pytest.raises(RuntimeError, match="finished"):
        builder.add_points(XY)
    with pytest.raises(RuntimeError, match="finished"):
        builder.finish()
    builder.close()


def test_an_exception_in_a_block_discards_its_build(tmp_path):
    with pytest.raises(ZeroDivisionError), dt.Builder(tmp_path / "t.tiles") as builder:
        builder.add_points(XY)
        1 / 0  # noqa: B018
    assert not list(tmp_path.iterdir()) and builder.summary is None


def test_a_builder_that_is_forgotten_leaves_no_file(tmp_path):
    builder = dt.Builder(tmp_path / "t.tiles")
    builder.add_points(XY)
    del builder
    assert not list(tmp_path.iterdir())


def test_a_finished_block_is_not_built_twice(tmp_path):
    with dt.Builder(tmp_path / "t.tiles") as builder:
        builder.add_points(XY)
        summary = builder.finish()
    assert builder.summary is summary and summary.vertices == 500


def test_lines_and_sites_must_come_before_points(tmp_path):
    with dt.Builder(tmp_path / "t.tiles") as builder:
        builder.add_points(XY)
        with pytest.raises(ValueError, match="before"):
            builder.add_lines(WALL)
        with pytest.raises(ValueError, match="before"):
            builder.add_sites(XY[:2])
        with pytest.raises(ValueError, match="before"):
            builder.add_lines([[(0, 0), (1, 0), (1, 1)]], "ponds")
        with pytest.raises(ValueError, match="kind"):
            builder.add_lines(WALL, "fences")
    assert builder.summary.constraint_edges == 0


def test_a_refused_input_does_not_end_a_build(tmp_path):
    with dt.Builder(tmp_path / "t.tiles") as builder:
        for wrong in ([("a", "b")], np.zeros((3, 5)), "none.csv", {"x": [1]}):
            with pytest.raises((OSError, TypeError, ValueError)):
                builder.add_points(wrong)
        builder.add_points(XY)
    assert builder.summary.points == 500


def test_rings_that_do_not_close_are_noted(tmp_path):
    summary = dt.build(XY, tmp_path / "t.tiles", obstacles=[[(1, 1), (4, 1), (4, 4)]])
    assert summary.notes == ("obstacles: 1 rings do not end where they begin; they were closed",)


def test_an_output_that_exists_is_kept_unless_it_may_be_replaced(tmp_path):
    out = tmp_path / "t.tiles"
    dt.build(XY, out)
    before = out.read_bytes()
    with pytest.raises(FileExistsError, match=r"t\.tiles.*overwrite=True"):
        dt.build(XY[:9], out)
    with pytest.raises(ValueError, match="record 0"):
        dt.build([(np.nan, 1)], out, overwrite=True)
    assert out.read_bytes() == before and [path.name for path in tmp_path.iterdir()] == ["t.tiles"]
    assert dt.build(XY[:9], out, overwrite=True).points == 9


@pytest.mark.parametrize("out", ["no/folder/t.tiles", "."])
def test_an_output_that_cannot_be_written_is_an_error_of_the_system(out, tmp_path):
    with pytest.raises((OSError, dt.BuildError)):
        dt.build(XY, tmp_path / out, overwrite=True)
    assert not list(tmp_path.iterdir())


def crs_of(folder, **options) -> str | None:
    dt.build(options.pop("points", XY), folder / "t.tiles", overwrite=True, **options)
    return dt.open(folder / "t.tiles").crs


def test_the_coordinate_reference_system_comes_from_arguments_or_inputs(tmp_path):
    geopandas, pyproj = pytest.importorskip("geopandas"), pytest.importorskip("pyproj")
    points = geopandas.GeoSeries.from_xy(*XY.T, crs="EPSG:25832")
    lines = geopandas.GeoSeries.from_wkt(["LINESTRING(1 1, 8 8)"], crs=4326)
    assert crs_of(tmp_path) is None
    assert crs_of(tmp_path, crs="EPSG:2056") == "EPSG:2056"
    assert crs_of(tmp_path, crs=pyproj.CRS(2056)) == "EPSG:2056"
    assert crs_of(tmp_path, points=points) == crs_of(tmp_path, points=[points[:3], points[3:]]) == "EPSG:25832"
    assert crs_of(tmp_path, lines=lines) == crs_of(tmp_path, sites=points[:2].to_crs(4326)) == "EPSG:4326"
    custom = pyproj.CRS("+proj=laea +lat_0=10 +lon_0=20")
    assert pyproj.CRS(crs_of(tmp_path, points=points.set_crs(custom, allow_override=True))) == custom
    with pytest.raises(dt.InputError, match=r"EPSG:4326.*EPSG:25832|EPSG:25832.*EPSG:4326") as conflict:
        crs_of(tmp_path, points=points, lines=lines)
    assert "crs" in str(conflict.value)
    assert crs_of(tmp_path, points=points, lines=lines, crs="EPSG:3857") == "EPSG:3857"


def test_progress_is_told_and_its_exceptions_end_the_build(tmp_path):
    rows = np.random.default_rng(1).random((150_000, 2))
    states = []
    dt.build(rows, tmp_path / "t.tiles", progress=lambda *state: states.append(state))
    assert states and all(isinstance(name, str) and 0 <= done for name, done, total in states)

    def fail(*_):
        raise LookupError("enough")

    with pytest.raises(LookupError, match="enough"):
        dt.build(rows, tmp_path / "u.tiles", progress=fail)
    assert [path.name for path in tmp_path.iterdir()] == ["t.tiles"]


def test_a_bar_or_lines_show_progress(tmp_path, capsys, monkeypatch):
    dt.build(XY, tmp_path / "t.tiles", progress=True)
    monkeypatch.setitem(__import__("sys").modules, "tqdm.auto", None)
    dt.build(XY, tmp_path / "t.tiles", progress=True, overwrite=True)
    capsys.readouterr()


def test_threads_build_files_at_once(tmp_path):
    def build(number: int) -> None:
        dt.build(XY[number:], tmp_path / f"{number}.tiles", memory="32MiB", threads=1)

    threads = [threading.Thread(target=build, args=(number,)) for number in range(6)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert [dt.open(tmp_path / f"{number}.tiles").metadata.points for number in range(6)] == [*range(500, 494, -1)]


def test_a_build_that_another_thread_uses_is_refused(tmp_path):
    builder = dt.Builder(tmp_path / "t.tiles")
    begun, end = threading.Event(), threading.Event()

    def batches():
        import pyarrow

        yield pyarrow.record_batch({"x": XY[:, 0], "y": XY[:, 1]})
        begun.set()
        end.wait(20)

    import pyarrow

    schema = pyarrow.schema([("x", "f8"), ("y", "f8")])
    stream = pyarrow.RecordBatchReader.from_batches(schema, batches())
    thread = threading.Thread(target=builder.add_points, args=(stream,))
    thread.start()
    begun.wait(20)
    with pytest.raises(RuntimeError, match="another thread"):
        builder.add_points(XY)
    end.set()
    thread.join()
    assert builder.finish().points == 500


class Interruption:
    """Interrupts a build when its blocks are half done."""

    def __init__(self) -> None:
        self.phases = []

    def __call__(self, phase: str, done: int, total: int) -> None:
        self.phases.append(phase)
        if phase == self.phases[0] or done * 3 < total:
            return
        raise KeyboardInterrupt


def test_an_interrupted_build_of_a_file_goes_on(tmp_path):
    points = tmp_path / "points.f64"
    np.random.default_rng(2).random((600_000, 2)).tofile(points)
    dt.build(points, tmp_path / "whole.tiles", **BLOCKS)
    out = tmp_path / "t.tiles"
    with pytest.raises(KeyboardInterrupt):
        dt.build(points, out, **BLOCKS, progress=Interruption())
    assert not out.exists()
    kept = [path.name for path in tmp_path.iterdir() if path.name.startswith("t.tiles")]
    assert kept, "the work of a build that can be resumed stays"
    with pytest.raises(FileExistsError, match="resume=True"):
        dt.build(points, out, **BLOCKS)
    summary = dt.build(points, out, **BLOCKS, resume=True)
    assert summary.resumed_blocks > 0 and summary.points == 600_000
    assert dt.open(out).digest() == dt.open(tmp_path / "whole.tiles").digest()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["points.f64", "t.tiles", "whole.tiles"]


def test_an_interrupted_build_with_lines_goes_on_with_the_same_lines_only(tmp_path):
    points, walls, sites, out = (tmp_path / name for name in ("p.f64", "walls.geojson", "s.csv", "t.tiles"))
    np.random.default_rng(2).random((600_000, 2)).tofile(points)
    walls.write_text(collection("LineString", [[[0.1, 0.1], [0.5, 0.52], [0.9, 0.2]]]))
    sites.write_text("0.3,0.4\n0.6,0.7\n")
    given = {**BLOCKS, "walls": walls, "sites": [sites]}
    whole = dt.build(points, tmp_path / "whole.tiles", **given)
    with pytest.raises(KeyboardInterrupt):
        dt.build(points, out, **given, progress=Interruption())
    with pytest.raises(dt.BuildError, match="other inputs or options"):
        dt.build(points, out, **BLOCKS, walls=walls, resume=True)
    summary = dt.build(points, out, **given, resume=True)
    assert summary.resumed_blocks > 0 and summary.constraint_edges == whole.constraint_edges > 0
    assert out.read_bytes() == (tmp_path / "whole.tiles").read_bytes()


def test_other_builds_cannot_be_resumed(tmp_path):
    (tmp_path / "p.csv").write_text("0,0\n1,0\n0,1\n")
    (tmp_path / "l.geojson").write_text(collection("LineString", [[[0, 0], [1, 1]]]))
    for points, options in (
        (XY, {}),
        (None, {"lines": tmp_path / "l.geojson"}),
        (tmp_path / "p.csv", {"lines": [XY[:2]]}),
        (tmp_path / "p.csv", {"holes": XY[:1]}),
        ([tmp_path / "p.csv"], {}),
    ):
        with pytest.raises(ValueError, match="only a build of one file of points"):
            dt.build(points, tmp_path / "t.tiles", resume=True, **options)
    # Without work to resume, a build begins.
    assert dt.build(tmp_path / "p.csv", tmp_path / "t.tiles", resume=True).triangles == 1
