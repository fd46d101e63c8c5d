#!/usr/bin/env python3
"""Plans on a large map_server map with planner.kind = GRID, as a person does, and measures it.
  large_grid.py BIN_DIR [--cells N, a side, default 4000] [--max-seconds S] [--max-mb M] [--noise SHARE]
The floor has rooms of 80 cells with doors of 20, and boxes of 4 x 4 cells in a share of places. Fails when the way is
shorter than straight or longer than any sensible one, or a limit is passed. Last line: "ok" or "FAILED: why"."""
import argparse
import json
import math
import os
import pathlib
import random
import sys
import tempfile
import time

ROOM, DOOR, WALL, BOX = 80, 20, 3, 4
CELL = 0.05  # [m]


def make_map(directory, cells, noise):
    rows = [bytearray(b"\xfe" * cells) for _ in range(cells)]
    doors = range((ROOM - DOOR) // 2, (ROOM + DOOR) // 2)
    for y, row in enumerate(rows):
        for x in range(cells) if y % ROOM < WALL else ():
            if x % ROOM not in doors:
                row[x] = 0
        if y % ROOM not in doors:
            for x in range(0, cells, ROOM):
                row[x:x + WALL] = bytes(min(WALL, cells - x))
        if y < WALL or y >= cells - WALL:
            row[:] = bytes(cells)
        row[:WALL] = row[-WALL:] = bytes(WALL)
    draw = random.Random(1)
    for _ in range(int(noise * cells * cells / BOX / BOX)):
        x, y = draw.randrange(ROOM, cells - ROOM), draw.randrange(ROOM, cells - ROOM)
        for row in rows[y:y + BOX]:
            row[x:x + BOX] = bytes(BOX)
    (directory / "floor.pgm").write_bytes(b"P5\n%d %d\n255\n" % (cells, cells) + b"".join(rows))
    (directory / "floor.yaml").write_text(
        f"image: floor.pgm\nresolution: {CELL}\norigin: [0, 0, 0]\nnegate: 0\n"
        "occupied_thresh: 0.65\nfree_thresh: 0.196\n")


def plan(binary, directory, start, goal):
    """The printed JSON, wall time [s] and largest resident set [MB]."""
    root = pathlib.Path(__file__).resolve().parents[2]
    out = directory / "out.json"
    arguments = [
        str(binary), "plan", str(root / "deploy/experiments/navigate.textproto"), "--map", str(directory / "floor.yaml"),
        "--robot", str(root / "deploy/robots/turtlebot3_burger.textproto"), "--goal", goal, "--start", start, "--json",
        "--set", "planner.kind=GRID"
    ]
    begin = time.monotonic()
    pid = os.posix_spawn(binary, arguments, os.environ,
                         file_actions=[(os.POSIX_SPAWN_OPEN, 1, str(out), os.O_WRONLY | os.O_CREAT, 0o600)])
    _, status, usage = os.wait4(pid, 0)
    seconds = time.monotonic() - begin
    if status != 0:
        fail(f"cairn plan ended with {os.waitstatus_to_exitcode(status)}")
    return json.loads(out.read_text()), seconds, usage.ru_maxrss / 1024


def fail(why):
    print(f"FAILED: {why}")
    sys.exit(1)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("bin_dir", type=pathlib.Path)
    parser.add_argument("--cells", type=int, default=4000)
    parser.add_argument("--noise", type=float, default=0.01)
    parser.add_argument("--max-seconds", type=float, default=math.inf)
    parser.add_argument("--max-mb", type=float, default=math.inf)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        directory = pathlib.Path(name)
        make_map(directory, options.cells, options.noise)
        near, far = 0.5 * ROOM * CELL, (options.cells - 0.5 * ROOM) * CELL
        far -= far % (ROOM * CELL) - near  # the middle of the last whole room
        start, goal = f"{near:.3f},{near:.3f}", f"{far:.3f},{far:.3f}"
        print(f"from {start} to {goal}", flush=True)
        result, seconds, megabytes = plan((options.bin_dir / "cairn").resolve(), directory, start, goal)
    straight = math.sqrt(2) * (far - near)
    print(f"{options.cells} x {options.cells} cells: {result['vertices']} vertices, {result['edges']} edges, path "
          f"{result['path_length']:.2f} m (straight {straight:.2f} m), {seconds:.2f} s, {megabytes:.0f} MB")
    if not straight - 1 <= result["path_length"] <= 1.2 * straight:
        fail("no sensible way")
    if seconds > options.max_seconds:
        fail(f"more than {options.max_seconds} s")
    if megabytes > options.max_mb:
        fail(f"more than {options.max_mb} MB")
    print("ok")


if __name__ == "__main__":
    main()
