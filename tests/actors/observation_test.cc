#include "actors/observation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "tests/actors/test_scene.h"

namespace cairn::actors {
namespace {

constexpr double kPi = std::numbers::pi;

Experiment Only(bool ObservationConfig::*part) {
  Experiment experiment = HallExperiment();
  ObservationConfig& o = experiment.observation;
  o.position = o.heading = o.velocity = o.d_min = o.look_ahead = o.rays = false;
  if (part != nullptr) o.*part = true;
  return experiment;
}

Box GoalOf(const Experiment& experiment) { return MakeWorld(experiment.world).goal; }

std::vector<float> Observe(const Experiment& experiment, const GroundState& state, float d_min = 1,
                           std::shared_ptr<const RoadmapLookup> table = nullptr) {
  Scene scene(experiment);
  if (table == nullptr) table = MakeChain(scene.world().goal, {0.5f, 1.5f, 2.7f}, 0.5f, 0.05);
  scene.SetTable(table);
  const ObservationBuilder builder(scene);
  EXPECT_EQ(builder.size(), ObservationSize(experiment));
  std::vector<float> out(static_cast<size_t>(builder.size()) + 1, 123.0f);
  builder.Build(state, d_min, out.data());
  EXPECT_EQ(out.back(), 123.0f) << "wrote past its size";
  out.pop_back();
  return out;
}

void ExpectNear(const std::vector<float>& actual, const std::vector<double>& expected, double tolerance = 1e-5) {
  ASSERT_EQ(actual.size(), expected.size());
  for (size_t i = 0; i < actual.size(); ++i) EXPECT_NEAR(actual[i], expected[i], tolerance) << i;
}

TEST(ObservationTest, PositionIsScaledOverTheBounds) {
  ExpectNear(Observe(Only(&ObservationConfig::position), {0, 1, 0, 0, 0}), {-1, 1});
  ExpectNear(Observe(Only(&ObservationConfig::position), {2.25, 0.5, 0, 0, 0}), {0.5, 0});
}

TEST(ObservationTest, HeadingIsCosineAndSine) {
  ExpectNear(Observe(Only(&ObservationConfig::heading), {1, 0.5, kPi / 3, 0, 0}), {0.5, std::sqrt(3) / 2});
}

TEST(ObservationTest, AnAckermannCarTurnsAsFastAsItsSteeringLetsIt) {
  Experiment experiment = Only(&ObservationConfig::velocity);
  experiment.vehicle.kind = VehicleConfig::Kind::kAckermann;
  experiment.vehicle.max_steering = kPi / 4;
  experiment.vehicle.wheel_base = 0.5;
  ExpectNear(Observe(experiment, {1, 0.5, 0, 1, 1}), {1, 0.5});  // of 1 m/s · tan 45° / 0.5 m
}

TEST(ObservationTest, VelocitiesAreOverTheirLimits) {
  Experiment experiment = Only(&ObservationConfig::velocity);
  experiment.vehicle.max_speed = 2;
  experiment.vehicle.max_yaw_rate = 4;
  ExpectNear(Observe(experiment, {1, 0.5, 0, 0.5, -1}), {0.25, -0.25});
  experiment.vehicle.min_speed = -4;
  ExpectNear(Observe(experiment, {1, 0.5, 0, -2, 2}), {-0.5, 0.5});
}

TEST(ObservationTest, DMinIsScaledByTheLongestCost) {
  const Experiment experiment = Only(&ObservationConfig::d_min);  // longest cost 2.2 m
  ExpectNear(Observe(experiment, {1, 0.5, 0, 0, 0}, 2.2f), {1});
  ExpectNear(Observe(experiment, {1, 0.5, 0, 0, 0}, 0.55f), {-0.5});
  ExpectNear(Observe(experiment, {1, 0.5, 0, 0, 0}, 0.0f), {-1});
  ExpectNear(Observe(experiment, {1, 0.5, 0, 0, 0}, kUnreachable), {1.2});
  ExpectNear(Observe(experiment, {1, 0.5, 0, 0, 0}, 20.0f), {1.2});
}

// The vertex 0.05 m ahead on the line y = 0.5 leads along +x. Facing +y, that is to the right: body −y.
TEST(ObservationTest, LookAheadIsInTheBodyFrameOverItsLength) {
  Experiment experiment = Only(&ObservationConfig::look_ahead);
  experiment.observation.look_ahead_near = 0.12;
  experiment.observation.look_ahead_far = 0.30;
  const auto table = MakeChain(GoalOf(experiment), {0.5f, 1.5f, 2.7f}, 0.5f, 0.05);
  ExpectNear(Observe(experiment, {0.45, 0.5, kPi / 2, 0, 0}, 1, table), {0, -1, 0, -1});
  ExpectNear(Observe(experiment, {0.45, 0.5, 0, 0, 0}, 1, table), {1, 0, 1, 0});
  // From (0.5, 0.46): 0.04 m up to the vertex, then 0.08 or 0.26 m along x.
  ExpectNear(Observe(experiment, {0.5, 0.46, 0, 0, 0}, 1, table), {0.08 / 0.12, 0.04 / 0.12, 0.26 / 0.3, 0.04 / 0.3});
}

TEST(ObservationTest, LookAheadIsZeroWithoutAWay) {
  Experiment experiment = Only(&ObservationConfig::look_ahead);
  const auto chain = MakeChain(GoalOf(experiment), {0.5f}, 0.5f, 0.05);
  CostTable table = chain->table();
  table.cost[0] = kUnreachable;
  const auto nowhere = std::make_shared<RoadmapLookup>(2, std::vector<float>{0.5f, 0.5f}, table, 0.05);
  ExpectNear(Observe(experiment, {0.5, 0.5, 0, 0, 0}, 1, nowhere), {0, 0, 0, 0});
}

TEST(ObservationTest, BeamsOfACircleStartAheadAndTurnLeft) {
  ScanConfig scan;
  scan.beams = 4;
  for (int beam = 0; beam < 4; ++beam) EXPECT_NEAR(BeamAngle(scan, beam), beam * kPi / 2, 1e-12);
}

TEST(ObservationTest, BeamsOfASectorIncludeItsEnds) {
  ScanConfig scan;
  scan.beams = 3;
  scan.field_of_view = kPi;
  EXPECT_NEAR(BeamAngle(scan, 0), -kPi / 2, 1e-12);
  EXPECT_NEAR(BeamAngle(scan, 1), 0, 1e-12);
  EXPECT_NEAR(BeamAngle(scan, 2), kPi / 2, 1e-12);
  scan.beams = 1;
  EXPECT_EQ(BeamAngle(scan, 0), 0);
}

// At (0.2, 0.6) facing +y: ahead 0.4 m, left 0.2 m (x = 0), behind 0.6 m, right 2.8 m; the range ends at 0.5 m.
TEST(ObservationTest, RaysEncodeCappedRangesInTheBodyFrame) {
  Experiment experiment = Only(&ObservationConfig::rays);
  experiment.vehicle.scan.beams = 4;
  experiment.vehicle.scan.range = 0.5;
  experiment.observation.ray_scale = 0.06;
  const double radius = experiment.vehicle.circumscribed_radius();
  const auto encode = [&](double range) { return 1 - 2 * std::exp(-(range - radius) / 0.06); };
  ExpectNear(Observe(experiment, {0.2, 0.6, kPi / 2, 0, 0}), {encode(0.4), encode(0.2), encode(0.5), encode(0.5)});
}

// Closer than the inscribed radius (25 mm) nothing is told apart, so that entries stay bounded.
TEST(ObservationTest, RaysStayBoundedAtAWall) {
  Experiment experiment = Only(&ObservationConfig::rays);
  experiment.vehicle.scan.beams = 4;
  const std::vector<float> at_wall = Observe(experiment, {0.0, 0.5, kPi, 0, 0});
  const std::vector<float> close = Observe(experiment, {0.025, 0.5, kPi, 0, 0});
  EXPECT_NEAR(at_wall[0], close[0], 1e-6);
  EXPECT_GT(at_wall[0], -2.0);
  EXPECT_LT(at_wall[0], -1.0);
}

TEST(ObservationTest, TheScannersMountShiftsTheRays) {
  Experiment experiment = Only(&ObservationConfig::rays);
  experiment.vehicle.scan.beams = 4;
  const std::vector<float> centered = Observe(experiment, {0.23, 0.5, kPi, 0, 0});
  experiment.vehicle.scan.mount_x = 0.03;
  ExpectNear(Observe(experiment, {0.26, 0.5, kPi, 0, 0}), {centered.begin(), centered.end()});
}

TEST(ObservationTest, PartsComeInTheOrderOfTheConfig) {
  Experiment experiment = HallExperiment();
  experiment.observation.position = true;
  const GroundState state{0.45, 0.5, 0.3, 0.5, 1.0};
  const std::vector<float> all = Observe(experiment, state);
  std::vector<float> joined;
  for (const auto part : {&ObservationConfig::position, &ObservationConfig::heading, &ObservationConfig::velocity,
                          &ObservationConfig::d_min, &ObservationConfig::look_ahead, &ObservationConfig::rays}) {
    const std::vector<float> one = Observe(Only(part), state);
    joined.insert(joined.end(), one.begin(), one.end());
  }
  EXPECT_EQ(all, joined);
  EXPECT_EQ(all.size(), 2u + 2 + 2 + 1 + 4 + 16);
}

TEST(ObservationTest, ThePapersOwnIsOneSetting) {
  Experiment experiment = HallExperiment();
  experiment.observation.position = true;
  experiment.observation.look_ahead = experiment.observation.rays = false;
  EXPECT_EQ(Observe(experiment, {1, 0.5, 0, 0, 0}).size(), 7u);
}

}  // namespace
}  // namespace cairn::actors
