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
  experiment.safety.period = 0.025;
  return experiment;
}

Experiment Flying() {
  Experiment experiment;
  experiment.vehicle.kind = VehicleConfig::Kind::kQuadrotor;
  experiment.vehicle.radius = 0.045;
  experiment.vehicle.min_speed = -1.5;
  experiment.vehicle.max_speed = 1.5;
  return experiment;
}

std::unique_ptr<Vehicle> Driving(const Experiment& experiment, const VehicleCommand& command) {
  auto vehicle = MakeVehicle(experiment.vehicle, experiment.environment);
  RandomStream random(0, RandomPurpose::kTest);
  vehicle->Reset({0.3, 0.2, 0.5, 0}, random);
  vehicle->Command(command);
  for (int i = 0; i < 480; ++i) vehicle->Step();
  return vehicle;
}

// Speed v e^(−t/lag) from the command on: v · lag until it stands, whatever v.
TEST(BrakingTest, ALaggedBaseStopsWithinSpeedTimesLag) {
  for (const double speed : {0.05, 0.25, 0.5, 1.0}) {
    EXPECT_NEAR(StoppingDistance(LaggedCar(), {speed, 0, 0}), 0.1 * speed, 0.03 * 0.1 * speed + 1e-4) << speed;
  }
}

// With a limited deceleration a: v² / 2a.
TEST(BrakingTest, ALimitedDecelerationTakesTheSquareOfSpeed) {
  Experiment experiment = LaggedCar();
  experiment.vehicle.lag = 0;
  experiment.vehicle.max_acceleration = 2;
  for (const double speed : {0.5, 1.0}) {
    EXPECT_NEAR(StoppingDistance(experiment, {speed, 0, 0}), speed * speed / 4, 0.004) << speed;
  }
}

// MEASURED: 1.5 m/s to 0 within 0.20 m in level flight. Its rotors cannot push down, so that a climb is braked by
// gravity less what they keep for tilting (QuadrotorParams::torque_reserve): 1 − 4 · 0.25 · 0.149 N / weight of g, 4.3
// m/s², or v² / 2a = 0.26 m and what it goes until the thrust has fallen.
TEST(BrakingTest, TheQuadrotorsWayIsItsOwn) {
  EXPECT_NEAR(StoppingDistance(Flying(), {1.5, 0, 0}), 0.22, 0.02);
  EXPECT_NEAR(StoppingDistance(Flying(), {0, 0, -1.5}), 0.22, 0.02);
  EXPECT_NEAR(StoppingDistance(Flying(), {0, 0, 1.5}), 0.26 + 1.5 * 0.02, 0.02);
}

// In whole steps of dt a speed that falls as e^(−t/lag) goes lag − dt / 2.
constexpr double kLag = 0.1 - 0.5 / 240;

// v · lag of braking and v · period until it begins, with caution; in the frame of the beginning, along its x.
TEST(BrakingTest, TheTwinDrivesOnAndStops) {
  const Experiment experiment = LaggedCar();
  const auto car = Driving(experiment, {0.8, 0, 0});
  BrakingTwin twin(experiment);
  twin.Follow(*car, 0);
  const Place& stop = twin.Drive({0.8, 0, 0}).back();
  EXPECT_NEAR(stop.p.x(), 1.5 * 0.8 * (kLag + 0.025), 1e-3);
  EXPECT_NEAR(stop.p.y(), 0, 1e-9);
  EXPECT_GE(stop.swept, stop.p.norm());
  EXPECT_NEAR(twin.Drive({0, 0, 0}).back().p.x(), 1.5 * 0.8 * kLag, 1e-3);
}

TEST(BrakingTest, TheTwinTurnsOnUntilItsTurnIsBraked) {
  Experiment experiment = LaggedCar();
  const auto car = Driving(experiment, {0, 2, 0});
  BrakingTwin twin(experiment);
  twin.Follow(*car, 0);
  const Place& stop = twin.Drive({0, 0, 0}).back();
  EXPECT_NEAR(std::atan2(stop.sin, stop.cos), 1.5 * 2 * kLag, 0.02);
  EXPECT_NEAR(stop.swept, 1.5 * 2 * kLag * experiment.vehicle.circumscribed_radius(), 1e-3);
}

TEST(BrakingTest, ADeclaredDistanceStretchesTheWay) {
  Experiment experiment = LaggedCar();
  experiment.safety.stopping_distance = 0.3;
  const BrakingTwin twin(experiment);
  EXPECT_NEAR(twin.stretch(), 1.5 * 0.3 / 0.1, 0.15);
}

}  // namespace
}  // namespace cairn::actors
