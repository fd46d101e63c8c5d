#include "actors/mender.h"

#include <gtest/gtest.h>

#include <map>

#include "actors/persons.h"
#include "actors/rollout.h"
#include "common/roadmap/world_goal.h"
#include "tests/actors/test_scene.h"

namespace cairn::actors {
namespace {

PlannerConfig Config(bool kept) {
  PlannerConfig config;
  config.repair = PlannerConfig::Repair::kRays;
  config.repair_kept = kept;
  return config;
}

Findings Found(double x) { return {{Vector3d(x, 0, 0)}, {}}; }

TEST(MenderTest, MarksEndWithTheEpisodeUnlessTheyAreKept) {
  for (const bool kept : {false, true}) {
    Mender mender(Config(kept));
    mender.Begin(1);
    EXPECT_TRUE(mender.Report(Found(0.5), 0.1));
    EXPECT_FALSE(mender.Report(Found(0.5), 0.2));
    EXPECT_EQ(mender.marks(), (std::vector<float>{0.5f, 0, 0}));
    mender.Begin(2);
    EXPECT_TRUE(mender.marks().empty()) << "another world";
    mender.Begin(1);
    EXPECT_EQ(mender.marks().size(), kept ? 3u : 0u);
    EXPECT_EQ(mender.Report({}, 8.1), kept) << "eight seconds after it was seen, the mark goes";
  }
}

TEST(MenderTest, OnlyTheNewestMarksAreAskedWith) {
  Mender mender(Config(false));
  mender.Begin(1);
  for (int i = 0; i < 100; ++i) mender.Report(Found(0.1 * i), 0.01 * i);
  const std::vector<float> marks = mender.marks();
  EXPECT_EQ(marks.size(), 3 * WorldGoal::kMaxMarks);
  EXPECT_FLOAT_EQ(marks[marks.size() - 3], 9.9f);
}

TEST(MenderTest, ItsBytesGoOnWhereItWas) {
  Mender mender(Config(true));
  mender.Begin(1);
  mender.Report(Found(0.5), 3);
  mender.Begin(7);
  mender.Report(Found(0.2), 4);
  BlobWriter writer;
  mender.Write(writer);
  const std::string bytes = writer.Take();
  Mender other(Config(true));
  BlobReader reader(bytes);
  other.Read(reader);
  reader.Finish();
  EXPECT_EQ(other.marks(), mender.marks());
  for (const double elapsed : {8.0, 11.0, 12.1}) EXPECT_EQ(other.Report({}, elapsed), mender.Report({}, elapsed));
}

// A vehicle stands beside a corridor's way and looks at a person who walks to and fro along it for a quarter of an
// hour: no mark of where the person has been lasts 10 s longer, and where the person is there is one.
TEST(MenderTest, APersonWhoWalksThroughClosesNoCorridorForLong) {
  Experiment experiment = HallExperiment();
  WorldConfig& world = experiment.world;
  world.persons = 1;
  world.person_radius = 0.25 * experiment.vehicle.circumscribed_radius();
  world.person_speed = 0.5 * experiment.vehicle.length;
  world.persons_when = WorldConfig::BlockedWhen::kAlways;
  experiment.planner.repair = PlannerConfig::Repair::kRays;
  const double radius = 0.5 * experiment.vehicle.circumscribed_radius();
  experiment.planner.repair_margin = experiment.planner.repair_mark_radius = radius;
  Scene scene(experiment);
  scene.SetTable(MakeChain(scene.world().goal, {0.5f, 1.0f, 1.5f, 2.0f, 2.5f, 2.7f}, 0.5f, 0.05));
  Persons persons(scene);
  persons.Reset({0.5, 0.5, 0}, true, {1, RandomPurpose::kPersons});
  const SurpriseFinder finder(scene);
  Mender mender(experiment.planner);
  mender.Begin(1);
  const Motion motion{1.5, 0.7, 0, 0, 0, 0, 0, 0};
  constexpr double kStep = 0.1;
  std::map<std::pair<float, float>, double> occupied;  // when the person was last near a mark
  int steps_with_marks = 0;
  double longest = 0;
  for (double time = 0; time < 900; time += kStep) {
    persons.Walk(kStep, {motion.x, motion.y, 0});
    RangeFinder ranges(scene, &persons, {1, RandomPurpose::kRanges}, 0);
    Findings findings;
    finder.LookAround(motion, ranges, &findings);
    mender.Report(findings, time);
    const std::vector<float> marks = mender.marks();
    steps_with_marks += !marks.empty();
    for (size_t m = 0; m < marks.size(); m += 3) {
      const std::pair<float, float> place(marks[m], marks[m + 1]);
      const double gap = persons.Distance({marks[m], marks[m + 1], 0});
      if (gap < radius || !occupied.contains(place)) occupied[place] = time;
      longest = std::max(longest, time - occupied[place]);
    }
    std::erase_if(occupied, [&](const auto& known) {
      for (size_t m = 0; m < marks.size(); m += 3) {
        if (known.first == std::pair(marks[m], marks[m + 1])) return false;
      }
      return true;
    });
  }
  EXPECT_GT(steps_with_marks, 1000);
  EXPECT_GT(longest, 7);  // it was gone, and the mark not yet
  EXPECT_LT(longest, 10);
}

// A small maze in which two doors are shut, and nobody told the planner.
Experiment MakeExperiment() {
  Experiment experiment;
  experiment.world.cells = 5;
  experiment.world.random_blocked_doors = 2;
  experiment.planner.repair = PlannerConfig::Repair::kRays;
  experiment.environment.max_episode_steps = 60;
  return experiment;
}

// Its planner: a lattice without what comes near the marks. Each table comes when it has been asked for `delay` times.
class MazePlanner {
 public:
  MazePlanner(const Experiment& experiment, int delay)
      : experiment_(experiment), world_(MakeWorld(experiment.world)), field_(world_, 0.005), delay_(delay) {
    roadmap_ = testing::MakeGridRoadmap(world_, field_, 0.05, experiment.planner.radius);
  }

  std::shared_ptr<const RoadmapLookup> operator()(const WorldGoal& goal) {
    const size_t name = WorldGoalHash()(goal);
    if ((*asked_)[name]++ < delay_) return nullptr;
    Roadmap roadmap = roadmap_;
    const double reach = experiment_.planner.radius + experiment_.planner.repair_mark_radius;
    for (int v = 0; v < roadmap.num_vertices(); ++v) {
      for (int32_t e = roadmap.offsets[v]; e < roadmap.offsets[v + 1]; ++e) {
        const Vector3d middle = 0.5 * (roadmap.position(v) + roadmap.position(roadmap.neighbors[e]));
        for (size_t m = 0; m < goal.marks.size(); m += 3) {
          const Vector3d mark(goal.marks[m], goal.marks[m + 1], 0);
          if ((middle - mark).norm() < reach + 0.03) roadmap.lengths[e] = kUnreachable;
        }
      }
    }
    CostTable table = testing::MakeCostTable(roadmap, world_, goal.box());
    table.marks = goal.marks;
    table.mark_reach = static_cast<float>(reach);
    return std::make_shared<RoadmapLookup>(2, roadmap.positions, table, experiment_.planner.r_ball());
  }

 private:
  Experiment experiment_;
  World world_;
  DistanceField field_;
  Roadmap roadmap_;
  int delay_;
  std::shared_ptr<std::map<size_t, int>> asked_ = std::make_shared<std::map<size_t, int>>();
};

struct Made {
  std::vector<float> numbers;
  int cuts = 0;
};

// What one vehicle makes in a maze with two shut doors, driven by chance.
Made RollOut(int delay, const std::vector<int32_t>& vehicles) {
  const auto scene = std::make_shared<Scene>(MakeExperiment());
  scene->SetTable(MazePlanner(scene->experiment(), 0)({1, scene->goal()}));
  const MazePlanner planner(scene->experiment(), delay);
  Rollout rollout(std::make_shared<Course>(scene, planner));
  rollout.Assign(vehicles, std::vector<int32_t>(vehicles.size(), 0), std::vector<int64_t>(vehicles.size(), 0));
  for (bool complete = false; !complete;) {
    complete = true;
    std::vector<int> active;
    for (int i = 0; i < rollout.num_vehicles(); ++i) {
      if (rollout.transitions(i) >= 240) continue;
      complete = false;
      if (rollout.Ready(i)) active.push_back(i);
    }
    if (!active.empty()) rollout.Step(active, {nullptr, true, 1, 2});
  }
  Made made;
  for (const Segment& s : rollout.TakeSegments()) {
    if (s.vehicle != 1) continue;
    made.cuts += s.end == SegmentEnd::kCut;
    made.numbers.push_back(static_cast<float>(s.first_step));
    made.numbers.push_back(static_cast<float>(s.table_hash % 1000003));
    made.numbers.insert(made.numbers.end(), s.observations.begin(), s.observations.end());
    made.numbers.insert(made.numbers.end(), s.rewards.begin(), s.rewards.end());
  }
  return made;
}

TEST(MenderTest, ANewTableCutsTheSegmentWheneverItComes) {
  const Made at_once = RollOut(0, {0, 1});
  EXPECT_GT(at_once.cuts, 0) << "somebody should come upon a shut door";
  const Made late = RollOut(3, {1});
  EXPECT_EQ(at_once.numbers, late.numbers);
  EXPECT_EQ(at_once.cuts, late.cuts);
}

}  // namespace
}  // namespace cairn::actors
