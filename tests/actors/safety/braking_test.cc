#include "actors/safety/braking.h"

#include <gtest/gtest.h>

#include <cmath>

namespace cairn::actors {
namespace {

Experiment LaggedCar() {
  Experiment experiment;
  experiment.vehicle.kind = VehicleConfig::Kind::kPlaneCar;
  experiment.vehicle.lag = 0.1;
  experiment.safety.caution = 1.5;
  experiment.safety.period = 0.02;
  return experiment;
}

// Speed v e^(−t/lag) from the command on: v · lag until it stands, whatever v.
TEST(BrakingTest, ALaggedBaseStopsWithinSpeedTimesLag) {
  const BrakingTable braking(LaggedCar());
  for (const double speed : {0.05, 0.25, 0.5, 1.0}) {
    EXPECT_NEAR(braking.StoppingDistance(speed), 0.1 * speed, 0.03 * 0.1 * speed + 1e-4) << speed;
  }
}

// With a limited deceleration a: v² / 2a.
TEST(BrakingTest, ALimitedDecelerationTakesTheSquareOfSpeed) {
  Experiment experiment = LaggedCar();
  experiment.vehicle.lag = 0;
  experiment.vehicle.max_acceleration = 2;
  const BrakingTable braking(experiment);
  for (const double speed : {0.5, 1.0}) EXPECT_NEAR(braking.StoppingDistance(speed), speed * speed / 4, 0.004) << speed;
}

TEST(BrakingTest, AllowedSpeedLeavesCautionAndThePeriod) {
  const BrakingTable braking(LaggedCar());
  for (const double speed : {0.1, 0.5, 0.9}) {
    EXPECT_NEAR(braking.AllowedSpeed(1.5 * braking.StoppingDistance(speed) + 0.02 * speed), speed, 1e-9);
  }
  EXPECT_EQ(braking.AllowedSpeed(0), 0);
  EXPECT_LT(braking.AllowedSpeed(-0.01), 0);
  EXPECT_TRUE(std::isinf(braking.AllowedSpeed(braking.reach())));
}

TEST(BrakingTest, ADeclaredDistanceScalesTheMeasuredOnes) {
  Experiment experiment = LaggedCar();
  experiment.safety.stopping_distance = 0.3;
  const BrakingTable braking(experiment);
  EXPECT_NEAR(braking.StoppingDistance(1), 0.3, 1e-9);
  EXPECT_NEAR(braking.StoppingDistance(0.5), 0.15, 0.005);
}

// MEASURED: 1.5 m/s to 0 within 0.20 m.
// Not held yet: measured 0.298 m where 0.22 m is expected (docs/robustness.md).
TEST(BrakingTest, DISABLED_TheQuadrotorsWayIsItsOwn) {
  Experiment experiment;
  experiment.vehicle.kind = VehicleConfig::Kind::kQuadrotor;
  experiment.vehicle.radius = 0.045;
  experiment.vehicle.min_speed = -1.5;
  experiment.vehicle.max_speed = 1.5;
  EXPECT_NEAR(BrakingTable(experiment).StoppingDistance(1.5), 0.22, 0.06);
}

}  // namespace
}  // namespace cairn::actors
