"""Changes of points and lines: the file is the one that a build gives; mistakes change nothing."""

import numpy as np
import pytest

import delaunay_tiles as dt


@pytest.fixture
def field(tmp_path):
    rng = np.random.default_rng(7)
    points = np.column_stack([rng.random((3000, 2)), np.arange(3000.0)])
    path = tmp_path / "field.tiles"
    dt.build(points, path, tile_vertices=200)
    return path, points


def checked(path):
    """Returns the digest of a file, after it was proved to be right by itself."""
    with dt.open(path) as tiles:
        tiles.verify(deep=True)
        return tiles.digest()


def test_all_changes_at_once(field, tmp_path):
    path, points = field
    new = np.array([[2.0, 2.0, 1.0], [-1.0, 0.5, 2.0], [0.5, 0.5, 3.0]])
    with dt.edit(path) as changes:
        changes.insert(new)
        changes.delete(points[:1000])
        changes.move(points[1000:1010, :2], points[1000:1010, :2] + 5)
        changes.set_z(points[1010:1020] + [0, 0, 1])
    assert changes.summary.inserted == 3 and changes.summary.deleted == 1000
    assert changes.summary.moved == changes.summary.z_set == 10
    points[1000:1010, :2] += 5
    points[1010:1020, 2] += 1
    assert changes.summary.vertices == 2003
    dt.build(np.vstack([points[1000:], new]), tmp_path / "built.tiles")
    assert checked(path) == checked(tmp_path / "built.tiles")


def test_lines_come_and_go(field, tmp_path):
    path, points = field
    wall, other = [(0.1, 0.1), (0.9, 0.2)], [(0.1, 0.5), (0.9, 0.6)]
    square = [(0.2, 0.7), (0.8, 0.7), (0.8, 0.9), (0.2, 0.9), (0.2, 0.7)]
    plain = checked(path)
    with dt.edit(path, missing_z="zero") as changes:
        changes.constrain([wall, other], "walls")
        changes.constrain([square], "obstacles")
    assert changes.summary.segments == 6 and changes.summary.hole_regions == 1
    with dt.edit(path) as changes:
        changes.unconstrain([wall], "walls")
        changes.remove_lines([2])
    assert (changes.summary.removed_segments, changes.summary.removed_lines) == (1, 1)
    assert changes.summary.hole_regions == 0 and changes.summary.constraint_edges > 0
    with pytest.raises(dt.EditError, match=r"from \(0.1, 0.1\).*skip_missing=True"), dt.edit(path) as changes:
        changes.unconstrain([wall], "walls")
    with dt.edit(path, dry_run=True) as changes, pytest.raises(TypeError):
        changes.remove_lines(["1"])
    with dt.edit(path, skip_missing=True) as changes:
        changes.unconstrain([other, wall], "walls")
    assert (changes.summary.removed_segments, changes.summary.skipped) == (1, 1)
    assert checked(path) == plain
    with dt.edit(path, dry_run=True) as changes, pytest.raises(ValueError, match="ponds"):
        changes.constrain([square], "ponds")


def test_an_input_of_another_system_is_refused(tmp_path):
    geopandas = pytest.importorskip("geopandas")
    path = tmp_path / "survey.tiles"
    dt.build(np.random.default_rng(3).random((100, 2)), path, crs="EPSG:25832")
    sites = geopandas.GeoSeries.from_xy([0.5], [0.5], crs="EPSG:4326")
    with dt.edit(path, dry_run=True) as changes, pytest.raises(dt.InputError, match="4326"):
        changes.insert_sites(sites)
    with dt.edit(path, dry_run=True) as changes:
        changes.insert_sites(sites.set_crs("EPSG:25832", allow_override=True))
    assert changes.summary.inserted_sites == 1


def test_sites_come_and_go(field):
    path, points = field
    plain = checked(path)
    with dt.edit(path) as changes:
        changes.insert_sites([(0.25, 0.25), (0.75, 0.5)], ids=["north", "south"])
        changes.insert_sites(points[:2])
    assert changes.summary.inserted_sites == 4
    with dt.open(path) as tiles:
        assert tiles.metadata.sites == 4 and tiles.metadata.vertices == 3002
        assert tiles.nearest([(0.25, 0.25)], 1, "sites").id.tolist() == [["north"]]
    with pytest.raises(dt.EditError, match=r"no site at \(9, 9\)"), dt.edit(path) as changes:
        changes.delete_sites([(9.0, 9.0)])
    with dt.edit(path, skip_missing=True) as changes:
        changes.delete_sites([(0.25, 0.25), (0.75, 0.5), (9.0, 9.0)])
        changes.delete_sites(points[:2])
    assert (changes.summary.deleted_sites, changes.summary.skipped) == (4, 1)
    assert checked(path) == plain


def test_a_reader_keeps_what_it_opened(field):
    path, points = field
    with dt.open(path) as before:
        with dt.edit(path) as changes:
            changes.delete(points[:2000])
        assert before.metadata.vertices == 3000
        before.verify(deep=True)
    with dt.open(path) as after:
        assert after.metadata.vertices == 1000


@pytest.fixture
def plane(tmp_path):
    path = tmp_path / "plane.tiles"
    dt.build(np.random.default_rng(5).random((2000, 2)), path, tile_vertices=200)
    return path


def vertices(path):
    with dt.open(path) as tiles:
        return tiles.metadata.vertices


def test_edits_go_to_the_log_and_then_to_the_file(plane, tmp_path):
    new = np.random.default_rng(6).random((9, 2))
    before, log = plane.read_bytes(), plane.with_name("plane.tiles.log")
    with dt.Editor(plane, durability="log") as editor:
        for number, point in enumerate(new, 1):
            with dt.edit(editor) as changes:
                changes.insert([point])
            assert (changes.summary.inserted, changes.summary.pending_transactions) == (1, number)
        assert plane.read_bytes() == before and log.stat().st_size > 0
        assert editor.checkpoint().inserted == 9 and editor.checkpoint() is None
        assert vertices(plane) == 2009
        with dt.edit(editor) as changes:
            changes.delete(new[:3])
        assert vertices(plane) == 2009
    assert vertices(plane) == 2006
    dt.build(np.vstack([np.random.default_rng(5).random((2000, 2)), new[3:]]), tmp_path / "built.tiles")
    assert checked(plane) == checked(tmp_path / "built.tiles")


def test_finished_edits_of_the_log_outlive_an_exception(plane):
    with pytest.raises(KeyError), dt.Editor(plane, durability="log") as editor:
        with dt.edit(editor) as changes:
            changes.insert([(0.25, 0.25)])
        with dt.edit(editor) as changes:
            changes.insert([(0.5, 0.25)])
            raise KeyError("mine")
    assert vertices(plane) == 2000
    # The next editor makes what was finished.
    with dt.Editor(plane):
        assert vertices(plane) == 2001


def test_an_editor_makes_one_edit_at_a_time(plane):
    editor = dt.Editor(plane, memory="64MiB")
    with pytest.raises(dt.EditError, match="another editor"):
        dt.edit(plane)
    first = dt.edit(editor)
    for act in (lambda: dt.edit(editor), editor.checkpoint):
        with pytest.raises(dt.EditError, match="in progress"):
            act()
    first.close()
    with pytest.raises(TypeError, match="memory"):
        dt.edit(editor, memory="1MiB")
    with pytest.raises(ValueError, match="missing_z"):
        dt.edit(editor, missing_z="guess")
    second = dt.edit(editor)
    second.insert([(0.25, 0.25)])
    editor.close()
    # It has the file until it ends.
    with pytest.raises(dt.EditError, match="another editor"):
        dt.Editor(plane)
    assert second.finish().vertices == 2001
    with pytest.raises(RuntimeError, match="closed"):
        dt.edit(editor)
    with pytest.raises(ValueError, match="durability"):
        dt.Editor(plane, durability="ram")
    with dt.Editor(plane) as again:
        assert again.checkpoint() is None


def test_an_exception_in_the_block_changes_nothing(field):
    path, points = field
    before = path.read_bytes()
    with pytest.raises(KeyError), dt.edit(path) as changes:
        changes.delete(points[:10])
        raise KeyError("mine")
    assert changes.summary is None and path.read_bytes() == before
    # It is unlocked again.
    with dt.edit(path, dry_run=True) as changes:
        changes.delete(points[:10])
    assert changes.summary.vertices == 2990 and path.read_bytes() == before


def test_mistakes_are_named_and_change_nothing(field):
    path, points = field
    before = path.read_bytes()
    with pytest.raises(dt.EditError, match=r"no point at \(7, 8\).*skip_missing=True"), dt.edit(path) as changes:
        changes.delete([(7.0, 8.0)])
    with pytest.raises(dt.EditError, match="missing_z='zero'"), dt.edit(path) as changes:
        changes.insert([(7.0, 8.0)])
    with dt.edit(path) as first, pytest.raises(dt.EditError, match="another editor"):
        dt.edit(path)
    assert first.summary.deleted == 0
    with dt.edit(path, memory="1MiB") as changes, pytest.raises(dt.MemoryLimitError):
        changes.delete_sites(np.vstack([points] * 10)[:, :2])
    for wrong in ([(1.0,)], [(np.nan, 1.0)], "points.csv"):
        with dt.edit(path, dry_run=True) as changes, pytest.raises((ValueError, TypeError)):
            changes.insert(wrong)
    with dt.edit(path, dry_run=True) as changes, pytest.raises(ValueError, match="equally many"):
        changes.move(points[:2, :2], points[:1, :2])
    with pytest.raises(ValueError, match="missing_z"):
        dt.edit(path, missing_z="guess")
    with pytest.raises(FileNotFoundError):
        dt.edit(path.with_name("none.tiles"))
    assert path.read_bytes() == before
    with dt.edit(path, skip_missing=True, missing_z="zero") as changes:
        changes.delete([(7.0, 8.0)])
        changes.insert([(7.0, 8.0)])
    assert changes.summary.skipped == changes.summary.inserted == 1
