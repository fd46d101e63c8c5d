#include "deploy/robot/pilot.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "actors/command.h"
#include "actors/controllers/policy_controller.h"
#include "common/core/check.h"
#include "common/core/random.h"
#include "deploy/robot/stand_in.h"
#include "tests/actors/test_scene.h"

namespace cairn::deploy {
namespace {

using ::testing::HasSubstr;

constexpr int64_t kPeriodUs = 100000;

PolicyFile RandomPolicy(const Experiment& experiment) {
  PolicyFile file;
  file.shape = {
      PolicyShape::Head::kGaussian, ObservationSize(experiment), experiment.vehicle.action_size(), {16, 16}, false};
  RandomStream random(1, RandomPurpose::kTest);
  for (size_t i = 0; i < file.shape.num_parameters(); ++i)
    file.parameters.push_back(static_cast<float>(0.3 * random.Normal()));
  return file;
}

struct Case {
  const char* name;
  void (*change)(Experiment*);
  friend void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }
};

const Case kCases[] = {
    {"Car", [](Experiment*) {}},
    {"PartOfTheCircle",
     [](Experiment* e) {
       e->vehicle.scan = {9, 3, 2, 0.01};
     }},
    {"LastActions", [](Experiment* e) { e->observation.last_actions = 2; }},
    {"NoisyRanges",
     [](Experiment* e) {
       e->observation.range_noise = 0.005;
       e->observation.range_dropout = 0.1;
     }},
    {"NoisyPose",
     [](Experiment* e) {
       e->observation.pose_noise = 0.003;
       e->observation.heading_noise = 0.05;
     }},
    {"Holonomic", [](Experiment* e) { e->vehicle.kind = VehicleConfig::Kind::kHolonomic; }},
    {"Ackermann", [](Experiment* e) { e->vehicle.kind = VehicleConfig::Kind::kAckermann; }},
};

class PilotCaseTest : public ::testing::TestWithParam<Case> {};

// What a simulated vehicle measures makes the pilot command what the policy commands in simulation, all along episodes.
TEST_P(PilotCaseTest, CommandsWhatThePolicyDoesInSimulation) {
  Experiment experiment = actors::HallExperiment();
  GetParam().change(&experiment);
  experiment = Pilot::ForPilot(experiment);
  const auto scene = actors::MakeScene(experiment);
  const PolicyFile file = RandomPolicy(experiment);
  Policy policy(file.shape, 1);
  policy.SetParameters(file.parameters);
  actors::PolicyController controller(policy, 1);
  actors::Environment environment(*scene);
  const actors::Environment* batch[] = {&environment};
  int compared = 0;
  for (int start = 0; start < 100 && compared < 80; ++start) {
    Pilot pilot(scene, file);
    environment.ResetEvaluation(StartSet::kTest, start, 0);
    for (int step = 1; step < 60 && environment.episode().outcome == Outcome::kRunning; ++step, ++compared) {
      std::array<float, kMaxActionSize> action{};
      controller.Act(batch, action.data());
      const actors::VehicleCommand expected = actors::ToCommand(experiment.vehicle, action.data());
      // A noisy range or pose is sent as the vehicle has it now, so that both see the same.
      const RobotCommand command = pilot.Act(Measure(environment, DenseScan(experiment), step * kPeriodUs));
      ASSERT_EQ(command.mode, RobotCommand::Mode::kDrive) << command.note;
      EXPECT_EQ(command.state_utime, step * kPeriodUs);
      EXPECT_DOUBLE_EQ(command.valid, 0.3);
      ASSERT_EQ(command.command.size(), static_cast<size_t>(experiment.vehicle.action_size()));
      for (size_t i = 0; i < command.command.size(); ++i) ASSERT_NEAR(command.command[i], expected[i], 1e-4) << step;
      environment.Step(action.data());
    }
  }
  EXPECT_GT(compared, 40);
}

INSTANTIATE_TEST_SUITE_P(Vehicles, PilotCaseTest, ::testing::ValuesIn(kCases),
                         [](const auto& p) { return std::string(p.param.name); });

// Collisions of episodes that a random policy drives by way of the pilot, and whether its filter had to do something.
int Collisions(Experiment experiment, bool* filtered) {
  experiment = Pilot::ForPilot(experiment);
  const ScanConfig scan = DenseScan(experiment);
  const PolicyFile file = RandomPolicy(experiment);
  const auto scene = actors::MakeScene(experiment);
  experiment.safety.filter = SafetyConfig::Filter::kOff;  // the vehicle has none of its own
  actors::Environment environment(*actors::MakeScene(experiment));
  int collisions = 0;
  for (int start = 0; start < 25; ++start) {
    Pilot pilot(scene, file);
    environment.ResetEvaluation(StartSet::kTest, start, 0);
    for (int step = 1; step < 60 && environment.episode().outcome == Outcome::kRunning; ++step) {
      const RobotCommand command = pilot.Act(Measure(environment, scan, step * kPeriodUs));
      EXPECT_NE(command.mode, RobotCommand::Mode::kStop) << command.note;
      actors::VehicleCommand told{};
      std::copy(command.command.begin(), command.command.end(), told.begin());
      std::array<float, kMaxActionSize> action{};
      actors::ToAction(experiment.vehicle, told, action.data());
      environment.Step(action.data());
    }
    collisions += environment.episode().outcome == Outcome::kCollision ? 1 : 0;
    *filtered = *filtered || pilot.filtered() > 0;
  }
  return collisions;
}

const Case kFilteredCases[] = {
    {"PlaneCar", [](Experiment*) {}},
    {"WheeledCar", [](Experiment* e) { e->vehicle.kind = VehicleConfig::Kind::kWheeledCar; }},
    {"Holonomic", [](Experiment* e) { e->vehicle.kind = VehicleConfig::Kind::kHolonomic; }},
    {"SensorAhead", [](Experiment* e) { e->vehicle.scan.mount_x = 0.02; }},
    {"Disturbed",
     [](Experiment* e) {
       e->environment.speed_disturbance = 0.1;
       e->environment.yaw_rate_disturbance = 0.2;
     }},
};

class PilotFilterTest : public ::testing::TestWithParam<Case> {};

TEST_P(PilotFilterTest, KeepsARandomPolicyOffTheWalls) {
  Experiment experiment = actors::HallExperiment();
  experiment.vehicle.lag = 0.05;
  GetParam().change(&experiment);
  bool filtered = false;
  EXPECT_GT(Collisions(experiment, &filtered), 5);
  EXPECT_FALSE(filtered);
  experiment.safety.filter = SafetyConfig::Filter::kEvaluation;
  EXPECT_EQ(Collisions(experiment, &filtered), 0);
  EXPECT_TRUE(filtered);
}

INSTANTIATE_TEST_SUITE_P(Vehicles, PilotFilterTest, ::testing::ValuesIn(kFilteredCases),
                         [](const auto& p) { return std::string(p.param.name); });

class PilotTest : public ::testing::Test {
 protected:
  RobotState At(double x, double y, double yaw = 0, double speed = 0) {
    RobotState state;
    state.utime = utime_ += kPeriodUs;
    state.pose = {x, y, 0, yaw};
    state.velocity = {speed, 0, 0, 0};
    state.angle_min = 0;
    state.angle_step = 2 * std::numbers::pi / 72;
    state.ranges.assign(72, 1.0f);
    return state;
  }

  Experiment experiment_ = actors::HallExperiment();  // x 0…3, y 0…1; goal x 2.6…2.9, y 0.3…0.7
  std::shared_ptr<const actors::Scene> scene_ = actors::MakeScene(experiment_);
  PolicyFile file_ = RandomPolicy(experiment_);
  int64_t utime_ = 0;
};

TEST_F(PilotTest, ArrivesInTheGoalRegionAndStandsStill) {
  Pilot pilot(scene_, file_);
  EXPECT_EQ(pilot.Act(At(2.5, 0.5)).mode, RobotCommand::Mode::kDrive);
  const RobotCommand command = pilot.Act(At(2.7, 0.5));
  EXPECT_EQ(command.mode, RobotCommand::Mode::kArrived);
  EXPECT_EQ(command.command, (std::vector<double>{0, 0}));
  EXPECT_EQ(command.way_to_go, 0);
}

TEST_F(PilotTest, SaysTheWayToGo) {
  Pilot pilot(scene_, file_);
  EXPECT_NEAR(pilot.Act(At(1.6, 0.5)).way_to_go, 1.0, 0.06);
}

TEST_F(PilotTest, UnsoundStatesStopItWithTheReasonAndChangeNothing) {
  Pilot pilot(scene_, file_), calm(scene_, file_);
  RobotState good = At(1, 0.5);
  EXPECT_EQ(pilot.Act(good).command, calm.Act(good).command);
  const struct {
    const char* note;
    void (*change)(RobotState*);
  } cases[] = {{"pose[1] is nan", [](RobotState* s) { s->pose[1] = NAN; }},
               {"velocity[3] is inf", [](RobotState* s) { s->velocity[3] = INFINITY; }},
               {"not later than the last state's", [](RobotState* s) { s->utime = kPeriodUs; }},
               {"outside the world", [](RobotState* s) { s->pose[0] = 3.5; }},
               {"num_ranges is 0", [](RobotState* s) { s->ranges.clear(); }},
               {"beam", [](RobotState* s) { s->ranges.resize(10); }}};
  for (const auto& c : cases) {
    RobotState bad = At(1.1, 0.5);
    c.change(&bad);
    const RobotCommand command = pilot.Act(bad);
    EXPECT_EQ(command.mode, RobotCommand::Mode::kStop) << c.note;
    EXPECT_THAT(command.note, HasSubstr(c.note));
    EXPECT_EQ(command.command, (std::vector<double>{0, 0}));
    EXPECT_EQ(command.state_utime, bad.utime);
  }
  good = At(1.1, 0.5);
  EXPECT_EQ(pilot.Act(good).command, calm.Act(good).command);
}

TEST_F(PilotTest, TheSafetyFilterWantsADenseScanAndNoQuadrotor) {
  experiment_.safety.filter = SafetyConfig::Filter::kAlways;
  experiment_.safety.beams = 180;
  Pilot pilot(actors::MakeScene(Pilot::ForPilot(experiment_)), file_);
  EXPECT_THAT(pilot.Act(At(1, 0.5)).note,
              HasSubstr("the safety filter (safety.beams = 180) wants 0.03491 rad or less"));
  experiment_.vehicle.kind = VehicleConfig::Kind::kQuadrotor;
  EXPECT_THROW(Pilot::ForPilot(experiment_), UsageError);
}

TEST_F(PilotTest, InsideAnObstacleItStandsStill) {
  experiment_.world.obstacles = {{{1.2, 0.4, 0}, {1.4, 0.6, 0}}};
  Pilot pilot(actors::MakeScene(experiment_), file_);
  EXPECT_THAT(pilot.Act(At(1.3, 0.5)).note, HasSubstr("inside an obstacle of the map"));
}

TEST_F(PilotTest, ThePoseFilterMixesWhatIsMeasuredWithOdometry) {
  const auto filtered = [&](double share) {
    experiment_.observation.pose_filter = share;
    return Pilot(actors::MakeScene(experiment_), file_);
  };
  const auto way = [&](Pilot&& pilot, double x0, double x1, double speed) {
    pilot.Act(At(x0, 0.5, 0, speed));
    return pilot.Act(At(x1, 0.5, 0, speed)).way_to_go;
  };
  const double at_half = way(filtered(0), 1, 1.2, 0);
  EXPECT_NEAR(way(filtered(0.5), 1, 1.4, 0), at_half, 1e-6) << "it stands: half of the jump is believed";
  EXPECT_NEAR(way(filtered(0.5), 1.1, 1.2, 1), at_half, 1e-6) << "0.1 s at 1 m/s is what is measured";
  EXPECT_NEAR(way(filtered(0.9), 1.1, 1.2, 1), at_half, 1e-6);
}

}  // namespace
}  // namespace cairn::deploy
