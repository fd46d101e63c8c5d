#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "common/core/random.h"

namespace cairn {

/// A room of a square lattice.
struct LatticeRoom {
  int x = 0, y = 0;
};

/// The room beside one, by direction 0: +x, 1: −x, 2: +y, 3: −y.
LatticeRoom Neighbor(LatticeRoom room, int direction);

/// Which walls of a square lattice of rooms stand: the plan of the paper's mazes. Line i of an axis lies below room i;
/// lines 0 and `size` are the border. All walls stand at first.
class LatticeMaze {
 public:
  explicit LatticeMaze(int size);

  /// Wall across `axis` (0: x, 1: y) on `line`, beside room number `along` of the other axis.
  char& wall(int axis, int line, int along) { return walls_[axis][static_cast<size_t>(line) * size_ + along]; }
  bool wall(int axis, int line, int along) const {
    return walls_[axis][static_cast<size_t>(line) * size_ + along] != 0;
  }
  int size() const { return size_; }

  bool Inside(LatticeRoom room) const { return room.x >= 0 && room.y >= 0 && room.x < size_ && room.y < size_; }
  /// Whether the wall towards the neighbour in `direction` is open.
  bool IsOpen(LatticeRoom room, int direction) const;
  void Open(LatticeRoom room, int direction);

  /// Opens walls by depth-first search with back-tracking from room (0, 0): a spanning tree.
  void CarvePerfect(RandomStream& random);
  /// Opens round(fraction · remaining) of the inner walls that still stand, each equally likely.
  void OpenLoops(double fraction, RandomStream& random);

 private:
  int size_;
  std::array<std::vector<char>, 2> walls_;
};

}  // namespace cairn
