#include "common/world/lattice_maze.h"

#include <cmath>
#include <utility>

namespace cairn {

LatticeRoom Neighbor(LatticeRoom room, int direction) {
  const int step = direction % 2 == 0 ? 1 : -1;
  return direction < 2 ? LatticeRoom{room.x + step, room.y} : LatticeRoom{room.x, room.y + step};
}

LatticeMaze::LatticeMaze(int size) : size_(size) {
  for (auto& axis : walls_) axis.assign(static_cast<size_t>(size + 1) * size, 1);
}

bool LatticeMaze::IsOpen(LatticeRoom room, int direction) const {
  const int line = (direction < 2 ? room.x : room.y) + (direction % 2 == 0 ? 1 : 0);
  return !wall(direction / 2, line, direction < 2 ? room.y : room.x);
}

void LatticeMaze::Open(LatticeRoom room, int direction) {
  const int line = (direction < 2 ? room.x : room.y) + (direction % 2 == 0 ? 1 : 0);
  wall(direction / 2, line, direction < 2 ? room.y : room.x) = 0;
}

void LatticeMaze::CarvePerfect(RandomStream& random) {
  std::vector<char> visited(static_cast<size_t>(size_) * size_, 0);
  const auto at = [&](LatticeRoom r) -> char& { return visited[static_cast<size_t>(r.y) * size_ + r.x]; };
  std::vector<LatticeRoom> stack{{0, 0}};
  at({0, 0}) = 1;
  while (!stack.empty()) {
    int choices[4], count = 0;
    for (int direction = 0; direction < 4; ++direction) {
      const LatticeRoom r = Neighbor(stack.back(), direction);
      if (Inside(r) && !at(r)) choices[count++] = direction;
    }
    if (count == 0) {
      stack.pop_back();
      continue;
    }
    const int direction = choices[random.Below(static_cast<uint32_t>(count))];
    Open(stack.back(), direction);
    stack.push_back(Neighbor(stack.back(), direction));
    at(stack.back()) = 1;
  }
}

void LatticeMaze::OpenLoops(double fraction, RandomStream& random) {
  std::vector<char*> standing;
  for (int axis = 0; axis < 2; ++axis) {
    for (int line = 1; line < size_; ++line) {
      for (int along = 0; along < size_; ++along) {
        char& w = wall(axis, line, along);
        if (w) standing.push_back(&w);
      }
    }
  }
  const auto count = static_cast<size_t>(std::lround(fraction * static_cast<double>(standing.size())));
  for (size_t i = 0; i < count; ++i) {  // partial Fisher-Yates
    const auto rest = static_cast<uint32_t>(standing.size() - i);
    std::swap(standing[i], standing[i + random.Below(rest)]);
    *standing[i] = 0;
  }
}

}  // namespace cairn
