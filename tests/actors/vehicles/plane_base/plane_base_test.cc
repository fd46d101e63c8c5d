#include "actors/vehicles/plane_base/plane_base.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/actors/vehicles/drive.h"

namespace cairn::actors {
namespace {

constexpr double kRate = 240;
constexpr double kStep = 1 / kRate;

PlaneBase MakeCar(double lag = 0.05, double spread = 0) {
  VehicleConfig config;
  config.kind = VehicleConfig::Kind::kPlaneCar;
  config.lag = lag;
  return PlaneBase(config, kStep, spread);
}

// speed(t) = v (1 − exp(−t / lag)), and the way ODE integrates is the sum of the speeds.
TEST(PlaneBaseTest, FollowsTheCommandWithAFirstOrderLag) {
  PlaneBase car = MakeCar(0.05);
  Reset(car);
  car.Command({0.8, 0});
  double way = 0;
  for (int i = 1; i <= 100; ++i) {
    car.Step();
    const double speed = 0.8 * (1 - std::exp(-i * kStep / 0.05));
    way += speed * kStep;
    ASSERT_NEAR(car.motion().vx, speed, 1e-12);
    ASSERT_NEAR(car.motion().x, way, 1e-6);
  }
}

TEST(PlaneBaseTest, WithoutLagFollowsAtOnce) {
  PlaneBase car = MakeCar(0);
  Reset(car);
  car.Command({0.8, -1});
  car.Step();
  EXPECT_EQ(car.motion().vx, 0.8);
  EXPECT_EQ(car.motion().yaw_rate, -1);
}

// A circle of radius v / ω; after a whole turn back at the start (semi-implicit steps err by less than v h).
TEST(PlaneBaseTest, DrivesACircleOfRadiusSpeedOverYawRate) {
  PlaneBase car = MakeCar(0);
  Reset(car);
  car.Command({0.4, 1.6});
  const int turn = static_cast<int>(std::lround(2 * std::numbers::pi / 1.6 * kRate));
  Advance(car, turn / 2);
  EXPECT_NEAR(std::hypot(car.motion().x, car.motion().y), 2 * 0.4 / 1.6, 0.002);
  Advance(car, turn - turn / 2);
  EXPECT_NEAR(std::hypot(car.motion().x, car.motion().y), 0, 0.002);
}

TEST(PlaneBaseTest, StaysInThePlaneForALongTime) {
  PlaneBase car = MakeCar();
  Reset(car, {0, 0, 1.0});
  RandomStream random(3, RandomPurpose::kTest);
  for (int i = 0; i < 20000; ++i) {
    if (i % 24 == 0) car.Command({random.Uniform(0, 1), random.Uniform(-2, 2)});
    car.Step();
  }
  // The way driven and the position agree only if no motion leaks out of the plane; NaN would fail as well.
  const Motion before = car.motion();
  car.Command({0, 0});
  Advance(car, 240);
  const Motion after = car.motion();
  EXPECT_LT(std::hypot(after.x - before.x, after.y - before.y), 0.06);
  EXPECT_NEAR(after.vx, 0, 1e-6);
}

TEST(PlaneBaseTest, SavesAndLoadsBitForBitInMidEpisode) {
  PlaneBase car = MakeCar(0.05, 0.3), other = MakeCar(0.05, 0.3);
  Reset(car, {0, 0, 0.7});
  car.Command({1.0, 1.5});
  Advance(car, 77);
  const std::string blob = car.Save();
  Reset(other, {0, 0, -1});
  Advance(other, 10);
  other.Load(blob);
  for (PlaneBase* c : {&car, &other}) {
    Advance(*c, 10);
    c->Command({0.1, -0.4});
    Advance(*c, 200);
  }
  EXPECT_EQ(car.Save(), other.Save());
}

TEST(PlaneBaseTest, ParameterSpreadChangesTheLag) {
  PlaneBase car = MakeCar(0.05, 0.5);
  double speeds[2];
  for (uint32_t episode = 0; episode < 2; ++episode) {
    RandomStream random(1, RandomPurpose::kParameters, 0, episode);
    car.Reset({0, 0, 0}, random);
    car.Command({1, 0});
    Advance(car, 12);
    speeds[episode] = car.motion().vx;
  }
  EXPECT_GT(std::abs(speeds[0] - speeds[1]), 0.01);
}

VehicleConfig Config(VehicleConfig::Kind kind) {
  VehicleConfig config;
  config.kind = kind;
  config.lag = 0;
  return config;
}

// In its own frame: turned by 90°, forward is +y of W and left is −x.
TEST(PlaneBaseTest, AHolonomicBaseMovesAlongBothItsAxes) {
  PlaneBase base(Config(VehicleConfig::Kind::kHolonomic), kStep, 0);
  Reset(base, {0, 0, std::numbers::pi / 2});
  base.Command({0.5, 0.25, 0});
  Advance(base, 240);
  EXPECT_NEAR(base.motion().x, -0.25, 1e-9);
  EXPECT_NEAR(base.motion().y, 0.5, 1e-9);
  EXPECT_EQ(base.motion().vx, 0.5);
  EXPECT_EQ(base.motion().vy, 0.25);
}

// Single track: the rear axle runs on a circle of radius L / tan δ, the centre, half a wheel base ahead of the axle, on
// one of radius √((L / tan δ)² + (L / 2)²).
TEST(PlaneBaseTest, AnAckermannCarTurnsOnTheCircleOfItsSteering) {
  VehicleConfig config = Config(VehicleConfig::Kind::kAckermann);
  config.wheel_base = 0.1;
  config.max_steering = 0.5;
  PlaneBase car(config, kStep, 0);
  Reset(car);
  const double steering = 0.4, speed = 0.5;
  car.Command({speed, steering, 0});
  const double axle_radius = 0.1 / std::tan(steering), radius = std::hypot(axle_radius, 0.05);
  const double yaw_rate = speed / axle_radius;
  Advance(car, 1);
  EXPECT_NEAR(car.motion().yaw_rate, yaw_rate, 1e-12);
  EXPECT_NEAR(car.motion().vy, 0.05 * yaw_rate, 1e-12);
  Reset(car);
  car.Command({speed, steering, 0});
  double farthest = 0;
  for (int i = 0; i < static_cast<int>(2 * std::numbers::pi / yaw_rate * kRate); ++i) {
    car.Step();
    farthest = std::max(farthest, std::hypot(car.motion().x, car.motion().y));
  }
  EXPECT_NEAR(farthest, 2 * radius, 0.004);
  EXPECT_NEAR(std::hypot(car.motion().x, car.motion().y), 0, 0.004);
}

TEST(PlaneBaseTest, SteeringStopsAtItsEnd) {
  VehicleConfig config = Config(VehicleConfig::Kind::kAckermann);
  PlaneBase car(config, kStep, 0), end(config, kStep, 0);
  for (PlaneBase* c : {&car, &end}) Reset(*c);
  car.Command({0.5, 9, 0});
  end.Command({0.5, config.max_steering, 0});
  Advance(car, 10);
  Advance(end, 10);
  EXPECT_EQ(car.motion().yaw, end.motion().yaw);
  EXPECT_GT(car.motion().yaw, 0);
}

TEST(PlaneBaseTest, SpeedChangesNoFasterThanItsAcceleration) {
  VehicleConfig config = Config(VehicleConfig::Kind::kPlaneCar);
  config.max_acceleration = 2;
  PlaneBase car(config, kStep, 0);
  Reset(car);
  car.Command({1, 1, 0});
  Advance(car, 60);
  EXPECT_NEAR(car.motion().vx, 0.5, 1e-12);  // 2 m/s² for 0.25 s
  EXPECT_EQ(car.motion().yaw_rate, 1);
}

}  // namespace
}  // namespace cairn::actors
