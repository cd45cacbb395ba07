#!/usr/bin/env python3
"""Map tiles a second from `tiletool serve` beside martin on the same tiles, and the latency of uncached tiles.

    python3 -m pip install -r tools/lab/service/requirements.txt
    tools/lab/service/compare.py target/release/tiletool survey.tiles --martin martin

wrk must be installed. Without --martin, only the service is measured. README.md says what is measured.
"""

import argparse
import contextlib
import http.client
import json
import os
import random
import re
import signal
import socket
import statistics
import subprocess
import tempfile
import time
from pathlib import Path

from pmtiles.tile import Compression, TileType, zxy_to_tileid
from pmtiles.writer import Writer


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


@contextlib.contextmanager
def running(command, port, path):
    """Runs a server until the block ends, from the moment it answers."""
    server = subprocess.Popen([str(part) for part in command], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        until = time.monotonic() + 20
        while True:
            with contextlib.suppress(OSError):
                if get(http.client.HTTPConnection("127.0.0.1", port), path)[0] == 200:
                    break
            if time.monotonic() > until or server.poll() is not None:
                raise SystemExit(f"{command[0]} does not answer at {path}")
            time.sleep(0.1)
        yield server
    finally:
        server.send_signal(signal.SIGTERM)
        server.wait(20)


def get(connection, path, **headers):
    """Returns status, headers and body."""
    connection.request("GET", path, headers=headers)
    answer = connection.getresponse()
    return answer.status, answer.headers, answer.read()


def resident(process):
    """Returns the resident bytes of a process."""
    status = Path(f"/proc/{process.pid}/status").read_text()
    return int(re.search(r"VmRSS:\s+(\d+)", status)[1]) * 1024


def tiles_of(connection, base, zooms):
    """Returns the tiles of the zooms that are not empty, with their bytes."""
    level, found = [(zooms.start, x, y) for x in range(2**zooms.start) for y in range(2**zooms.start)], {}
    for _ in zooms:
        there = {}
        for z, x, y in level:
            status, _, body = get(connection, f"{base}/{z}/{x}/{y}.png")
            if status == 200 and body:
                there[z, x, y] = body
        found |= there
        level = [(z + 1, 2 * x + i, 2 * y + j) for z, x, y in there for i in (0, 1) for j in (0, 1)]
    return found


def write_pmtiles(path, tiles):
    """Writes the tiles to a PMTiles archive."""
    zooms = [z for z, _, _ in tiles]
    with path.open("wb") as file:
        writer = Writer(file)
        for tile in sorted(tiles, key=lambda tile: zxy_to_tileid(*tile)):
            writer.write_tile(zxy_to_tileid(*tile), tiles[tile])
        header = {"tile_type": TileType.PNG, "tile_compression": Compression.NONE, "min_zoom": min(zooms),
                  "max_zoom": max(zooms), "min_lon_e7": -1800000000, "min_lat_e7": -850000000,
                  "max_lon_e7": 1800000000, "max_lat_e7": 850000000, "center_zoom": 0, "center_lon_e7": 0,
                  "center_lat_e7": 0}
        writer.finalize(header, {})


LUA = """
local paths = {{}}
for line in io.lines("{list}") do paths[#paths + 1] = line end
local at = {seed}
request = function()
  at = (at * 1103515245 + 12345) % 2147483648
  return wrk.format("GET", paths[at % #paths + 1])
end
"""


def rate(port, script, seconds):
    """Returns the requests a second that wrk makes, and how many answers were no tiles."""
    command = ["wrk", "-t1", "-c32", f"-d{seconds}s", "-s", script, f"http://127.0.0.1:{port}"]
    printed = subprocess.run([str(part) for part in command], capture_output=True, text=True, check=True).stdout
    wrong = re.search(r"Non-2xx or 3xx responses: (\d+)", printed)
    return float(re.search(r"Requests/sec:\s+([\d.]+)", printed)[1]), int(wrong[1]) if wrong else 0


def script_for(folder, name, paths):
    (folder / f"{name}.txt").write_text("\n".join(paths))
    script = folder / f"{name}.lua"
    script.write_text(LUA.format(list=folder / f"{name}.txt", seed=1))
    return script


def cached(args, folder, serve, port, identifier):
    """Compares the rate of cached tiles."""
    connection = http.client.HTTPConnection("127.0.0.1", port)
    base = f"/{identifier}/native/shade"
    document = json.loads(get(connection, f"{base}.json")[2])
    first = document.get("minzoom", 0)
    tiles = tiles_of(connection, base, range(first, first + args.zooms))
    print(f"{len(tiles)} tiles, {statistics.mean(map(len, tiles.values())) / 1024:.1f} KiB each on average")
    ours = script_for(folder, "ours", [f"{base}/{z}/{x}/{y}.png" for z, x, y in tiles])
    rates = {"tiletool serve": [], "martin": []}
    with contextlib.ExitStack() as stack:
        if args.martin:
            archive, other = folder / "peer.pmtiles", free_port()
            write_pmtiles(archive, tiles)
            command = [args.martin, "--listen-addresses", f"127.0.0.1:{other}", archive]
            stack.enter_context(running(command, other, "/catalog"))
            theirs = script_for(folder, "theirs", [f"/peer/{z}/{x}/{y}" for z, x, y in tiles])
            rate(other, theirs, 2)
        for _ in range(args.rounds):
            measured = [("tiletool serve", port, ours)] + ([("martin", other, theirs)] if args.martin else [])
            for name, at, script in measured:
                per_second, wrong = rate(at, script, args.seconds)
                if wrong:
                    raise SystemExit(f"{name}: {wrong} answers are no tiles")
                rates[name].append(per_second)
    for name, all_of in rates.items():
        if all_of:
            spread = f"{min(all_of):.0f} to {max(all_of):.0f}"
            print(f"{name}: {statistics.median(all_of):.0f} cached tiles a second ({spread})")
    if args.martin:
        ratio = statistics.median(a / b for a, b in zip(*rates.values()))
        print(f"ratio in pairs: {ratio:.2f}")
    print(f"resident: {resident(serve) / 2**20:.0f} MiB")


def percentile(values, share):
    if not values:
        return 0.0
    return sorted(values)[min(len(values) - 1, int(share * len(values)))]


def uncached(args, port, identifier):
    """Measures random tiles that are in no cache of finished tiles, one at a time."""
    for layer, ending in [("shade", "png"), ("terrarium", "png"), ("mesh", "mvt")]:
        # The service ends connections on which nothing is asked.
        connection = http.client.HTTPConnection("127.0.0.1", port)
        base = f"/{identifier}/native/{layer}"
        status, _, body = get(connection, f"{base}.json")
        if status != 200:
            continue
        document, chance = json.loads(body), random.Random(1)
        latency, asked = [], []
        seen = set()
        for _ in range(50 * args.uncached):
            if len(latency) == args.uncached:
                break
            z = chance.randint(document.get("minzoom", 0), document["maxzoom"])
            tile = (z, chance.randrange(2**z), chance.randrange(2**z))
            if tile in seen:
                continue
            seen.add(tile)
            began = time.perf_counter()
            status, _, body = get(connection, f"{base}/{z}/{tile[1]}/{tile[2]}.{ending}")
            seconds = time.perf_counter() - began
            if status != 200 or not body:
                continue
            latency.append(1000 * seconds)
            asked.append(f"{layer} {z} {tile[1]} {tile[2]}")
        drawing = in_process(args, asked) if args.draw_times else []
        for share in (0.5, 0.99):
            served, drawn = percentile(latency, share), percentile(drawing, share)
            beside = f", in the process {drawn:.1f} ms: {served / drawn:.2f}" if drawing else ""
            print(f"{layer}: {len(latency)} uncached tiles, p{share * 100:.0f} {served:.1f} ms{beside}")


def in_process(args, asked):
    """Returns the milliseconds that a process takes to read, check and draw tiles, one at a time."""
    command = [args.draw_times, args.file]
    done = subprocess.run(command, input="\n".join(asked), capture_output=True, text=True, check=True)
    return [float(line.split()[0]) for line in done.stdout.splitlines()]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tiletool", type=Path)
    parser.add_argument("file", type=Path, help="a tile file with overviews")
    parser.add_argument("--martin", help="martin's program")
    parser.add_argument("--draw-times", type=Path, help="the example draw_times of tools/service")
    parser.add_argument("--zooms", type=int, default=6, help="how many zooms are compared (default: 6)")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--seconds", type=int, default=5, help="of each round (default: 5)")
    parser.add_argument("--uncached", type=int, default=2000, help="random tiles (default: 2000)")
    args = parser.parse_args()
    port, identifier = free_port(), args.file.stem
    command = [args.tiletool, "serve", args.file, "--listen", f"127.0.0.1:{port}"]
    with tempfile.TemporaryDirectory() as folder:
        with running(command, port, "/health"):
            uncached(args, port, identifier)
        with running(command, port, "/health") as serve:
            cached(args, Path(folder), serve, port, identifier)


if __name__ == "__main__":
    main()
