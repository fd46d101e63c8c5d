#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <utility>

#include "common/core/check.h"
#include "common/world/world.h"

namespace cairn {
namespace {

constexpr double kPitch = 0.16, kWall = 0.02;

WorldConfig Config(uint64_t seed, double loops, double square = 0.16) {
  WorldConfig config;
  config.seed = seed;
  config.loop_fraction = loops;
  config.square = square;
  return config;
}

bool Occupied(const World& world, double x, double y) {
  for (const Box& box : world.boxes) {
    if (x > box.min.x() && x < box.max.x() && y > box.min.y() && y < box.max.y()) return true;
  }
  return false;
}

double Center(int cell) { return cell * kPitch + kWall + 0.07; }

// Open passages between neighbouring cells, read from the boxes alone.
struct Passages {
  int open = 0;
  int reached = 0;  // cells reached from cell (0, 0)
};

Passages Count(const World& world, int n) {
  const auto open = [&](int x, int y, int dx, int dy) {
    return !Occupied(world, Center(x) + dx * kPitch / 2, Center(y) + dy * kPitch / 2);
  };
  Passages passages;
  for (int y = 0; y < n; ++y) {
    for (int x = 0; x < n; ++x) {
      passages.open += (x + 1 < n && open(x, y, 1, 0)) + (y + 1 < n && open(x, y, 0, 1));
    }
  }
  std::set<std::pair<int, int>> seen{{0, 0}};
  std::vector<std::pair<int, int>> stack{{0, 0}};
  while (!stack.empty()) {
    const auto [x, y] = stack.back();
    stack.pop_back();
    for (const auto& [dx, dy] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
      if (open(x, y, dx, dy) && seen.insert({x + dx, y + dy}).second) stack.push_back({x + dx, y + dy});
    }
  }
  passages.reached = static_cast<int>(seen.size());
  return passages;
}

TEST(MazeTest, IsPerfectBeforeLoops) {
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    const Passages passages = Count(MakeCarMaze(Config(seed, 0)), 12);
    EXPECT_EQ(passages.open, 143) << seed;  // a spanning tree …
    EXPECT_EQ(passages.reached, 144) << seed;
  }
}

TEST(MazeTest, LoopFractionOpensThatShareOfTheWallsLeft) {
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    const Passages passages = Count(MakeCarMaze(Config(seed, 0.15)), 12);
    EXPECT_EQ(passages.open, 143 + 18) << seed;  // 264 − 143 = 121 inner walls are left, 15 % are 18
    EXPECT_EQ(passages.reached, 144) << seed;
  }
}

TEST(MazeTest, FullLoopFractionLeavesOnlyTheFrame) { EXPECT_EQ(MakeCarMaze(Config(1, 1)).boxes.size(), 4u); }

TEST(MazeTest, PaperMazeHasThePapersMeasures) {
  const World world = MakeCarMaze(WorldConfig{});
  EXPECT_NEAR(world.bounds.max.x(), 1.94, 1e-12);
  EXPECT_NEAR(world.bounds.max.y(), 1.94, 1e-12);
  EXPECT_NEAR(world.start.size().x(), 0.32, 1e-12);
  EXPECT_NEAR(world.goal.size().y(), 0.32, 1e-12);
  EXPECT_NEAR(world.start.min.x(), 0.01, 1e-12);
  EXPECT_NEAR(world.goal.max.y(), 1.93, 1e-12);
  for (const Box& box : world.boxes) EXPECT_NEAR(std::min(box.size().x(), box.size().y()), kWall, 1e-12);
}

TEST(MazeTest, SquaresAreClearedInside) {
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    const World world = MakeCarMaze(Config(seed, 0.15, 0.32));
    for (double x = 0.025; x < 0.32; x += 0.01) {
      for (double y = 0.025; y < 0.32; y += 0.01) {
        EXPECT_FALSE(Occupied(world, x, y)) << seed << ": " << x << ", " << y;
        EXPECT_FALSE(Occupied(world, 1.94 - x, 1.94 - y)) << seed << ": " << x << ", " << y;
      }
    }
  }
}

TEST(MazeTest, WallRunsAreMerged) {
  const World world = MakeCarMaze(WorldConfig{});
  for (const Box& a : world.boxes) {
    for (const Box& b : world.boxes) {
      for (int axis = 0; axis < 2; ++axis) {
        // Two boxes of one line would overlap at a post end to end.
        const bool same_line = &a != &b && a.min[axis] == b.min[axis] && a.max[axis] == b.max[axis];
        EXPECT_FALSE(same_line && std::abs(a.max[1 - axis] - kWall - b.min[1 - axis]) < 1e-9);
      }
    }
  }
}

TEST(MazeTest, SameSeedGivesTheSameBoxesAndAnotherSeedOthers) {
  const World a = MakeCarMaze(Config(7, 0.15)), b = MakeCarMaze(Config(7, 0.15)), c = MakeCarMaze(Config(8, 0.15));
  const auto same = [](const World& u, const World& v) {
    if (u.boxes.size() != v.boxes.size()) return false;
    for (size_t i = 0; i < u.boxes.size(); ++i) {
      if (u.boxes[i].min != v.boxes[i].min || u.boxes[i].max != v.boxes[i].max) return false;
    }
    return true;
  };
  EXPECT_TRUE(same(a, b));
  EXPECT_FALSE(same(a, c));
}

TEST(MazeTest, RejectsSquaresThatOverlap) {
  WorldConfig config;
  config.square = 0.97;
  try {
    MakeCarMaze(config);
    FAIL();
  } catch (const UsageError& error) {
    EXPECT_NE(std::string(error.what()).find("world.square = 0.97"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("0.96"), std::string::npos) << error.what();
  }
  config.square = 0.96;
  EXPECT_NO_THROW(MakeCarMaze(config));
}

}  // namespace
}  // namespace cairn
