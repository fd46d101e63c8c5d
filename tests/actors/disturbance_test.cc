#include "actors/disturbance.h"

#include <gtest/gtest.h>

#include <cmath>

namespace cairn::actors {
namespace {

EnvironmentConfig Config() {
  EnvironmentConfig config;  // 0.1, 0.2 rad/s, held for 0.2 s = 48 physics steps
  return config;
}

TEST(HeldDisturbanceTest, ChangesEveryHoldOnly) {
  HeldDisturbance disturbance(Config(), VehicleConfig{});
  disturbance.Reset(RandomStream(1, RandomPurpose::kDisturbance));
  double last = -1;
  for (int64_t step = 0; step < 480; ++step) {
    EXPECT_EQ(disturbance.Advance(step), step % 48 == 0);
    const double speed = disturbance.Apply({1, 0})[0];
    if (step % 48 == 0) {
      EXPECT_NE(speed, last);
    } else {
      EXPECT_EQ(speed, last);
    }
    last = speed;
  }
}

// v (1 + 0.1 n), ω + 0.2 n': means v, ω and deviations 0.1 v, 0.2, within five standard errors of 20,000 draws.
TEST(HeldDisturbanceTest, HasTheStatedMoments) {
  HeldDisturbance disturbance(Config(), VehicleConfig{});
  disturbance.Reset(RandomStream(1, RandomPurpose::kDisturbance));
  const int n = 20000;
  double sum_v = 0, sum_w = 0, squares_v = 0, squares_w = 0, product = 0;
  for (int64_t i = 0; i < n; ++i) {
    disturbance.Advance(48 * i);
    const VehicleCommand command = disturbance.Apply({0.5, -1});
    const double v = command[0] - 0.5, w = command[1] + 1;
    sum_v += v, sum_w += w, squares_v += v * v, squares_w += w * w, product += v * w;
  }
  const double error = 5 / std::sqrt(n);
  EXPECT_NEAR(sum_v / n, 0, 0.05 * error);
  EXPECT_NEAR(sum_w / n, 0, 0.2 * error);
  EXPECT_NEAR(std::sqrt(squares_v / n), 0.05, 0.05 * error);
  EXPECT_NEAR(std::sqrt(squares_w / n), 0.2, 0.2 * error);
  EXPECT_NEAR(product / n, 0, 0.05 * 0.2 * error);
}

TEST(HeldDisturbanceTest, IsOffWhenBothGainsAreZero) {
  EnvironmentConfig config = Config();
  config.speed_disturbance = config.yaw_rate_disturbance = 0;
  HeldDisturbance disturbance(config, VehicleConfig{});
  disturbance.Reset(RandomStream(1, RandomPurpose::kDisturbance));
  EXPECT_FALSE(disturbance.Advance(0));
  EXPECT_EQ(disturbance.Apply({0.5, 1})[0], 0.5);
  EXPECT_EQ(disturbance.Apply({0.5, 1})[1], 1);
}

TEST(HeldDisturbanceTest, GoesOnAfterRead) {
  const RandomStream stream(1, RandomPurpose::kDisturbance, 3, 4);
  HeldDisturbance disturbance(Config(), VehicleConfig{});
  disturbance.Reset(stream);
  for (int64_t step = 0; step < 100; ++step) disturbance.Advance(step);
  BlobWriter writer;
  disturbance.Write(writer);
  const std::string blob = writer.Take();
  HeldDisturbance other(Config(), VehicleConfig{});
  other.Reset(stream);
  BlobReader reader(blob);
  other.Read(reader);
  for (int64_t step = 100; step < 400; ++step) {
    disturbance.Advance(step);
    other.Advance(step);
    EXPECT_EQ(disturbance.Apply({1, 0})[0], other.Apply({1, 0})[0]);
    EXPECT_EQ(disturbance.Apply({1, 0})[1], other.Apply({1, 0})[1]);
  }
}

}  // namespace
}  // namespace cairn::actors
