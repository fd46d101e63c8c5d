#include "actors/vehicles/quadrotor/quadrotor.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/actors/vehicles/drive.h"

namespace cairn::actors {
namespace {

constexpr double kRate = 240;
constexpr double kStep = 1 / kRate;

VehicleConfig Config(double radius = 0.045) {
  VehicleConfig config;
  config.kind = VehicleConfig::Kind::kQuadrotor;
  config.radius = radius;
  config.min_speed = -1.5;
  config.max_speed = 1.5;
  return config;
}

Quadrotor MakeQuadrotor(double radius = 0.045, double spread = 0) {
  return Quadrotor(QuadrotorParams::ScaledTo(Config(radius)), kStep, spread);
}

// At rest each rotor carries a quarter of the weight, m g / 4, and nothing moves.
TEST(QuadrotorTest, HoversOnAQuarterOfItsWeightPerRotor) {
  Quadrotor quadrotor = MakeQuadrotor();
  Reset(quadrotor, {0.1, 0.2, 0, 0.3});
  Advance(quadrotor, 2400);
  for (const double thrust : quadrotor.thrusts()) EXPECT_NEAR(thrust, 0.027 * 9.81 / 4, 1e-9);
  const Motion motion = quadrotor.motion();
  EXPECT_NEAR(motion.x, 0.1, 1e-9);
  EXPECT_NEAR(motion.y, 0.2, 1e-9);
  EXPECT_NEAR(motion.z, 0.3, 1e-9);
}

// Thrust F on every rotor from now on: F_i follows with the motors' lag, so for a level body
// v(t) = (4 F − m g) / m · (t − lag (1 − e^(−t/lag))). Wanting to climb faster than it can asks for max_climb.
TEST(QuadrotorTest, ClimbsAsItsThrustSays) {
  Quadrotor quadrotor = MakeQuadrotor();
  Reset(quadrotor);
  quadrotor.Command({0, 0, 1.5});
  double v = 0, extra = 0;  // extra: acceleration above gravity that the rotors give
  const double blend = 1 - std::exp(-kStep / 0.02);
  for (int i = 0; i < 12; ++i) {  // 10 (1.5 − v) stays above max_climb while v < 0.9
    quadrotor.Step();
    extra += blend * (6 - extra);
    v += extra * kStep;
    ASSERT_NEAR(quadrotor.motion().vz, v, 1e-9);
  }
}

// Steady level flight needs no tilt (there is no drag): upright, at the commanded speed, at the height it had.
TEST(QuadrotorTest, ReachesTheCommandedVelocityUprightWithoutLosingHeight) {
  Quadrotor quadrotor = MakeQuadrotor();
  Reset(quadrotor, {0, 0, 0, 1});
  quadrotor.Command({1, -0.5, 0});
  Advance(quadrotor, 480);
  const Motion motion = quadrotor.motion();
  EXPECT_NEAR(motion.vx, 1, 1e-3);
  EXPECT_NEAR(motion.vy, -0.5, 1e-3);
  EXPECT_NEAR(motion.vz, 0, 1e-3);
  EXPECT_NEAR(motion.z, 1, 0.02);
  EXPECT_NEAR(quadrotor.uprightness(), 1, 1e-5);
  EXPECT_NEAR(motion.yaw, 0, 1e-12);
}

TEST(QuadrotorTest, CommandsAreInTheFrameOfItsYaw) {
  Quadrotor quadrotor = MakeQuadrotor();
  Reset(quadrotor, {0, 0, std::acos(0.0), 0});
  quadrotor.Command({1, 0, 0});
  Advance(quadrotor, 480);
  EXPECT_NEAR(quadrotor.motion().x, 0, 1e-3);
  EXPECT_GT(quadrotor.motion().y, 1.5);
  EXPECT_NEAR(quadrotor.motion().vx, 1, 1e-3);
}

struct StepResponse {
  double t90 = 0, overshoot = 0, stopping_distance = 0;
};

StepResponse MeasureStep(Quadrotor& quadrotor, double speed) {
  StepResponse response;
  Reset(quadrotor);
  quadrotor.Command({speed, 0, 0});
  for (int i = 1; i <= 480; ++i) {
    quadrotor.Step();
    const double v = quadrotor.motion().vx;
    if (response.t90 == 0 && v >= 0.9 * speed) response.t90 = i * kStep;
    response.overshoot = std::max(response.overshoot, v / speed - 1);
  }
  const double x = quadrotor.motion().x;
  quadrotor.Command({0, 0, 0});
  Advance(quadrotor, 480);
  response.stopping_distance = quadrotor.motion().x - x;
  return response;
}

// The figures of the tracking table in docs/adding_a_vehicle.md.
TEST(QuadrotorTest, TracksAsTheTableSays) {
  Quadrotor quadrotor = MakeQuadrotor();
  const StepResponse response = MeasureStep(quadrotor, 1.5);
  RecordProperty("t90_ms", static_cast<int>(1000 * response.t90));
  RecordProperty("overshoot_permille", static_cast<int>(1000 * response.overshoot));
  RecordProperty("stopping_mm", static_cast<int>(1000 * response.stopping_distance));
  EXPECT_NEAR(response.t90, 0.23, 0.04);
  EXPECT_LT(response.overshoot, 0.02);
  EXPECT_NEAR(response.stopping_distance, 0.20, 0.04);
}

// Accelerations stay; torques over inertia fall with 1 / size, so it levels off later.
TEST(QuadrotorTest, FliesAtTwiceTheSize) {
  Quadrotor large = MakeQuadrotor(0.09);
  const StepResponse response = MeasureStep(large, 1.5);
  EXPECT_NEAR(response.t90, 0.22, 0.04);
  EXPECT_LT(response.overshoot, 0.12);
}

TEST(QuadrotorTest, SurvivesRandomCommandsForALongTime) {
  Quadrotor quadrotor = MakeQuadrotor(0.045, 0.2);
  RandomStream random(3, RandomPurpose::kTest);
  Reset(quadrotor);
  for (int i = 0; i < 60000; ++i) {
    if (i % 24 == 0) {
      quadrotor.Command({random.Uniform(-2.5, 2.5), random.Uniform(-2.5, 2.5), random.Uniform(-2.5, 2.5)});
    }
    quadrotor.Step();
    ASSERT_GT(quadrotor.uprightness(), 0) << "tipped over at step " << i;
    const Motion m = quadrotor.motion();
    ASSERT_LT(std::hypot(m.vx, m.vy, m.vz), 5) << i;
  }
}

TEST(QuadrotorTest, SavesAndLoadsBitForBitInMidEpisode) {
  Quadrotor one = MakeQuadrotor(0.045, 0.3), other = MakeQuadrotor(0.045, 0.3);
  Reset(one, {1, 2, 0, 3});
  one.Command({1.0, 0.5, -0.3});
  Advance(one, 77);
  const std::string blob = one.Save();
  RandomStream random(9, RandomPurpose::kParameters);
  other.Reset({0, 0, 0, 0}, random);
  Advance(other, 10);
  other.Load(blob);
  for (Quadrotor* q : {&one, &other}) {
    Advance(*q, 10);
    q->Command({-1, 0.1, 0.4});
    Advance(*q, 200);
  }
  EXPECT_EQ(one.Save(), other.Save());
}

}  // namespace
}  // namespace cairn::actors
