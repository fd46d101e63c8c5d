#include "actors/vehicles/wheeled_car/wheeled_car.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "common/core/check.h"
#include "tests/actors/vehicles/drive.h"
#include "tests/actors/vehicles/wheeled_car/hinged_car.h"

namespace cairn::actors {
namespace {

constexpr double kRate = 240;
constexpr double kStep = 1 / kRate;

WheeledCar MakeCar(const VehicleConfig& config = {}, double spread = 0) {
  return WheeledCar(WheeledCarParams::ScaledTo(config), kStep, spread);
}

// Drives for a time [s].
void Drive(Vehicle& car, double seconds) { Advance(car, static_cast<int>(std::lround(seconds * kRate))); }

// Contacts settle within the surface layer, 0.1 mm deep, standing and driven: nothing pushes up or down there.
TEST(WheeledCarTest, RestsOnItsWheels) {
  WheeledCar car = MakeCar();
  Reset(car);
  Drive(car, 1);
  EXPECT_GE(car.chassis_height(), 0.0165 - 1.1e-4);
  EXPECT_LE(car.chassis_height(), 0.0165);
  EXPECT_NEAR(car.motion().vx, 0, 1e-6);
  EXPECT_NEAR(car.motion().x, 0, 1e-5);
  car.Command({0.5, 0.5});
  Drive(car, 3);
  EXPECT_GE(car.chassis_height(), 0.0165 - 1.1e-4);
  EXPECT_LE(car.chassis_height(), 0.0165);
}

TEST(WheeledCarTest, KeepsTheCommandedSpeed) {
  for (const double speed : {0.1, 0.5, 1.0}) {
    WheeledCar car = MakeCar();
    Reset(car);
    car.Command({speed, 0});
    Drive(car, 1);
    double squares = 0;
    for (int i = 0; i < 240; ++i) {
      car.Step();
      squares += std::pow(car.motion().vx - speed, 2);
    }
    EXPECT_LE(std::sqrt(squares / 240), 0.002) << speed;
    EXPECT_NEAR(car.wheel_speed(0), speed / 0.0125, 0.2);
    EXPECT_NEAR(car.wheel_speed(1), speed / 0.0125, 0.2);
  }
}

// Wheels give the chassis no more than μ g = 9.81 m/s², so 0.9 m/s takes at least 0.0917 s; measured before: 0.108 s.
TEST(WheeledCarTest, RisesToNinetyPercentInAHundredAndEightMilliseconds) {
  WheeledCar car = MakeCar();
  Reset(car);
  car.Command({1.0, 0});
  int steps = 0;
  while (car.motion().vx < 0.9 && steps < 240) {
    car.Step();
    ++steps;
  }
  EXPECT_GE(steps * kStep, 0.9 / 9.81);
  EXPECT_NEAR(steps * kStep, 0.108, 0.005);
}

// v² / 2a with a ≤ μ g: no shorter than 0.051 m from 1 m/s, and it must stop.
TEST(WheeledCarTest, BrakesWithinTheFrictionLimit) {
  WheeledCar car = MakeCar();
  Reset(car);
  car.Command({1.0, 0});
  Drive(car, 1);
  const double from = car.motion().x;
  car.Command({0, 0});
  Drive(car, 0.5);
  const double distance = car.motion().x - from;
  EXPECT_GE(distance, 1.0 / (2 * 9.81));
  EXPECT_LE(distance, 0.075);
  EXPECT_NEAR(car.motion().vx, 0, 1e-3);
}

// v and ω constant: a circle of radius v / ω around (0, v / ω), once in 2π / ω.
TEST(WheeledCarTest, DrivesACircleOfRadiusSpeedOverYawRate) {
  WheeledCar car = MakeCar();
  Reset(car);
  car.Command({0.4, 1.6});
  Drive(car, 1);
  double min_x = 1e9, max_x = -1e9, min_y = 1e9, max_y = -1e9;
  double turned = 0, last_yaw = car.motion().yaw;
  const int steps = static_cast<int>(std::lround(2 * std::numbers::pi / 1.6 * kRate));
  for (int i = 0; i < steps; ++i) {
    car.Step();
    const Motion s = car.motion();
    turned += std::remainder(s.yaw - last_yaw, 2 * std::numbers::pi);
    last_yaw = s.yaw;
    min_x = std::min(min_x, s.x), max_x = std::max(max_x, s.x);
    min_y = std::min(min_y, s.y), max_y = std::max(max_y, s.y);
  }
  EXPECT_NEAR(turned, 2 * std::numbers::pi, 0.02);
  EXPECT_NEAR(max_x - min_x, 2 * 0.4 / 1.6, 0.005);
  EXPECT_NEAR(max_y - min_y, 2 * 0.4 / 1.6, 0.005);
}

TEST(WheeledCarTest, TurnsOnTheSpot) {
  WheeledCar car = MakeCar();
  Reset(car);
  car.Command({0, 2});
  Drive(car, 0.5);
  const double yaw = car.motion().yaw;
  Drive(car, 0.5);
  EXPECT_NEAR(car.motion().yaw - yaw, 1.0, 0.01);
  EXPECT_NEAR(std::hypot(car.motion().x, car.motion().y), 0, 1e-3);
  EXPECT_NEAR(car.wheel_speed(1), 2 * 0.023 / 0.0125, 0.05);
}

// The friction pyramid turns with the car: every heading drives the same way.
TEST(WheeledCarTest, BehavesAlikeInEveryHeading) {
  std::vector<double> ends;
  for (const double yaw : {0.0, 0.4, std::numbers::pi / 4, 2.0}) {
    WheeledCar car = MakeCar();
    Reset(car, {0, 0, yaw});
    car.Command({1.0, 2.0});
    Drive(car, 0.3);
    ends.push_back(std::hypot(car.motion().x, car.motion().y));
  }
  for (const double end : ends) EXPECT_NEAR(end, ends[0], 1e-4);
}

// Weak motors, which grip never stops: a = (2 τ / r) / (m + 2 I / r²), with I = 0.4 m_w r² of each wheel.
TEST(WheeledCarTest, WeakMotorsAccelerateMassAndWheels) {
  WheeledCarParams params = WheeledCarParams::ScaledTo({});
  params.motor_torque = 0.0012;
  WheeledCar car(params, kStep, 0);
  Reset(car);
  car.Command({1.0, 0});
  Drive(car, 0.1);  // the nose rises first
  const double from = car.motion().vx;
  Drive(car, 0.5);
  const double acceleration = 2 * 0.0012 / 0.0125 / (0.17 + 2 * 0.4 * 0.01);
  EXPECT_NEAR(car.motion().vx - from, 0.5 * acceleration, 0.002);
  EXPECT_NEAR(car.wheel_speed(0), car.motion().vx / 0.0125, 0.3);
}

// Spinning wheels without grip: I dω/dt = τ.
TEST(WheeledCarTest, WheelsWithoutGripSpinUpByTheMotorAlone) {
  WheeledCarParams params = WheeledCarParams::ScaledTo({});
  params.motor_torque = 0.0006;
  params.wheel_surface.friction = 1e-9;
  WheeledCar car(params, kStep, 0);
  Reset(car);
  car.Command({1.0, 0});
  Advance(car, 10);
  EXPECT_NEAR(car.wheel_speed(0), 10 * kStep * 0.0006 / (0.4 * 0.01 * 0.0125 * 0.0125), 0.5);
  EXPECT_NEAR(car.motion().vx, 0, 1e-4);
}

// How far two cars drive apart under the same random commands, and how well each follows them (root mean squares).
struct Apart {
  double speed = 0, yaw_rate = 0, error = 0, other_error = 0;
};
Apart DriveBeside(Vehicle& car, Vehicle& other, double max_speed, double max_yaw_rate) {
  RandomStream random(1, RandomPurpose::kTest);
  Apart sum;
  constexpr int kEpisodes = 10, kCommands = 100, kHold = 24;
  for (int episode = 0; episode < kEpisodes; ++episode) {
    Reset(car), Reset(other);
    for (int i = 0; i < kCommands; ++i) {
      const VehicleCommand command{random.Uniform(0, max_speed), random.Uniform(-max_yaw_rate, max_yaw_rate)};
      car.Command(command), other.Command(command);
      for (int k = 0; k < kHold; ++k) {
        car.Step(), other.Step();
        sum.speed += std::pow(car.motion().vx - other.motion().vx, 2);
        sum.yaw_rate += std::pow(car.motion().yaw_rate - other.motion().yaw_rate, 2);
      }
      sum.error += std::pow(car.motion().vx - command[0], 2);
      sum.other_error += std::pow(other.motion().vx - command[0], 2);
    }
  }
  constexpr double kCount = kEpisodes * kCommands;
  return {std::sqrt(sum.speed / kCount / kHold), std::sqrt(sum.yaw_rate / kCount / kHold),
          std::sqrt(sum.error / kCount), std::sqrt(sum.other_error / kCount)};
}

// Wheels slip and casters hit the floor after each wild command, and small differences grow: a chassis 1 % heavier
// makes as much of one as this allows to be between the models.
TEST(WheeledCarTest, DrivesLikeThreeBodiesOnTwoHinges) {
  const WheeledCarParams params = WheeledCarParams::ScaledTo({});
  WheeledCar car(params, kStep, 0);
  HingedCar hinged(params, kStep, 0);
  const Apart gentle = DriveBeside(car, hinged, 0.3, 0.5);
  EXPECT_LE(gentle.speed, 0.01);
  EXPECT_LE(gentle.yaw_rate, 0.06);
  EXPECT_NEAR(gentle.error, gentle.other_error, 0.001);
  const Apart wild = DriveBeside(car, hinged, 1, 2);
  EXPECT_LE(wild.speed, 0.035);
  EXPECT_LE(wild.yaw_rate, 0.35);
  EXPECT_NEAR(wild.error, wild.other_error, 0.001);
  const Apart turning = DriveBeside(car, hinged, 0, 2);
  EXPECT_LE(turning.yaw_rate, 0.002);
}

TEST(WheeledCarTest, LimitsTheMotorsSpeed) {
  WheeledCar car = MakeCar();
  Reset(car);
  car.Command({100, 0});
  Drive(car, 3);
  EXPECT_NEAR(car.wheel_speed(0), 1.5 * (1 + 0.5 * 0.046 * 2) / 0.0125, 0.5);
}

// Other sizes keep the proportions, so they stand, drive and turn as stably.
TEST(WheeledCarTest, OtherSizesDriveAsStably) {
  for (const auto& [length, width] : {std::pair{0.035, 0.025}, {0.10, 0.05}, {0.05, 0.06}, {0.5, 0.4}, {2.0, 1.4}}) {
    SCOPED_TRACE(length);
    VehicleConfig config;
    config.length = length;
    config.width = width;
    WheeledCar car = MakeCar(config);
    Reset(car);
    const double height = car.params().chassis_height;
    car.Command({0.5, 0});
    Drive(car, 2);
    double squares = 0, worst_height = 0;
    for (int i = 0; i < 240; ++i) {
      car.Step();
      squares += std::pow(car.motion().vx - 0.5, 2);
      worst_height = std::max(worst_height, std::abs(car.chassis_height() - height));
    }
    EXPECT_LE(std::sqrt(squares / 240), 0.005);
    EXPECT_LE(worst_height, 0.03 * height);
    car.Command({0.3, 1.0});
    Drive(car, 2);
    EXPECT_NEAR(car.motion().vx, 0.3, 0.01);
    EXPECT_NEAR(car.motion().yaw_rate, 1.0, 0.02);
  }
}

TEST(WheeledCarTest, SavesAndLoadsBitForBitInMidEpisode) {
  WheeledCar car = MakeCar({}, 0.2);
  Reset(car, {0, 0, 0.7});
  car.Command({1.0, 1.5});
  Drive(car, 0.3);
  const std::string blob = car.Save();
  const auto drive_on = [](WheeledCar& c) {
    c.Step();
    c.Command({0.2, -2});
    Drive(c, 1);
    return c.Save();
  };
  const std::string expected = drive_on(car);
  WheeledCar other = MakeCar({}, 0.2);
  Reset(other, {0, 0, -2});
  other.Command({0.3, 0.3});
  Drive(other, 0.2);
  other.Load(blob);
  EXPECT_EQ(other.Save(), blob);
  EXPECT_EQ(drive_on(other), expected);
  car.Load(blob);
  EXPECT_EQ(drive_on(car), expected);
}

TEST(WheeledCarTest, RefusesATornBlob) {
  WheeledCar car = MakeCar();
  Reset(car);
  const std::string blob = car.Save();
  EXPECT_THROW(car.Load(blob.substr(0, blob.size() - 1)), Error);
  EXPECT_THROW(car.Load(blob + "x"), Error);
  EXPECT_THROW(car.Load(""), Error);
}

TEST(WheeledCarTest, ResetForgetsThePast) {
  WheeledCar used = MakeCar({}, 0.3), fresh = MakeCar({}, 0.3);
  RandomStream first(1, RandomPurpose::kParameters, 3);
  used.Reset({1, 2, 3}, first);
  used.Command({1, 2});
  Drive(used, 0.7);
  for (WheeledCar* car : {&used, &fresh}) {
    Reset(*car, {0, 0, 0.1});
    car->Command({0.8, -1});
    Drive(*car, 0.5);
  }
  EXPECT_EQ(used.Save(), fresh.Save());
}

// A slippery floor: friction 1 ± spread changes the first acceleration, which is μ times the wheels' load.
TEST(WheeledCarTest, ParameterSpreadChangesTheDynamics) {
  WheeledCar car = MakeCar({}, 0.5);
  std::vector<double> speeds;
  for (uint32_t episode = 0; episode < 8; ++episode) {
    RandomStream random(1, RandomPurpose::kParameters, 0, episode);
    car.Reset({0, 0, 0}, random);
    car.Command({1, 0});
    Drive(car, 0.05);
    speeds.push_back(car.motion().vx);
  }
  std::sort(speeds.begin(), speeds.end());
  EXPECT_GT(speeds.back() - speeds.front(), 0.05);
}

}  // namespace
}  // namespace cairn::actors
