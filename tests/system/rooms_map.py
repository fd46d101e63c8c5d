#!/usr/bin/env python3
"""Makes the map of a floor with rooms, as map_server reads it: square rooms, doors of 0.9 m that join all of them and some
twice, boxes as furniture. The same seed gives the same floor.

    rooms_map.py PREFIX [--side 20] [--room 5] [--seed 1]

Writes PREFIX.yaml and PREFIX.pgm (5 cm a cell, origin at the lower left corner) and prints the middle of the room that is
farthest to the upper right, which stays empty, as X,Y: a goal."""

import argparse
import pathlib
import random

CELL = 0.05
WALL, DOOR = 3, 18  # [cells]
FREE, OCCUPIED = 254, 0


class Floor:
    def __init__(self, side, room, seed):
        self.random = random.Random(seed)
        self.count = max(1, round(side / room))
        self.room = round(room / CELL)
        self.size = self.count * self.room + WALL
        self.cells = [bytearray([FREE] * self.size) for _ in range(self.size)]

    def fill(self, x0, y0, x1, y1, value):
        for y in range(max(y0, 0), min(y1, self.size)):
            for x in range(max(x0, 0), min(x1, self.size)):
                self.cells[y][x] = value

    def walls(self):
        for i in range(self.count + 1):
            at = i * self.room
            self.fill(at, 0, at + WALL, self.size, OCCUPIED)
            self.fill(0, at, self.size, at + WALL, OCCUPIED)

    # A tree by depth-first search, then a third of the other walls get a door too.
    def doors(self):
        rooms = [(x, y) for y in range(self.count) for x in range(self.count)]
        seen, way, joined = {rooms[0]}, [rooms[0]], set()
        while way:
            x, y = way[-1]
            near = [(x + dx, y + dy) for dx, dy in [(1, 0), (-1, 0), (0, 1), (0, -1)]]
            fresh = [r for r in near if r in rooms and r not in seen]
            if not fresh:
                way.pop()
                continue
            room = self.random.choice(fresh)
            joined.add(tuple(sorted([way[-1], room])))
            seen.add(room)
            way.append(room)
        for x, y in rooms:
            for other in [(x + 1, y), (x, y + 1)]:
                if other in rooms and self.random.random() < 1 / 3:
                    joined.add(((x, y), other))
        for a, b in sorted(joined):
            self.door(a, b)

    def door(self, a, b):
        along = self.random.randrange(WALL + DOOR // 2, self.room - DOOR - DOOR // 2)
        x0, y0 = b[0] * self.room, b[1] * self.room
        if a[0] != b[0]:
            self.fill(x0, y0 + along, x0 + WALL, y0 + along + DOOR, FREE)
        else:
            self.fill(x0 + along, y0, x0 + along + DOOR, y0 + WALL, FREE)

    # Boxes of 0.3 to 1.2 m that keep 0.8 m from the walls, so that a way around them stays free.
    def furniture(self):
        margin = WALL + round(0.8 / CELL)
        for y in range(self.count):
            for x in range(self.count):
                if (x, y) == (self.count - 1, self.count - 1):
                    continue
                for _ in range(self.random.randrange(1, 4)):
                    w, h = (self.random.randrange(6, 25) for _ in range(2))
                    left = self.random.randrange(margin, max(margin + 1, self.room - margin - w))
                    low = self.random.randrange(margin, max(margin + 1, self.room - margin - h))
                    self.fill(x * self.room + left, y * self.room + low, x * self.room + left + w,
                              y * self.room + low + h, OCCUPIED)

    def write(self, prefix):
        header = f"P5\n{self.size} {self.size}\n255\n".encode()
        prefix.with_suffix(".pgm").write_bytes(header + b"".join(bytes(row) for row in reversed(self.cells)))
        prefix.with_suffix(".yaml").write_text(
            f"image: {prefix.name}.pgm\nresolution: {CELL}\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\n"
            "free_thresh: 0.196\n", encoding="utf-8")

    def goal(self):
        middle = ((self.count - 0.5) * self.room + WALL / 2) * CELL
        return f"{middle:.2f},{middle:.2f}"


def main():
    parser = argparse.ArgumentParser(description="Makes the map of a floor with rooms.")
    parser.add_argument("prefix", type=pathlib.Path)
    parser.add_argument("--side", type=float, default=20)
    parser.add_argument("--room", type=float, default=5)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    floor = Floor(options.side, options.room, options.seed)
    floor.walls()
    floor.doors()
    floor.furniture()
    floor.write(options.prefix)
    print(floor.goal())


if __name__ == "__main__":
    main()
