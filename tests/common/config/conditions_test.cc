#include "common/config/conditions.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "common/config/load.h"
#include "common/core/check.h"

namespace cairn {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

std::string Write(const std::string& text) {
  const std::string path = testing::TempDir() + "conditions_test.textproto";
  std::ofstream(path) << text;
  return path;
}

std::string ErrorOf(const std::string& text) {
  try {
    LoadConditions(Write(text), 1);
  } catch (const UsageError& error) {
    return error.what();
  }
  return "";
}

TEST(ConditionsTest, LengthsInRadiiBecomeMetres) {
  const Conditions conditions = LoadConditions(Write(R"(
    trials: 20 set: "safety.margin=2R"
    knob { name: "Noise" unit: "R"
      point { value: 0 }
      point { value: 3 set: "observation.pose_noise=0.5R" set: "environment.slip=0.25" } })"),
                                               0.04);
  EXPECT_EQ(conditions.trials, 20);
  EXPECT_THAT(conditions.overrides, ElementsAre("safety.margin=0.08"));
  ASSERT_EQ(conditions.knobs.size(), 1u);
  const Knob& knob = conditions.knobs[0];
  EXPECT_EQ(knob.name, "Noise");
  EXPECT_EQ(knob.unit, "R");
  ASSERT_EQ(knob.points.size(), 2u);
  EXPECT_TRUE(knob.points[0].overrides.empty());
  EXPECT_EQ(knob.points[1].value, 3);
  EXPECT_THAT(knob.points[1].overrides, ElementsAre("observation.pose_noise=0.02", "environment.slip=0.25"));
}

TEST(ConditionsTest, WhatIsWrongIsNamed) {
  EXPECT_THAT(ErrorOf("trials: 0 knob { name: \"a\" point { value: 0 } }"), HasSubstr("trials = 0; it must be in"));
  EXPECT_THAT(ErrorOf("trials: 5"), HasSubstr("no knob"));
  EXPECT_THAT(ErrorOf("knob { name: \"a\" }"), HasSubstr("knob \"a\": it needs a name and at least one point"));
  EXPECT_THAT(ErrorOf("knob { name: \"a\" point { set: \"environment.slip=0.1\" } }"), HasSubstr("finite value"));
  EXPECT_THAT(ErrorOf("\nknobs { }"), testing::AllOf(HasSubstr(":2:"), HasSubstr("knobs")));
  EXPECT_THROW(LoadConditions("/nonexistent.textproto", 1), UsageError);
}

TEST(ConditionsTest, EveryPointOfTheShippedPageIsAnExperiment) {
  const std::string deploy = CAIRN_SOURCE_DIR "/deploy/";
  for (const char* name : {"car_maze", "quadrotor_maze"}) {
    const std::string file = deploy + "experiments/" + name + ".textproto";
    const double radius = LoadExperiment(file).experiment.vehicle.circumscribed_radius();
    const Conditions conditions = LoadConditions(deploy + "conditions/stress.textproto", radius);
    EXPECT_GE(conditions.trials, 1000);
    for (const Knob& knob : conditions.knobs) {
      for (const ConditionPoint& point : knob.points)
        EXPECT_NO_THROW(LoadExperiment(file, point.overrides)) << knob.name;
    }
  }
}

}  // namespace
}  // namespace cairn
