#include "actors/vehicles/plane_car.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace cairn::actors {
namespace {

constexpr double kRate = 240;
constexpr double kStep = 1 / kRate;

PlaneCar MakeCar(double lag = 0.05, double spread = 0) {
  VehicleConfig config;
  config.lag = lag;
  return PlaneCar(config, kStep, spread);
}

void Reset(Vehicle& car, double yaw = 0) {
  RandomStream random(1, RandomPurpose::kParameters);
  car.Reset(0, 0, yaw, random);
}

void Advance(Vehicle& car, int steps) {
  for (int i = 0; i < steps; ++i) car.Step();
}

// speed(t) = v (1 − exp(−t / lag)), and the way ODE integrates is the sum of the speeds.
TEST(PlaneCarTest, FollowsTheCommandWithAFirstOrderLag) {
  PlaneCar car = MakeCar(0.05);
  Reset(car);
  car.Command(0.8, 0);
  double way = 0;
  for (int i = 1; i <= 100; ++i) {
    car.Step();
    const double speed = 0.8 * (1 - std::exp(-i * kStep / 0.05));
    way += speed * kStep;
    ASSERT_NEAR(car.state().speed, speed, 1e-12);
    ASSERT_NEAR(car.state().x, way, 1e-6);
  }
}

TEST(PlaneCarTest, WithoutLagFollowsAtOnce) {
  PlaneCar car = MakeCar(0);
  Reset(car);
  car.Command(0.8, -1);
  car.Step();
  EXPECT_EQ(car.state().speed, 0.8);
  EXPECT_EQ(car.state().yaw_rate, -1);
}

// A circle of radius v / ω; after a whole turn back at the start (semi-implicit steps err by less than v h).
TEST(PlaneCarTest, DrivesACircleOfRadiusSpeedOverYawRate) {
  PlaneCar car = MakeCar(0);
  Reset(car);
  car.Command(0.4, 1.6);
  const int turn = static_cast<int>(std::lround(2 * std::numbers::pi / 1.6 * kRate));
  Advance(car, turn / 2);
  EXPECT_NEAR(std::hypot(car.state().x, car.state().y), 2 * 0.4 / 1.6, 0.002);
  Advance(car, turn - turn / 2);
  EXPECT_NEAR(std::hypot(car.state().x, car.state().y), 0, 0.002);
}

TEST(PlaneCarTest, StaysInThePlaneForALongTime) {
  PlaneCar car = MakeCar();
  Reset(car, 1.0);
  RandomStream random(3, RandomPurpose::kTest);
  for (int i = 0; i < 20000; ++i) {
    if (i % 24 == 0) car.Command(random.Uniform(0, 1), random.Uniform(-2, 2));
    car.Step();
  }
  // The way driven and the position agree only if no motion leaks out of the plane; NaN would fail as well.
  const GroundState before = car.state();
  car.Command(0, 0);
  Advance(car, 240);
  const GroundState after = car.state();
  EXPECT_LT(std::hypot(after.x - before.x, after.y - before.y), 0.06);
  EXPECT_NEAR(after.speed, 0, 1e-6);
}

TEST(PlaneCarTest, SavesAndLoadsBitForBitInMidEpisode) {
  PlaneCar car = MakeCar(0.05, 0.3), other = MakeCar(0.05, 0.3);
  Reset(car, 0.7);
  car.Command(1.0, 1.5);
  Advance(car, 77);
  const std::string blob = car.Save();
  Reset(other, -1);
  Advance(other, 10);
  other.Load(blob);
  for (PlaneCar* c : {&car, &other}) {
    Advance(*c, 10);
    c->Command(0.1, -0.4);
    Advance(*c, 200);
  }
  EXPECT_EQ(car.Save(), other.Save());
}

TEST(PlaneCarTest, ParameterSpreadChangesTheLag) {
  PlaneCar car = MakeCar(0.05, 0.5);
  double speeds[2];
  for (uint32_t episode = 0; episode < 2; ++episode) {
    RandomStream random(1, RandomPurpose::kParameters, 0, episode);
    car.Reset(0, 0, 0, random);
    car.Command(1, 0);
    Advance(car, 12);
    speeds[episode] = car.state().speed;
  }
  EXPECT_GT(std::abs(speeds[0] - speeds[1]), 0.01);
}

}  // namespace
}  // namespace cairn::actors
