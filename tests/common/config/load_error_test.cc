#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/config/load.h"
#include "common/core/check.h"

namespace cairn {
namespace {

using testing::AllOf;
using testing::HasSubstr;

std::string ErrorOf(const std::string& text, const std::vector<std::string>& overrides = {}) {
  try {
    ParseExperiment(text, "car.textproto", overrides);
  } catch (const UsageError& error) {
    return error.what();
  }
  return "no error";
}

TEST(LoadErrorTest, UnknownKeyNamesFileLineKeyAndNearest) {
  EXPECT_EQ(ErrorOf("seed: 1\nlearner {\n  batchsize: 3\n}\n"),
            "car.textproto:3: learner.batchsize: unknown key; the nearest known one is learner.batch_size");
  EXPECT_EQ(ErrorOf("sed: 1\n"), "car.textproto:1: sed: unknown key; the nearest known one is seed");
}

TEST(LoadErrorTest, UrlOfABroker) {
  EXPECT_EQ(
      ErrorOf("transport {\n  url: \"tcpq://host\"\n}\n"),
      "car.textproto:2: transport.url = \"tcpq://host\": the port is missing; it must be tcpq://HOST:PORT of an LCM "
      "broker");
  EXPECT_THAT(ErrorOf("", {"transport.url=udpm://239.1.2.3:7700"}),
              HasSubstr("it does not begin with tcpq://; it must be tcpq://HOST:PORT"));
  EXPECT_THAT(ErrorOf("", {"transport.telemetry_url=tcpq://localhost:7701"}),
              HasSubstr("transport.telemetry_url = \"tcpq://localhost:7701\" goes with transport.url only"));
}

TEST(LoadErrorTest, KeyInTheWrongBlockIsFoundInItsOwn) {
  EXPECT_THAT(ErrorOf("batch_size: 3"), HasSubstr("the nearest known one is learner.batch_size"));
}

TEST(LoadErrorTest, UnknownBlock) {
  EXPECT_EQ(ErrorOf("lerner { batch_size: 3 }"),
            "car.textproto:1: lerner: unknown key; the nearest known one is learner");
}

TEST(LoadErrorTest, WrongTypeNamesFieldValueAndRule) {
  EXPECT_EQ(ErrorOf("\nlearner { batch_size: many }"),
            "car.textproto:2: learner.batch_size: expected integer, got: many; "
            "it must be a whole number in [1, 1048576]");
  EXPECT_THAT(ErrorOf("total_env_steps: 1e6"), AllOf(HasSubstr("total_env_steps"), HasSubstr("1e6"),
                                                     HasSubstr("whole number in [1, 1000000000000] transitions")));
  EXPECT_THAT(ErrorOf("learner { auto_alpha: maybe }"), AllOf(HasSubstr("maybe"), HasSubstr("true or false")));
  EXPECT_THAT(ErrorOf("name: 3"), AllOf(HasSubstr("car.textproto:1: name: "), HasSubstr("text in quotes")));
  EXPECT_THAT(ErrorOf("learner: 3"), HasSubstr("learner"));
}

TEST(LoadErrorTest, EnumListsItsValues) {
  EXPECT_THAT(ErrorOf("schedule: SYNC"),
              AllOf(HasSubstr("car.textproto:1: schedule"), HasSubstr("SYNC"), HasSubstr("LOCKSTEP, ASYNC")));
  EXPECT_THAT(ErrorOf("", {"learner.algorithm=PPO"}), AllOf(HasSubstr("PPO"), HasSubstr("SAC, TD3")));
}

TEST(LoadErrorTest, OutOfRangeNamesLineValueAndRange) {
  EXPECT_EQ(ErrorOf("num_vehicles: 0"), "car.textproto:1: num_vehicles = 0; it must be a whole number in [1, 65536]");
  EXPECT_EQ(ErrorOf("vehicle {\n  max_speed: -1\n}"),
            "car.textproto:2: vehicle.max_speed = -1; it must be a finite number in (0, 100] m/s");
  EXPECT_THAT(ErrorOf("environment { parameter_spread: 1 }"), HasSubstr("in [0, 1)"));
  EXPECT_THAT(ErrorOf("learner { net_arch: [64, 0] }"), HasSubstr("car.textproto:1: learner.net_arch[1] = 0"));
  EXPECT_THAT(ErrorOf("num_vehicles: 3000000000"), HasSubstr("num_vehicles"));
}

TEST(LoadErrorTest, NotANumberAndInfinityAreRefused) {
  EXPECT_THAT(ErrorOf("learner { gamma: nan }"), AllOf(HasSubstr("learner.gamma = nan"), HasSubstr("finite number")));
  EXPECT_THAT(ErrorOf("vehicle { length: inf }"), HasSubstr("vehicle.length = inf"));
  EXPECT_THAT(ErrorOf("reward { goal_reward: -inf }"), HasSubstr("reward.goal_reward = -inf"));
  EXPECT_THAT(ErrorOf("world { kind: BOXES goal { min { x: nan } } }"), HasSubstr("world.goal.min.x = nan"));
}

TEST(LoadErrorTest, OverrideIsNamed) {
  EXPECT_EQ(ErrorOf("", {"learner.batch_size=0"}),
            "--set learner.batch_size=0: learner.batch_size = 0; it must be a whole number in [1, 1048576]");
  EXPECT_EQ(ErrorOf("", {"learner.batchsize=5"}),
            "--set learner.batchsize=5: learner.batchsize: unknown key; the nearest known one is learner.batch_size");
  EXPECT_THAT(ErrorOf("", {"learner.batch_size"}), HasSubstr("write it as key=value"));
  EXPECT_THAT(ErrorOf("", {"learner.batch_size="}), HasSubstr("--set learner.batch_size=: learner.batch_size"));
  EXPECT_THAT(ErrorOf("", {"=3"}), HasSubstr("--set =3"));
  EXPECT_THAT(ErrorOf("", {"learner.batch_size=5 gamma: 0.5"}), HasSubstr("one value"));
  EXPECT_THAT(ErrorOf("", {"world.obstacles.min.x=1"}), HasSubstr("world.obstacles is a list"));
  EXPECT_THAT(ErrorOf("", {"learner.net_arch=[64,x]"}), HasSubstr("learner.net_arch"));
}

TEST(LoadErrorTest, BrokenTextNamesTheLine) {
  EXPECT_THAT(ErrorOf("seed: 1\nlearner { batch_size: 3\n"), HasSubstr("car.textproto:3"));
  EXPECT_THAT(ErrorOf("learner { batch_size 3 }"), HasSubstr("car.textproto:1: learner.batch_size"));
  EXPECT_THAT(ErrorOf("seed: 1 seed: 2"), HasSubstr("car.textproto:1: seed"));
  EXPECT_THAT(ErrorOf("\x01\xff"), HasSubstr("car.textproto:1"));
}

TEST(LoadErrorTest, MissingFileAndDirectory) {
  EXPECT_THROW(LoadExperiment("/nonexistent/car.textproto"), UsageError);
  try {
    LoadExperiment("/nonexistent/car.textproto");
  } catch (const UsageError& error) {
    EXPECT_STREQ(error.what(), "experiment file /nonexistent/car.textproto: No such file or directory");
  }
  EXPECT_THROW(LoadExperiment("/"), UsageError);
}

struct RuleCase {
  std::string text;
  std::vector<std::string> words;
};

TEST(LoadErrorTest, RulesBetweenFieldsNameBothAndTheirOrigins) {
  const std::vector<RuleCase> cases{
      {"vehicle { min_speed: 1.5 }", {"vehicle.min_speed = 1.5 (car.textproto:1)", "vehicle.max_speed = 1 (default)"}},
      {"environment { control_period: 0.03 }", {"environment.control_period = 0.03", "240", "nearest is 0.029"}},
      {"learner { batch_size: 200 buffer_size: 100 }", {"learner.batch_size = 200", "learner.buffer_size = 100"}},
      {"learner { learning_starts: 600000 }", {"learner.learning_starts = 600000", "learner.buffer_size"}},
      {"planner { eta: 0.1 min_spacing: 0.06 }", {"planner.min_spacing = 0.06", "r_ball"}},
      {"planner { grid_neighbors: 6 }", {"planner.grid_neighbors = 6", "4 (along the axes) or 8"}},
      {"planner { kind: PRMSTAR }", {"planner.kind", "PRM_STAR"}},
      {"goals: ANY observation { position: false } planner { kind: RRT }",
       {"planner.kind = RRT (car.textproto:1): does not go with goals = ANY (car.textproto:1)"}},
      {"goals: ANY observation { position: false } planner { kind: RRT_STAR }", {"planner.kind = RRT_STAR"}},
      {"planner { roadmap: \"none.roadmap\" }", {"planner.roadmap: ", "none.roadmap: no such file"}},
      {"planner { roadmap_hash: \"12\" }", {"planner.roadmap_hash is read only with planner.roadmap"}},
      {"observation { look_ahead_near: 0.4 }", {"observation.look_ahead_near = 0.4", "look_ahead_far"}},
      {"observation { heading: false velocity: false d_min: false look_ahead: false rays: false }", {"switched off"}},
      {"vehicle { scan { mount_x: 0.05 } }", {"vehicle.scan.mount_x = 0.05", "vehicle.length"}},
      {"transport { group: \"10.0.0.1\" }", {"transport.group = \"10.0.0.1\"", "multicast"}},
      {"vehicle { kind: PLANE_CAR lag: 0 } safety { filter: ALWAYS stopping_distance: 0.1 }",
       {"safety.stopping_distance = 0.1", "stands still at once", "vehicle.lag = 0"}},
      {"name: \"../x\"", {"name = \"../x\""}},
      {"name: \"\"", {"name = \"\""}},
      {"world { kind: BOXES }", {"world.bounds is missing"}},
      {"world { obstacles { } }", {"world.obstacles", "BOXES"}},
  };
  for (const RuleCase& rule : cases) {
    const std::string error = ErrorOf(rule.text);
    for (const std::string& word : rule.words) EXPECT_THAT(error, HasSubstr(word)) << rule.text;
    EXPECT_EQ(error.find('\n'), std::string::npos) << error;
  }
}

TEST(LoadErrorTest, ControlPeriodsOfWholePhysicsStepsPass) {
  for (const char* period : {"0.1", "0.05", "0.2", "0.0041666666666666667"}) {
    EXPECT_EQ(ErrorOf(std::string("environment { control_period: ") + period + " }"), "no error") << period;
  }
}

}  // namespace
}  // namespace cairn
