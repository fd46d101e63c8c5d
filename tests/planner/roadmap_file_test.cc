#include "planner/roadmap_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <functional>
#include <string>

#include "common/core/check.h"
#include "common/core/files.h"
#include "common/core/hash.h"
#include "planner/planner.h"
#include "tests/common/world/import/map_files.h"
#include "tests/planner/test_worlds.h"

namespace cairn::planner {
namespace {

using testing::HasSubstr;

// Two components: 0 – 1 – 2 and 3 – 4.
SavedRoadmap Small() {
  SavedRoadmap saved{PlannerConfig::Kind::kPrmStar, 0.03, 77, 1234, {}};
  saved.roadmap.dimension = 2;
  saved.roadmap.positions = {0, 0, 1, 0, 2, 0, 5, 5, 5, 6};
  saved.roadmap.offsets = {0, 1, 3, 4, 5, 6};
  saved.roadmap.neighbors = {1, 0, 2, 1, 4, 3};
  saved.roadmap.lengths = {1, 1, 1, 1, 1, 1};
  return saved;
}

std::string Error(const std::string& bytes) {
  return ErrorOf([&] { DecodeRoadmap(bytes, "a.roadmap"); });
}

void ExpectSame(const Roadmap& a, const Roadmap& b) {
  EXPECT_EQ(a.dimension, b.dimension);
  EXPECT_EQ(a.positions, b.positions);
  EXPECT_EQ(a.offsets, b.offsets);
  EXPECT_EQ(a.neighbors, b.neighbors);
  EXPECT_EQ(a.lengths, b.lengths);
}

TEST(RoadmapFileTest, ReadsBackWhatWasWritten) {
  const SavedRoadmap saved = Small();
  const SavedRoadmap read = DecodeRoadmap(EncodeRoadmap(saved), "a.roadmap");
  EXPECT_EQ(read.kind, saved.kind);
  EXPECT_EQ(read.radius, saved.radius);
  EXPECT_EQ(read.world_hash, saved.world_hash);
  EXPECT_EQ(read.samples, saved.samples);
  ExpectSame(read.roadmap, saved.roadmap);
}

TEST(RoadmapFileTest, EveryTruncationAndEveryFlippedBitIsRefused) {
  const std::string bytes = EncodeRoadmap(Small());
  EXPECT_EQ(Error(bytes), "");
  for (size_t length = 0; length < bytes.size(); ++length) {
    ASSERT_THAT(Error(bytes.substr(0, length)), HasSubstr("a.roadmap: torn: ")) << length;
  }
  for (size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
    std::string flipped = bytes;
    flipped[bit / 8] = static_cast<char>(flipped[bit / 8] ^ 1 << bit % 8);
    ASSERT_THAT(Error(flipped), HasSubstr("a.roadmap: ")) << bit;
  }
  EXPECT_THAT(Error(bytes + "x"), HasSubstr("damaged: 1 bytes after its end"));
  EXPECT_THAT(Error("type octile\n"), HasSubstr("not a roadmap; `cairn plan --save` writes one"));
}

// A sound frame around what is no graph.
TEST(RoadmapFileTest, WhatIsNoGraphIsRefusedThoughTheChecksumFits) {
  const auto error = [](const std::function<void(SavedRoadmap&)>& spoil) {
    SavedRoadmap saved = Small();
    spoil(saved);
    return Error(EncodeRoadmap(saved));
  };
  const auto graph = HasSubstr("damaged: its edges make no graph");
  EXPECT_THAT(error([](SavedRoadmap& s) { s.roadmap.neighbors[0] = 9; }), graph);
  EXPECT_THAT(error([](SavedRoadmap& s) { s.roadmap.neighbors[0] = -1; }), graph);
  EXPECT_THAT(error([](SavedRoadmap& s) { s.roadmap.neighbors[0] = 0; }), graph);  // itself
  EXPECT_THAT(error([](SavedRoadmap& s) { s.roadmap.neighbors[0] = 2; }), graph);  // no way back
  EXPECT_THAT(error([](SavedRoadmap& s) { s.roadmap.lengths[0] = 2; }), graph);    // longer there than back
  EXPECT_THAT(error([](SavedRoadmap& s) { s.roadmap.offsets[1] = 4; }), graph);
  EXPECT_THAT(error([](SavedRoadmap& s) { s.roadmap.offsets[5] = 5; }), graph);
  EXPECT_THAT(error([](SavedRoadmap& s) { std::swap(s.roadmap.neighbors[1], s.roadmap.neighbors[2]); }), graph);
  const auto number = HasSubstr("damaged: a coordinate or length that is none");
  EXPECT_THAT(error([](SavedRoadmap& s) { s.roadmap.positions[3] = NAN; }), number);
  EXPECT_THAT(error([](SavedRoadmap& s) { s.roadmap.lengths[3] = s.roadmap.lengths[2] = -1; }), number);
  EXPECT_THAT(error([](SavedRoadmap& s) { s.roadmap.neighbors.pop_back(); }), HasSubstr("damaged: "));
  EXPECT_THAT(error([](SavedRoadmap& s) { s.radius = 0; }), HasSubstr("damaged: no roadmap's numbers"));
  EXPECT_THAT(error([](SavedRoadmap& s) { s.kind = static_cast<PlannerConfig::Kind>(5); }), HasSubstr("no kind"));
}

TEST(RoadmapFileTest, TheHashTellsWorldsApartButNotTheirGoals) {
  World world = TwoRooms(2);
  const uint64_t hash = HashOf(world);
  world.goal.min.x() = 1.6;
  EXPECT_EQ(HashOf(world), hash);
  world.cylinders[0].radius = 0.11;
  EXPECT_NE(HashOf(world), hash);
  world = TwoRooms(2);
  world.boxes.pop_back();
  EXPECT_NE(HashOf(world), hash);
}

class RoadmapFromFileTest : public testing::Test {
 protected:
  void Save(const World& world) {
    const DistanceField field(world, 0.01);
    built_ = BuildRoadmap(world, field, config_, 0.025);
    config_.roadmap = directory_.Write("a.roadmap", SaveRoadmap(world, config_, built_));
  }
  std::string BuildError(const World& world) {
    const DistanceField field(world, 0.01);
    return ErrorOf([&] { BuildRoadmap(world, field, config_, 0.025); });
  }

  MapDirectory directory_;
  PlannerConfig config_;
  BuiltRoadmap built_;
};

TEST_F(RoadmapFromFileTest, IsTheRoadmapThatWasBuiltWhateverTheConfigSays) {
  World world = TwoRooms(2);
  world.boxes = {{Vector3d(1, 0, 0), Vector3d(1.05, 1, 0)}};  // two components: the goal reaches into both rooms
  world.goal = {Vector3d(0.9, 0.1, 0), Vector3d(1.2, 0.9, 0)};
  Save(world);
  EXPECT_EQ(built_.info.components, 2);
  config_.kind = PlannerConfig::Kind::kGrid;
  config_.seed = 9;
  const DistanceField field(world, 0.01);
  const BuiltRoadmap read = BuildRoadmap(world, field, config_, 0.025);
  ExpectSame(read.roadmap, built_.roadmap);
  EXPECT_EQ(read.info.components, 2);
  EXPECT_EQ(read.info.kind, PlannerConfig::Kind::kRrg);
  EXPECT_EQ(read.info.samples, built_.info.samples);
  EXPECT_GE(read.info.coverage, 0.998);  // other samples
}

TEST_F(RoadmapFromFileTest, ServesOtherGoalsOfItsWorld) {
  World world = TwoRooms(2);
  Save(world);
  world.goal = {Vector3d(0.1, 0.7, 0), Vector3d(0.3, 0.9, 0)};
  EXPECT_EQ(BuildError(world), "");
}

TEST_F(RoadmapFromFileTest, AnotherWorldRadiusOrTooLittleCoverageIsRefused) {
  World world = TwoRooms(2);
  Save(world);
  config_.radius = 0.02;
  EXPECT_THAT(BuildError(world), HasSubstr("it is for planner.radius = 0.03 m, not 0.02 m"));
  config_.radius = 0.03;
  config_.eta = 0.03;
  config_.min_spacing = 0.01;
  EXPECT_THAT(BuildError(world), testing::AllOf(HasSubstr("a.roadmap: it covers 0."), HasSubstr("eta / 2 = 0.015 m")));
  config_.eta = 0.1;
  world.boxes.pop_back();
  EXPECT_THAT(BuildError(world), HasSubstr("a.roadmap: it is of another world"));
}

TEST_F(RoadmapFromFileTest, APathNeedNotCover) {
  config_.kind = PlannerConfig::Kind::kRrt;
  Save(TwoRooms(2));
  EXPECT_EQ(BuildError(TwoRooms(2)), "");
}

}  // namespace
}  // namespace cairn::planner
