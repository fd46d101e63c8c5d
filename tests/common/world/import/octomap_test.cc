#include "common/world/import/octomap.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <octomap/OcTree.h>

#include <sstream>

#include "common/core/random.h"
#include "tests/common/world/import/map_files.h"

namespace cairn {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr int64_t kMax = 10000000;
constexpr const char* kHeader = "# Octomap OcTree binary file\n# comment\nid OcTree\nsize 9\nres 0.05\ndata\n";

// What octomap itself writes.
std::string WriteBinary(octomap::OcTree* tree) {
  std::ostringstream stream;
  tree->writeBinary(stream);
  return stream.str();
}

// Free and occupied voxels of 0.1 m at random within a metre, and a large free block that is pruned.
octomap::OcTree MakeTree() {
  octomap::OcTree tree(0.1);
  RandomStream random(3, RandomPurpose::kTest);
  for (int i = 0; i < 400; ++i) {
    const octomap::point3d p(static_cast<float>(random.Uniform(-1, 1)), static_cast<float>(random.Uniform(-1, 1)),
                             static_cast<float>(random.Uniform(-0.5, 0.5)));
    tree.updateNode(p, random.Below(3) == 0);
  }
  for (int x = 0; x < 8; ++x) {
    for (int y = 0; y < 8; ++y) {
      for (int z = 0; z < 8; ++z) tree.updateNode(octomap::OcTreeKey(32768 + x, 32768 + y, 32768 + z), false);
    }
  }
  return tree;
}

Cell TruthAt(const octomap::OcTree& tree, const octomap::OcTreeKey& key) {
  const octomap::OcTreeNode* node = tree.search(key);
  if (node == nullptr) return Cell::kUnknown;
  return tree.isNodeOccupied(node) ? Cell::kOccupied : Cell::kFree;
}

octomap::OcTreeKey KeyAt(double x, double y, double z) {
  const auto key = [](double v) {
    return static_cast<octomap::key_type>(static_cast<int>(std::floor(v / 0.1 + 0.5)) + 32768);
  };
  return {key(x - 0.05), key(y - 0.05), key(z - 0.05)};
}

// Against octomap's own tree, voxel by voxel.
TEST(OctomapTest, AgreesWithTheLibraryInSpace) {
  octomap::OcTree tree = MakeTree();
  const CellGrid grid = ReadOctomap(WriteBinary(&tree), "a.bt", std::nullopt, kMax);
  ASSERT_EQ(grid.dimension, 3);
  EXPECT_DOUBLE_EQ(grid.cell, 0.1);
  int counts[3] = {0, 0, 0};
  for (int z = 0; z < grid.size.z(); ++z) {
    for (int y = 0; y < grid.size.y(); ++y) {
      for (int x = 0; x < grid.size.x(); ++x) {
        const Vector3d p = grid.origin + grid.cell * Vector3d(x + 0.5, y + 0.5, z + 0.5);
        const Cell cell = grid.cells[grid.Index(x, y, z)];
        ASSERT_EQ(cell, TruthAt(tree, KeyAt(p.x(), p.y(), p.z()))) << p.transpose();
        ++counts[static_cast<int>(cell)];
      }
    }
  }
  EXPECT_GT(counts[0], 512);
  EXPECT_GT(counts[1], 100);
  EXPECT_GT(counts[2], 50);
}

TEST(OctomapTest, ASliceIsProjectedAsOctomapServerDoes) {
  octomap::OcTree tree = MakeTree();
  const CellGrid grid = ReadOctomap(WriteBinary(&tree), "a.bt", Slice{-0.2, 0.15}, kMax);
  ASSERT_EQ(grid.dimension, 2);
  for (int y = 0; y < grid.size.y(); ++y) {
    for (int x = 0; x < grid.size.x(); ++x) {
      const Vector3d p = grid.origin + grid.cell * Vector3d(x + 0.5, y + 0.5, 0);
      bool any_free = false, any_occupied = false;
      for (const double z : {-0.15, -0.05, 0.05, 0.15}) {  // the voxels that [−0.2, 0.15] touches
        const Cell cell = TruthAt(tree, KeyAt(p.x(), p.y(), z));
        any_free |= cell == Cell::kFree;
        any_occupied |= cell == Cell::kOccupied;
      }
      const Cell truth = any_occupied ? Cell::kOccupied : any_free ? Cell::kFree : Cell::kUnknown;
      ASSERT_EQ(grid.cells[grid.Index(x, y)], truth) << p.transpose();
    }
  }
}

// By hand: fifteen nodes whose first child alone has children (11), then one whose child 0 is free (01) and whose child
// 1, beside it in x, is occupied (10).
TEST(OctomapTest, ReadsTwoBitsAChild) {
  std::string bytes = kHeader;
  for (int level = 0; level < 15; ++level) bytes += std::string("\x03\x00", 2);
  bytes += std::string("\x09\x00", 2);
  const CellGrid grid = ReadOctomap(bytes, "a.bt", Slice{-1638.4, -1638.35}, kMax);
  EXPECT_THAT(Rows(grid), ElementsAre("??", ".#"));  // cut off by the end of the tree on the left and below
  EXPECT_EQ(grid.origin, Vector3d(-0.05 * 32768, -0.05 * 32768, 0));
}

// What a scan without ray casting leaves: it says where walls are and nothing of what is between them.
TEST(OctomapTest, ATreeOfOccupiedVoxelsEndsAtItsLeavesWhenUnknownIsFree) {
  octomap::OcTree tree(0.1);
  for (const auto& [x, y] : {std::pair(0, 0), std::pair(4, 2)}) {
    tree.updateNode(octomap::OcTreeKey(32768 + x, 32768 + y, 32768), true);
  }
  const std::string bytes = WriteBinary(&tree);
  EXPECT_THAT(ErrorOf([&] {
                ReadOctomap(bytes, "a.bt", Slice{0, 0.1}, kMax);
              }),
              HasSubstr("no voxel of the slice is free"));
  EXPECT_THAT(Rows(ReadOctomap(bytes, "a.bt", Slice{0, 0.1}, kMax, true)), ElementsAre("????#", "?????", "#????"));
  EXPECT_EQ(ReadOctomap(bytes, "a.bt", std::nullopt, kMax, true).size, Eigen::Vector3i(5, 3, 1));
  EXPECT_THAT(ErrorOf([&] {
                ReadOctomap(bytes, "a.bt", Slice{1, 1.1}, kMax, true);
              }),
              HasSubstr("no voxel of the slice is known"));
}

TEST(OctomapErrorTest, TornTreesAreRefusedAtEveryLength) {
  octomap::OcTree tree = MakeTree();
  const std::string bytes = WriteBinary(&tree);
  for (size_t length = 0; length < bytes.size(); ++length) {
    EXPECT_THAT(ErrorOf([&] { ReadOctomap(bytes.substr(0, length), "a.bt", std::nullopt, kMax); }), HasSubstr("a.bt"))
        << length;
  }
}

TEST(OctomapErrorTest, NamesWhatIsWrong) {
  const auto error = [](const std::string& bytes) {
    return ErrorOf([&] { ReadOctomap(bytes, "a.bt", std::nullopt, kMax); });
  };
  EXPECT_THAT(error("# Octomap OcTree file\nid OcTree\n"), HasSubstr("not an OctoMap binary tree (.bt)"));
  EXPECT_THAT(error("# Octomap OcTree binary file\nid ColorOcTree\nsize 1\nres 0.1\ndata\n"),
              HasSubstr("id = \"ColorOcTree\""));
  EXPECT_THAT(error("# Octomap OcTree binary file\nid OcTree\nsize 1\nres -1\ndata\n"),
              HasSubstr("res = -1 m a voxel"));
  EXPECT_THAT(error("# Octomap OcTree binary file\nid OcTree\nsize 1\nres abc\ndata\n"),
              HasSubstr("a.bt:4: res is not a number"));
  // One free leaf of 2^15 voxels a side is more than a grid may hold.
  EXPECT_THAT(error(std::string(kHeader) + std::string("\x01\x00", 2)), HasSubstr("cells"));
  // A tree that goes on and on.
  EXPECT_THAT(error(std::string(kHeader) + std::string(200, '\x03')), HasSubstr("deeper than 16 levels"));
  EXPECT_THAT(error(std::string(kHeader) + std::string("\x02\x00", 2)), HasSubstr("no voxel is free"));
}

}  // namespace
}  // namespace cairn
