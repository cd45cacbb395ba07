"""Exports have the bytes of the tool's; maps and objects of other packages have all triangles."""

from __future__ import annotations

import asyncio
import json
from pathlib import Path

import numpy as np
import pytest
from conftest import collection

import delaunay_tiles as dt

RING = [(15.0, 20.0), (70.0, 15.0), (60.0, 75.0), (15.0, 20.0)]

EXPORTS = [
    ("t.ply", {}, []),
    ("t.ply", {"edges": True, "holes": True}, ["--edges", "--all"]),
    ("t.node", {}, []),
    ("t.obj", {}, []),
    ("t.glb", {}, []),
    ("t.geojson", {"what": "edges"}, ["--what", "edges"]),
    ("t.geojson", {"contours": 7.5, "base": 1}, ["--contours", 7.5, "--base", 1]),
    ("t.geojson", {"max_edge": 3.5}, ["--max-edge", 3.5]),
    ("t.geojson", {"max_edge": np.float64(6), "from_hull": True}, ["--max-edge", 6, "--from-hull"]),
    ("t.fgb", {"what": "vertices"}, ["--what", "vertices"]),
    ("t.tif", {"resolution": 2, "cog": True}, ["--resolution", 2, "--cog"]),
    ("t.tif", {"resolution": 1.5, "bounds": (10, 10, 40, 30.5)}, ["--resolution", 1.5, "--bounds", "10,10,40,30.5"]),
    ("t.tif", {"resolution": 2, "float32": True}, ["--resolution", 2, "--float32"]),
    ("t.asc", {"resolution": 5, "what": "slope"}, ["--resolution", 5, "--what", "slope"]),
    ("t.bin", {"format": "ply", "memory": "1GiB"}, ["--format", "ply"]),
]


def files_of(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.mark.parametrize("number", range(len(EXPORTS)))
def test_exports_have_the_bytes_of_the_tool(survey, run, tmp_path, monkeypatch, number):
    name, ours, theirs = EXPORTS[number]
    for folder in ("ours", "theirs", "async"):
        (tmp_path / folder).mkdir()
    # Some formats name their file.
    run("export", survey.name, "-o", name, *theirs, cwd=tmp_path / "theirs")
    monkeypatch.chdir(tmp_path / "ours")
    summary = survey.export(name, **ours)
    expected = files_of(tmp_path / "theirs")
    assert files_of(tmp_path / "ours") == expected
    assert sorted(Path(file).name for file in summary["files"]) == sorted(expected)
    assert summary["bytes"] == sum(map(len, expected.values()))

    async def export() -> dict:
        return await (await dt.aopen(survey.name)).export(name, **ours)

    monkeypatch.chdir(tmp_path / "async")
    asyncio.run(export())
    assert files_of(tmp_path / "async") == expected


def test_clipped_exports_have_the_bytes_of_the_tool(survey, run, tmp_path):
    shapely = pytest.importorskip("shapely")
    (tmp_path / "clip.geojson").write_text(collection("Polygon", [[RING]]))
    for name, options, given in (
        ("a.geojson", {}, []),
        ("a.asc", {"resolution": 4}, ["--resolution", 4]),
        ("b.geojson", {"contours": 9}, ["--contours", 9]),
    ):
        run("export", survey.name, "-o", tmp_path / name, "--clip", tmp_path / "clip.geojson", *given)
        expected = (tmp_path / name).read_bytes()
        survey.export(tmp_path / name, clip=shapely.Polygon(RING), **options)
        assert (tmp_path / name).read_bytes() == expected


def test_parquet_has_the_triangles(survey, tmp_path):
    geopandas = pytest.importorskip("geopandas")
    survey.export(tmp_path / "t.parquet", holes=True)
    frame = geopandas.read_parquet(tmp_path / "t.parquet")
    ours = survey.to_geopandas()
    assert sorted(frame.normalize().to_wkb()) == sorted(ours.normalize().to_wkb()) and frame.crs == ours.crs


WRONG = [
    ("t.docx", {}, "docx"),
    ("t", {}, "suffix"),
    ("-", {"format": "ply"}, "standard output"),
    ("t.ply", {"nope": 3}, "nope"),
    ("t.ply", {"no_pe": True}, "no_pe"),
    ("t.ply", {"what": "faces"}, "what"),
    ("t.ply", {"contours": 5}, "contours is for geojson"),
    ("t.ply", {"help": True}, "help is no option"),
    ("t.ply", {"output": "other.ply"}, "output is no option"),
    ("t.ply", {"max_edge": -1}, "max_edge must be a number above 0"),
    ("t.ply", {"from_hull": True}, "from_hull needs max_edge"),
    ("t.tif", {}, "resolution"),
    ("t.tif", {"resolution": 0}, "resolution"),
    ("t.tif", {"resolution": float("nan")}, "resolution"),
    ("t.tif", {"resolution": 1, "bounds": (5, 5, 0, 0)}, "bounds"),
    ("t.tif", {"resolution": 1, "bounds": (5, 5)}, "bounds"),
    ("t.asc", {"resolution": 1, "cog": True}, "cog is for tif"),
    ("t.ply", {"memory": "some"}, "memory"),
]


@pytest.mark.parametrize(("name", "options", "text"), WRONG, ids=[str(row[:2]) for row in WRONG])
def test_wrong_options_are_named_and_leave_no_file(survey, tmp_path, monkeypatch, name, options, text):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ValueError, match=text) as refused:
        survey.export(name, **options)
    assert "--" not in str(refused.value) and not list(tmp_path.iterdir())


def test_faults_of_exports_have_their_exceptions(survey, small, tmp_path):
    with pytest.raises(FileNotFoundError, match="does not exist"):
        survey.export(tmp_path / "no" / "t.ply")
    with pytest.raises(TypeError, match="out must be a path"):
        survey.export(None)
    with pytest.raises(dt.QueryError, match="has no z"):
        small["line"].export(tmp_path / "t.geojson", contours=5)
    with pytest.raises(dt.QueryError, match="has no z"):
        small["line"].export(tmp_path / "t.tif", resolution=1)
    before = Path(survey.name).read_bytes()
    with pytest.raises(dt.Error, match="the tile file itself"):
        survey.export(survey.name, format="ply")
    assert Path(survey.name).read_bytes() == before and not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["none", "one", "two", "line"])
def test_small_files_are_exported(small, name, run, tmp_path):
    t = small[name]
    for suffix in ("ply", "obj", "geojson"):
        run("export", t.name, "-o", tmp_path / f"theirs.{suffix}")
        assert t.export(tmp_path / f"ours.{suffix}")["files"]
        assert (tmp_path / f"ours.{suffix}").read_bytes() == (tmp_path / f"theirs.{suffix}").read_bytes()
    assert t.plot().png.startswith(b"\x89PNG")
    assert len(t.to_meshio().cells[0].data) == len(t.to_geopandas()) == 0


def test_maps_are_pictures(small, tmp_path):
    t = small["line"]
    picture = t.plot()
    assert picture._repr_png_().startswith(b"\x89PNG") and "PNG" in repr(picture)
    assert t.plot(tmp_path / "map.png") is None and t.plot(str(tmp_path / "map.svg")) is None
    assert (tmp_path / "map.png").read_bytes() == picture.png
    assert b"<svg" in (tmp_path / "map.svg").read_bytes()[:300]
    with pytest.raises(ValueError, match=r"\.svg or \.png"):
        t.plot(tmp_path / "map.jpg")
    with pytest.raises(FileNotFoundError):
        t.plot(tmp_path / "no" / "map.svg")
    with pytest.raises(ValueError, match="bounds and style are for ax"):
        t.plot(colors="red")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["map.png", "map.svg"]


def test_axes_get_the_triangles(survey):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, ax = pyplot.subplots()
    assert survey.plot(ax=ax, linewidths=0.2) is ax
    rings = [path for lines in ax.collections for path in lines.get_paths()]
    about = survey.metadata
    assert sum(len(path.vertices) == 4 for path in rings) == about.triangles
    # A constraint is drawn by the triangles on both of its sides.
    assert sum(len(path.vertices) == 2 for path in rings) <= 2 * about.constraint_edges
    survey.plot(ax=ax, bounds=(10, 10, 20, 20))
    assert ax.get_xlim() == ax.get_ylim() == (10, 20)
    pyplot.close(figure)


def test_frames_have_the_triangles_as_polygons(survey):
    frame = survey.to_geopandas()
    about = survey.metadata
    assert len(frame) == about.triangles and frame.crs == "EPSG:25832" and frame.geometry.has_z.all()
    assert frame["hole"].sum() == about.hole_triangles
    assert frame.area.sum() == pytest.approx(survey.volume(0, holes=True).area)
    assert list(frame.columns) == ["tile", "triangle", "region", "hole", "geometry"]
    with pytest.raises(ValueError, match="kind must be"):
        survey.to_geopandas(kind="faces")


def test_meshes_have_each_vertex_once(survey, tmp_path):
    meshio = pytest.importorskip("meshio")
    mesh = survey.to_meshio()
    about = survey.metadata
    assert mesh.points.shape == (about.vertices, 3) and mesh.cells[0].data.shape == (about.triangles, 3)
    assert mesh.cell_data["hole"][0].sum() == about.hole_triangles
    mesh.write(tmp_path / "t.vtu")
    assert len(meshio.read(tmp_path / "t.vtu").cells[0].data) == about.triangles
    part = survey.to_meshio((10, 10, 20, 20))
    assert len(part.cells[0].data) == len(survey.to_geopandas((10, 10, 20, 20)))
    assert json.loads(json.dumps(part.points.shape)) == [len(part.points), 3]


def test_files_without_z_have_plane_geometry(run, tmp_path):
    dt.build(np.random.default_rng(0).random((50, 2)), tmp_path / "t.tiles")
    t = dt.open(tmp_path / "t.tiles")
    assert not t.to_geopandas().geometry.has_z.any() and t.to_meshio().points.shape == (50, 2)
    assert t.tile(0).z is None and t.crs is None and t.to_geopandas().crs is None
