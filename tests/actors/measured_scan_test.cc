#include "actors/measured_scan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "actors/observation.h"

namespace cairn::actors {
namespace {

constexpr double kPi = std::numbers::pi;

VehicleConfig Car(int beams, double field_of_view = 2 * kPi) {
  VehicleConfig vehicle;
  vehicle.scan.beams = beams;
  vehicle.scan.field_of_view = field_of_view;
  vehicle.scan.range = 5;
  return vehicle;
}

Vector3d At(double angle) { return {std::cos(angle), std::sin(angle), 0}; }

TEST(MeasuredScanTest, TheNearestBeamAnswersAllAroundTheCircle) {
  MeasuredScan scan(Car(4));
  ASSERT_EQ(scan.Set({}, -kPi, kPi / 4, std::vector<float>{1.8f, 1.1f, 1.2f, 1.3f, 1.4f, 1.5f, 1.6f, 1.7f}), "");
  EXPECT_FLOAT_EQ(scan.Range(Vector3d::Zero(), At(0), 5), 1.4f);
  EXPECT_FLOAT_EQ(scan.Range(Vector3d::Zero(), At(kPi / 4 + 0.39), 5), 1.5f);
  EXPECT_FLOAT_EQ(scan.Range(Vector3d::Zero(), At(kPi / 4 + 0.4), 5), 1.6f);
  EXPECT_FLOAT_EQ(scan.Range(Vector3d::Zero(), At(kPi - 0.3), 5), 1.8f) << "beyond the last beam the first one follows";
  EXPECT_FLOAT_EQ(scan.Range(Vector3d::Zero(), At(-kPi + 0.3), 5), 1.8f);
  EXPECT_EQ(scan.Range(Vector3d::Zero(), At(0), 1), 1) << "no farther than asked for";
}

TEST(MeasuredScanTest, BeamsTurnWithTheVehicle) {
  MeasuredScan scan(Car(4));
  Motion motion;
  motion.yaw = kPi / 2;
  ASSERT_EQ(scan.Set(motion, 0, kPi / 2, std::vector<float>{1, 2, 3, 4}), "");
  EXPECT_EQ(scan.Range(Vector3d::Zero(), At(kPi / 2), 5), 1);
  EXPECT_EQ(scan.Range(Vector3d::Zero(), At(0), 5), 4);
}

// A square room of 2 m around the sensor, which stands 0.2 m ahead of the centre.
TEST(MeasuredScanTest, FromElsewhereItsOutlineAnswers) {
  VehicleConfig vehicle = Car(4);
  vehicle.length = 0.6;
  vehicle.scan.mount_x = 0.2;
  MeasuredScan scan(vehicle);
  std::vector<float> ranges;
  for (int i = 0; i < 360; ++i) {
    const double a = i * kPi / 180;
    ranges.push_back(static_cast<float>(1 / std::max(std::abs(std::cos(a)), std::abs(std::sin(a)))));
  }
  ASSERT_EQ(scan.Set({}, 0, kPi / 180, ranges), "");
  EXPECT_FLOAT_EQ(scan.nearest(), 1);
  EXPECT_NEAR(scan.Range({0, 0, 0}, At(0), 5), 1.2, 1e-6);
  EXPECT_NEAR(scan.Range({0, 0, 0}, At(kPi), 5), 0.8, 1e-6);
  EXPECT_NEAR(scan.Range({0, 0, 0}, At(kPi / 2), 5), 1, 1e-6);
  EXPECT_NEAR(scan.Range({0.2, 0, 0}, At(0), 5), 1, 1e-6) << "the sensor's own beam";
  EXPECT_EQ(scan.Range({0, 0, 0}, At(0), 0.5), 0.5);
}

TEST(MeasuredScanTest, WhatIsNoRangeIsNothingSeen) {
  MeasuredScan scan(Car(4));
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  ASSERT_EQ(scan.Set({}, 0, kPi / 2, std::vector<float>{nan, inf, 0, -1}), "");
  for (int i = 0; i < 4; ++i) EXPECT_EQ(scan.Range(Vector3d::Zero(), At(i * kPi / 2), 5), 5) << i;
}

TEST(MeasuredScanTest, APartOfTheCircleServesBeamsWithinIt) {
  MeasuredScan scan(Car(5, kPi));                                     // −90° to 90°
  ASSERT_EQ(scan.Set({}, -2, 0.5, std::vector<float>(9, 1.0f)), "");  // −2 to 2 rad
  EXPECT_EQ(scan.Range(Vector3d::Zero(), At(-kPi / 2), 5), 1);
  EXPECT_EQ(scan.Range(Vector3d::Zero(), At(kPi), 5), 5) << "not seen";
  EXPECT_THAT(scan.Set({}, -1, 0.5, std::vector<float>(5, 1.0f)),
              ::testing::HasSubstr("cover -1.000 to 1.000 rad; beam 0 of vehicle.scan looks at -1.571 rad"));
  EXPECT_EQ(scan.Range(Vector3d::Zero(), At(kPi / 2), 5), 1) << "the last sound scan stays";
}

TEST(MeasuredScanTest, UnsoundScansAreNamed) {
  MeasuredScan scan(Car(4));
  using ::testing::HasSubstr;
  EXPECT_THAT(scan.Set({}, 0, kPi / 2, {}), HasSubstr("num_ranges is 0"));
  EXPECT_THAT(scan.Set({}, 0, 0, std::vector<float>(4, 1.0f)), HasSubstr("angle_step is 0"));
  EXPECT_THAT(scan.Set({}, 0, -1, std::vector<float>(4, 1.0f)), HasSubstr("angle_step is -1"));
  EXPECT_THAT(scan.Set({}, NAN, 1, std::vector<float>(4, 1.0f)), HasSubstr("angle_min is nan"));
  EXPECT_THAT(scan.Set({}, 0, NAN, std::vector<float>(4, 1.0f)), HasSubstr("angle_step is nan"));
}

TEST(MeasuredScanTest, InSpaceItsBeamsAreThoseOfTheExperiment) {
  VehicleConfig vehicle;
  vehicle.kind = VehicleConfig::Kind::kQuadrotor;
  vehicle.scan.beams = 14;
  MeasuredScan scan(vehicle);
  std::vector<float> ranges;
  for (int i = 0; i < 14; ++i) ranges.push_back(static_cast<float>(1 + i));
  ASSERT_EQ(scan.Set({}, NAN, NAN, ranges), "");
  const std::vector<Vector3d> beams = BeamDirections(vehicle.scan, 3);
  for (size_t i = 0; i < beams.size(); ++i) EXPECT_EQ(scan.Range(Vector3d::Zero(), beams[i], 100), ranges[i]) << i;
  ranges.pop_back();
  EXPECT_THAT(scan.Set({}, 0, 1, ranges), ::testing::HasSubstr("num_ranges is 13; vehicle.scan has 14 beams"));
}

}  // namespace
}  // namespace cairn::actors
