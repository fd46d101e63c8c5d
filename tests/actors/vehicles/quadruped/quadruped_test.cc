#include "actors/vehicles/quadruped/quadruped.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/actors/vehicles/drive.h"

namespace cairn::actors {
namespace {

constexpr double kRate = 120;
constexpr double kStep = 1 / kRate;

VehicleConfig Config(double scale) {
  VehicleConfig config;
  config.kind = VehicleConfig::Kind::kQuadruped;
  config.length = 0.10 * scale;
  config.width = 0.05 * scale;
  config.max_speed = 0.3;
  return config;
}

Quadruped MakeQuadruped(double scale = 0.6, double spread = 0) {
  return Quadruped(QuadrupedParams::ScaledTo(Config(scale)), kStep, spread);
}

// At rest the feet carry (0.29 + 4 (0.012 + 0.008)) kg · 9.81 m/s² = 3.630 N. A foot under F gives by the surface layer
// of 0.1 mm and soft_cfm · F · step / soft_erp = 0.03 · 0.907 / 120 / 0.4 m = 0.567 mm, so the trunk stands at 61.33
// mm. Thighs and shanks (80 g) have their middles 20 mm · √(1 − 0.7²) = 14.3 mm behind the hips: the hind feet carry
// 0.08 · 9.81 · 0.0143 / 0.08 N = 0.140 N more than the front feet, each.
TEST(QuadrupedTest, StandsOnItsWeightAtTheHeightOfItsLegs) {
  Quadruped quadruped = MakeQuadruped(1.0);
  std::array<dJointFeedback, 4> contacts{};
  quadruped.MeasureContacts(&contacts);
  Reset(quadruped, {0.1, 0.2, 0.3});
  Advance(quadruped, 600);
  double force = 0;
  for (int leg = 0; leg < 4; ++leg) {
    EXPECT_NEAR(contacts[leg].f1[2], 0.9074 + (leg < 2 ? -0.070 : 0.070), 0.003);
    force += contacts[leg].f1[2];
  }
  EXPECT_NEAR(force, 3.6297, 1e-3);
  EXPECT_NEAR(quadruped.height(), 0.06133, 5e-5);
  EXPECT_GT(quadruped.uprightness(), 0.9999);
  EXPECT_NEAR(quadruped.motion().x, 0.1, 1e-3);
  EXPECT_NEAR(quadruped.motion().y, 0.2, 1e-3);
  EXPECT_NEAR(quadruped.motion().yaw, 0.3, 1e-3);
  EXPECT_FALSE(quadruped.fallen());
}

// Equal links of 40 mm and a foot 56 mm under the hip: the knee's inner half-angle has cosine 28/40, so the hip turns
// by acos 0.7 and the knee by −2 acos 0.7.
TEST(QuadrupedTest, JointsStandWhereTheKinematicsSay) {
  Quadruped quadruped = MakeQuadruped(1.0);
  Reset(quadruped);
  for (int leg = 0; leg < 4; ++leg) {
    EXPECT_NEAR(quadruped.angles(leg).abduction, 0, 1e-12);
    EXPECT_NEAR(quadruped.angles(leg).hip, std::acos(0.7), 1e-12);
    EXPECT_NEAR(quadruped.angles(leg).knee, -2 * std::acos(0.7), 1e-12);
  }
  Advance(quadruped, 600);
  for (int leg = 0; leg < 4; ++leg) EXPECT_NEAR(quadruped.angles(leg).hip, std::acos(0.7), 0.01);
}

// Feet that stand take the trunk along by v T in a cycle of T, whatever they do in the air.
TEST(QuadrupedTest, MovesBySpeedTimesPeriodInACycle) {
  for (const double scale : {0.6, 1.0}) {
    Quadruped quadruped = MakeQuadruped(scale);
    Reset(quadruped);
    quadruped.Command({0.2, 0});
    Advance(quadruped, 240);
    const double x = quadruped.motion().x;
    const double cycles = 40, period = quadruped.params().trot.period;
    Advance(quadruped, static_cast<int>(std::lround(cycles * period * kRate)));
    EXPECT_NEAR((quadruped.motion().x - x) / cycles, 0.2 * period, 0.05 * 0.2 * period) << scale;
    EXPECT_NEAR(quadruped.motion().y, 0, 0.05) << scale;
  }
}

TEST(QuadrupedTest, TurnsByYawRateTimesTimeWhereItStands) {
  Quadruped quadruped = MakeQuadruped();
  Reset(quadruped);
  quadruped.Command({0, 1});
  Advance(quadruped, 240);
  EXPECT_NEAR(quadruped.motion().yaw, 2, 0.15);
  EXPECT_LT(std::hypot(quadruped.motion().x, quadruped.motion().y), 0.01);
}

TEST(QuadrupedTest, StopsOnAllFeetWhenToldToRest) {
  Quadruped quadruped = MakeQuadruped();
  std::array<dJointFeedback, 4> contacts{};
  quadruped.MeasureContacts(&contacts);
  Reset(quadruped);
  quadruped.Command({0.4, 0});
  Advance(quadruped, 121);
  const double x = quadruped.motion().x;
  quadruped.Command({0, 0});
  Advance(quadruped, 120);
  EXPECT_NEAR(quadruped.motion().vx, 0, 1e-3);
  EXPECT_NEAR(quadruped.motion().x - x, 0, 0.05);
  for (const dJointFeedback& contact : contacts) EXPECT_GT(contact.f1[2], 0);
}

struct Tracking {
  double t90 = 0, overshoot = 0, rmse = 0, mean = 0;
};

// Step of one command at t = 0. Rise and overshoot of the mean over the last cycle, since the trunk swings within each;
// error of every physics step from 1 s on.
Tracking MeasureTracking(const VehicleCommand& command, double Motion::*value, double target) {
  Quadruped quadruped = MakeQuadruped();
  Reset(quadruped);
  Advance(quadruped, 60);
  quadruped.Command(command);
  const int cycle = static_cast<int>(std::lround(quadruped.params().trot.period * kRate));
  std::vector<double> values;
  Tracking tracking;
  for (int i = 1; i <= 600; ++i) {
    quadruped.Step();
    values.push_back(quadruped.motion().*value / target);
    double mean = 0;
    for (int k = std::max(0, i - cycle); k < i; ++k) mean += values[k] / cycle;
    if (tracking.t90 == 0 && mean >= 0.9) tracking.t90 = i * kStep;
    tracking.overshoot = std::max(tracking.overshoot, mean - 1);
    if (i <= 120) continue;
    tracking.mean += target * values.back() / 480;
    tracking.rmse += std::pow(target * (values.back() - 1), 2) / 480;
  }
  tracking.rmse = std::sqrt(tracking.rmse);
  return tracking;
}

// The figures of the tracking table in docs/adding_a_vehicle.md.
TEST(QuadrupedTest, TracksAsTheTableSays) {
  const Tracking v = MeasureTracking({0.3, 0}, &Motion::vx, 0.3), w = MeasureTracking({0, 2}, &Motion::yaw_rate, 2);
  RecordProperty("speed_t90_ms", static_cast<int>(1000 * v.t90));
  RecordProperty("speed_rmse_mm_s", static_cast<int>(1000 * v.rmse));
  RecordProperty("yaw_rate_t90_ms", static_cast<int>(1000 * w.t90));
  RecordProperty("yaw_rate_rmse_mrad_s", static_cast<int>(1000 * w.rmse));
  EXPECT_NEAR(v.t90, 0.21, 0.04);
  EXPECT_LT(v.overshoot, 0.04);
  EXPECT_NEAR(w.t90, 0.35, 0.1);
  EXPECT_LT(w.overshoot, 0.04);
  EXPECT_NEAR(v.mean, 0.3, 0.015);
  EXPECT_LT(v.rmse, 0.03);
  EXPECT_NEAR(w.mean, 2, 0.1);
  EXPECT_LT(w.rmse, 0.4);
}

TEST(QuadrupedTest, SurvivesRandomCommandsForALongTime) {
  for (const double scale : {0.5, 1.0}) {
    Quadruped quadruped = MakeQuadruped(scale, 0.2);
    RandomStream random(3, RandomPurpose::kTest);
    Reset(quadruped);
    for (int i = 0; i < 50000; ++i) {
      if (i % 12 == 0) quadruped.Command({random.Uniform(-0.45, 0.45), random.Uniform(-3, 3)});
      quadruped.Step();
      ASSERT_FALSE(quadruped.fallen()) << "scale " << scale << ", step " << i;
      const Motion m = quadruped.motion();
      ASSERT_LT(std::hypot(m.vx, m.vy), 2) << i;
    }
  }
}

TEST(QuadrupedTest, SavesAndLoadsBitForBitInMidEpisode) {
  Quadruped one = MakeQuadruped(0.6, 0.3), other = MakeQuadruped(0.6, 0.3);
  Reset(one, {1, 2, 3});
  one.Command({0.3, 0.5});
  Advance(one, 77);
  const std::string blob = one.Save();
  RandomStream random(9, RandomPurpose::kParameters);
  other.Reset({0, 0, 0}, random);
  other.Command({-0.1, 1});
  Advance(other, 10);
  other.Load(blob);
  for (Quadruped* q : {&one, &other}) {
    Advance(*q, 10);
    q->Command({0.1, -2});
    Advance(*q, 200);
  }
  EXPECT_EQ(one.Save(), other.Save());
}

TEST(QuadrupedTest, SpreadDrawsOtherRobotsThatWalkAllTheSame) {
  Quadruped one = MakeQuadruped(0.6, 0.3), other = MakeQuadruped(0.6, 0.3);
  RandomStream random(9, RandomPurpose::kParameters);
  Reset(one);
  other.Reset({}, random);
  for (Quadruped* q : {&one, &other}) {
    q->Command({0.3, 0});
    Advance(*q, 480);
    EXPECT_NEAR(q->motion().x, 1.2, 0.1);
    EXPECT_FALSE(q->fallen());
  }
  EXPECT_NE(one.motion().x, other.motion().x);
}

// Trotting rocks the trunk by more than a thousandth of a radian.
TEST(QuadrupedTest, SaysThatItHasFallen) {
  QuadrupedParams params = QuadrupedParams::ScaledTo(Config(0.6));
  params.max_tilt = 1e-3;
  Quadruped quadruped(params, kStep, 0);
  Reset(quadruped);
  EXPECT_FALSE(quadruped.fallen());
  quadruped.Command({0.4, 0});
  bool fallen = false;
  for (int i = 0; i < 120; ++i) {
    quadruped.Step();
    fallen = fallen || quadruped.fallen();
  }
  EXPECT_TRUE(fallen);
}

}  // namespace
}  // namespace cairn::actors
