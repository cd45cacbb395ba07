"""Builds over workers that share an object store alone, and the file in parts that they leave there."""

from __future__ import annotations

import json
import logging
import multiprocessing
import os
import signal
import subprocess
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from types import SimpleNamespace

import numpy as np
import pytest

import delaunay_tiles as dt

boto3 = pytest.importorskip("boto3")
server = pytest.importorskip("moto.server")

# 30,000 points take more than this, so there are ten blocks.
LITTLE = {"memory": "2MB", "threads": 2, "tile_vertices": 1000}


@pytest.fixture(scope="module")
def bucket():
    """A bucket of a local server, which this process and those that it starts find by their environment."""
    # It logs each request.
    logging.getLogger("werkzeug").setLevel(logging.ERROR)
    served = server.ThreadedMotoServer(port=0, verbose=False)
    served.start()
    host, port = served.get_host_and_port()
    settings = {
        "AWS_ENDPOINT": f"http://{host}:{port}",
        "AWS_ALLOW_HTTP": "true",
        "AWS_ACCESS_KEY_ID": "test",
        "AWS_SECRET_ACCESS_KEY": "test",
        "AWS_DEFAULT_REGION": "us-east-1",
    }
    with pytest.MonkeyPatch.context() as patch:
        for name, value in settings.items():
            patch.setenv(name, value)
        client = boto3.client("s3", endpoint_url=settings["AWS_ENDPOINT"])
        client.create_bucket(Bucket="maps")

        def keys(prefix: str) -> list[str]:
            return [entry["Key"] for entry in client.list_objects_v2(Bucket="maps", Prefix=prefix).get("Contents", [])]

        yield SimpleNamespace(keys=keys, client=client)
    served.stop()


@pytest.fixture(scope="module")
def inputs(tmp_path_factory):
    """Files of points with z, walls and sites in all blocks. The walls are so short that none is deferred."""
    folder = tmp_path_factory.mktemp("inputs")
    xy = np.random.default_rng(3).random((30_000, 2)) * 100
    np.savetxt(folder / "points.csv", np.column_stack([xy, xy.sum(axis=1)]), "%.17g", ",", header="x,y,z", comments="")
    rows = [f"{x + 0.5},{y + 0.25},{x + 1.5},{y + 0.5}" for x in range(0, 90, 10) for y in range(0, 100, 5)]
    (folder / "walls.csv").write_text("\n".join(rows))
    sites = [f"{x}.5,{y}.75,shop {x}/{y}" for x in range(0, 100, 9) for y in range(0, 100, 10)]
    (folder / "sites.csv").write_text("\n".join(["x,y,id", *sites]))
    return {what: folder / f"{what}.csv" for what in ("points", "walls", "sites")}


@pytest.fixture(scope="module")
def whole(inputs, tmp_path_factory):
    """A file that one process built in memory."""
    out = tmp_path_factory.mktemp("whole") / "whole.tiles"
    dt.build(**inputs, out=out, memory="1GB")
    return out


def assert_is(whole, url, summary, bucket, run):
    assert summary.blocks > 3 and summary.resumed_blocks == summary.blocks
    run("verify", "--deep", url)
    assert run("digest", "--recompute", url) == run("digest", "--recompute", whole)
    key = url.removeprefix("s3://maps/")
    manifest, *parts = sorted(bucket.keys(key))
    assert manifest == key
    assert len({part.rsplit("/", 1)[0] for part in parts}) == 1 and len(parts) == summary.blocks + 2, parts
    about = json.loads(run("inspect", "--json", url))
    assert about["vertices"] == summary.vertices
    xy = np.random.default_rng(5).random((50, 2)) * 100
    near, expected = dt.open(url).knn(xy, 2), dt.open(whole).knn(xy, 2)
    assert np.array_equal(near.distance, expected.distance) and np.array_equal(near.id, expected.id)


def test_processes_that_share_a_store_build_what_one_builds(bucket, inputs, whole, run, tmp_path):
    url = "s3://maps/by hand/town.tiles.parts"
    arguments = {**inputs, "out": url, "work_folder": tmp_path, **LITTLE}
    with ProcessPoolExecutor(2, multiprocessing.get_context("spawn")) as client:
        summary = dt.distributed.build(**arguments, client=client)
        assert_is(whole, url, summary, bucket, run)
        with pytest.raises(FileExistsError, match="overwrite=True"):
            dt.distributed.build(**arguments, client=client)
        before = bucket.keys("by hand/")
        summary = dt.distributed.build(**arguments, client=client, overwrite=True)
    assert_is(whole, url, summary, bucket, run)
    assert not set(before[1:]) & set(bucket.keys("by hand/"))
    assert os.listdir(tmp_path) == []


def test_on_dask_workers_that_are_killed_change_nothing(bucket, inputs, whole, run, tmp_path, worker_killed):
    dask = pytest.importorskip("dask.distributed")
    url = "s3://maps/dask/town.tiles.parts"
    with (
        dask.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
        dask.Client(cluster) as client,
    ):
        # Some tasks are done by then, and others are not.
        with worker_killed(client, lambda: any("/block-" in key for key in bucket.keys("dask/"))):
            summary = dt.distributed.build(**inputs, out=url, client=client, work_folder=tmp_path, **LITTLE)
    assert_is(whole, url, summary, bucket, run)


def command(inputs, url) -> list:
    """The command of the tool for a build as those above."""
    build = ["build", inputs["points"], "--walls", inputs["walls"], "--sites", inputs["sites"], "-o", url]
    return [*build, "--memory", "2MB", "--threads", "2", "--tile-vertices", "1000"]


def test_the_tool_does_the_same_without_python(bucket, inputs, whole, run, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    url = "s3://maps/tool/town.tiles.parts"
    build = command(inputs, url)
    listed = run(*build, "--tasks")
    count = len(json.loads(run("task", url, "--json"))["blocks"])
    assert count > 3 and f"{count} left: 0-{count - 1}" in listed and f"tiletool task {url} --block 0" in listed
    for block in range(count - 1):
        run("task", url, "--block", block, "--tmp", tmp_path, "--quiet")
    assert json.loads(run("task", url, "--block", "0", "--json"))["blocks"][0]["was_done"]
    for listed in (run("task", url), run(*build, "--tasks", "--resume")):
        assert f"1 left: {count - 1}" in listed
    run(*build, "--resume", "--quiet")
    assert os.listdir(tmp_path) == []
    assert run("digest", "--recompute", url) == run("digest", "--recompute", whole)
    path = ["query", "path", "--from", "3,3", "--to", "97,95"]
    assert run(*path, url) == run(*path, whole).replace(str(whole), url)
    run("compact", url, "-o", "one.tiles")
    assert run("digest", "--recompute", "one.tiles") == run("digest", "--recompute", whole)


def test_an_interrupted_task_leaves_no_files(bucket, inputs, run, tmp_path, tool):
    url = "s3://maps/interrupted/town.tiles.parts"
    run(*command(inputs, url), "--tasks")
    blocks = json.loads(run("task", url, "--json"))["blocks"]
    options = [word for block in range(len(blocks)) for word in ("--block", str(block))]
    task = subprocess.Popen([tool, "task", url, *options, "--tmp", tmp_path, "--quiet"], stderr=subprocess.PIPE)
    while not os.listdir(tmp_path):
        assert task.poll() is None
        time.sleep(0.001)
    task.send_signal(signal.SIGINT)
    _, said = task.communicate(timeout=60)
    assert task.returncode != 0 and b"is not conquered" in said
    assert os.listdir(tmp_path) == []
    blocks = json.loads(run("task", url, "--json"))["blocks"]
    assert not blocks[-1]["is_done"]


def test_a_build_without_workers_goes_into_a_store_too(bucket, tmp_path):
    url = "s3://maps/small.tiles.parts"
    # So many that the object is put in several requests.
    xy = np.random.default_rng(6).random((200_000, 2))
    summary = dt.build(xy, url, work_folder=tmp_path)
    dt.open(url).verify()
    assert dt.open(url).metadata.vertices == summary.vertices == 200_000
    assert len(bucket.keys("small.tiles.parts")) == 2
    assert os.listdir(tmp_path) == []
    with pytest.raises(OSError, match=r"its name ends with \.parts"):
        dt.build([(0, 0)], "s3://maps/small.tiles")


def test_files_in_parts_on_disk_are_not_copied_and_not_edited(inputs, whole, run, tmp_path):
    out = tmp_path / "town.tiles.parts"
    with ThreadPoolExecutor(2) as client:
        summary = dt.distributed.build(**inputs, out=out, client=client, **LITTLE)
    assert run("digest", "--recompute", out) == run("digest", "--recompute", whole)
    assert sorted(os.listdir(tmp_path)) == [out.name, out.name + ".d"]
    (folder,) = (tmp_path / (out.name + ".d")).iterdir()
    assert len(list(folder.iterdir())) == summary.blocks + 1
    with pytest.raises(dt.EditError, match="a file in parts is not edited"):
        dt.edit(out)
