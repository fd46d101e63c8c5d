#include "actors/command.h"

#include <gtest/gtest.h>

namespace cairn::actors {
namespace {

void ExpectNear(const VehicleCommand& actual, const VehicleCommand& expected) {
  for (int i = 0; i < kMaxActionSize; ++i) EXPECT_NEAR(actual[i], expected[i], 1e-12) << i;
}

VehicleConfig Quadrotor() {
  VehicleConfig vehicle;
  vehicle.kind = VehicleConfig::Kind::kQuadrotor;
  vehicle.min_speed = -1.5;
  vehicle.max_speed = 1.5;
  return vehicle;
}

TEST(CommandTest, ActionsSpanTheRangeOfEachCommand) {
  VehicleConfig car;
  car.min_speed = -0.2;
  const float low[2] = {-1, -1}, high[2] = {1, 1}, middle[2] = {0, 0.5f}, outside[2] = {7, -7};
  ExpectNear(ToCommand(car, low), {-0.2, -2, 0});
  ExpectNear(ToCommand(car, high), {1, 2, 0});
  ExpectNear(ToCommand(car, middle), {0.4, 1, 0});
  ExpectNear(ToCommand(car, outside), {1, -2, 0});
}

TEST(CommandTest, TheThirdCommandBelongsToWhatMovesAlongAxes) {
  const float action[3] = {1, -1, 0.5f};
  ExpectNear(ToCommand(Quadrotor(), action), {1.5, -1.5, 0.75});
  VehicleConfig base = Quadrotor();
  base.kind = VehicleConfig::Kind::kHolonomic;
  ExpectNear(ToCommand(base, action), {1.5, -1.5, 1});
}

TEST(CommandTest, AnAckermannCarSteers) {
  VehicleConfig car;
  car.kind = VehicleConfig::Kind::kAckermann;
  const float action[2] = {1, -1};
  ExpectNear(ToCommand(car, action), {1, -0.6, 0});
}

// Half of the range squared is a quarter of it, on both sides.
TEST(CommandTest, TheExponentMakesSmallCommandsFiner) {
  VehicleConfig vehicle = Quadrotor();
  vehicle.command_exponent = 2;
  const float action[3] = {0.5f, -0.5f, -1};
  ExpectNear(ToCommand(vehicle, action), {0.375, -0.375, -1.5});
}

TEST(CommandTest, ToActionInvertsToCommand) {
  for (const double exponent : {1.0, 2.0}) {
    VehicleConfig vehicle = Quadrotor();
    vehicle.command_exponent = exponent;
    const float action[3] = {0.3f, -0.8f, 0};
    float back[3];
    ToAction(vehicle, ToCommand(vehicle, action), back);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(back[i], action[i], 1e-6);
    ToAction(vehicle, {99, -99, 0}, back);
    EXPECT_EQ(back[0], 1);
    EXPECT_EQ(back[1], -1);
  }
}

TEST(CommandTest, RestIsTheCommandNearestToStandingStill) {
  VehicleConfig car;
  car.min_speed = 0.1;
  EXPECT_EQ(RestCommand(car), (VehicleCommand{0.1, 0, 0}));
  EXPECT_EQ(RestCommand(Quadrotor()), (VehicleCommand{0, 0, 0}));
}

}  // namespace
}  // namespace cairn::actors
