// Actors that come, go and hang while `cairn train` runs: real processes, the newcomers started by hand.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <map>
#include <memory>
#include <set>
#include <sstream>

#include "tests/integration/run_cairn.h"

namespace cairn::testing {
namespace {

using std::chrono::seconds;
using ::testing::HasSubstr;

// `vehicle` and `episode` at the start of an audit line.
std::pair<int, int> VehicleAndEpisode(const std::string& line) {
  std::istringstream words(line);
  std::pair<int, int> both;
  words >> both.first >> both.second;
  return both;
}

// A run without end, with two actors of its own; the parameter is its schedule.
class ElasticTest : public ::testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    std::filesystem::create_directories(Dir("audit"));
    train_ = std::make_unique<Program>(
        "cairn",
        SmallRun(Dir("run"), 100000000,
                 {"--actors", "2", "--set", std::string("schedule=") + GetParam(), "--set",
                  "lockstep.actor_timeout_s=1", "--set", "evaluation.interval_env_steps=100000000"}),
        Dir("train.log"), Audit());
    ASSERT_TRUE(WaitUntil(*train_, [this] {
      std::error_code error;
      return std::filesystem::file_size(Dir("run") / "episodes.csv", error) > 1000 && !error;
    })) << ReadFile(Dir("train.log"));
  }

  std::filesystem::path Dir(const std::string& name) const { return directory_.path() / name; }
  std::map<std::string, std::string> Audit() const { return {{"CAIRN_AUDIT_DIR", Dir("audit").string()}}; }

  // What is typed to help the run: actor 7.
  std::unique_ptr<Program> StartActor(const std::string& log) const {
    const nlohmann::json run = ReadJson(Dir("run") / "run.json");
    return std::make_unique<Program>(
        "cairn",
        std::vector<std::string>{"actor", (Dir("run") / "experiment.textproto").string(), "--lcm-url", run["lcm_url"],
                                 "--run-id", run["run_id"], "--actor-id", "7"},
        Dir(log), Audit());
  }

  size_t Joins() const {
    const std::string log = ReadFile(Dir("run") / "log" / "learner.log"), joined = "actor 7 joined";
    size_t count = 0;
    for (size_t at = log.find(joined); at != std::string::npos; at = log.find(joined, at + 1)) ++count;
    return count;
  }

  std::set<std::string> Lines(const std::string& prefix) const {
    const std::vector<std::string> lines = AuditLines(Dir("audit"), prefix);
    return {lines.begin(), lines.end()};
  }

  // Whether a line of the audit files with this prefix is among the learner's.
  bool InReplay(const std::string& prefix) const {
    const std::set<std::string> replay = Lines("learner"), made = Lines(prefix);
    return std::any_of(made.begin(), made.end(), [&](const std::string& line) { return replay.contains(line); });
  }

  void ExpectJoins(size_t times) const {
    ASSERT_TRUE(WaitUntil(
        *train_, [=, this] { return Joins() == times; }, seconds(20)))
        << ReadFile(Dir("run") / "log" / "learner.log");
  }

  // Replay has reached the files only up to their last full block, so the run has to go on a little.
  void ExpectReplayGrows() const {
    const size_t before = Lines("learner").size();
    EXPECT_TRUE(WaitUntil(
        *train_, [=, this] { return Lines("learner").size() > before + 1000; }, seconds(20)));
  }

  void StopTrain() {
    kill(train_->pid(), SIGTERM);
    ASSERT_TRUE(train_->WaitFor(seconds(10)));
    const nlohmann::json summary = ReadJson(Dir("run") / "summary.json");
    EXPECT_EQ(summary["transitions_lost"], 0);
    const std::vector<std::string> replay = AuditLines(Dir("audit"), "learner");
    EXPECT_EQ(Lines("learner").size(), replay.size()) << "a transition is in replay twice";
    EXPECT_EQ(static_cast<size_t>(summary["env_steps"]), replay.size());
    const std::set<std::string> made = Lines("actor"), kept = Lines("learner");
    EXPECT_TRUE(std::includes(made.begin(), made.end(), kept.begin(), kept.end()));
  }

  TemporaryDirectory directory_;
  std::unique_ptr<Program> train_;
};

TEST_P(ElasticTest, AnActorJoinsWithinTwoSecondsAndLeavesWithNothingLost) {
  const std::unique_ptr<Program> actor = StartActor("actor.log");
  ExpectJoins(1);
  EXPECT_TRUE(WaitUntil(
      *train_, [this] { return InReplay("actor-0007"); }, seconds(2)))
      << ReadFile(Dir("actor.log"));
  kill(actor->pid(), SIGTERM);
  EXPECT_EQ(actor->WaitFor(seconds(20)), 0) << ReadFile(Dir("actor.log"));
  EXPECT_THAT(ReadFile(Dir("run") / "log" / "learner.log"), HasSubstr("actor 7 left after"));
  std::map<int, int> last_episode;
  for (const std::string& line : Lines("actor-0007")) {
    const auto [vehicle, episode] = VehicleAndEpisode(line);
    last_episode[vehicle] = std::max(last_episode[vehicle], episode);
  }
  EXPECT_FALSE(last_episode.empty());
  EXPECT_TRUE(WaitUntil(
      *train_,
      [&] {
        std::set<int> going_on;
        for (const std::string& line : Lines("actor-000")) {
          const auto [vehicle, episode] = VehicleAndEpisode(line);
          if (last_episode.contains(vehicle) && episode > last_episode[vehicle]) going_on.insert(vehicle);
        }
        return going_on.size() == last_episode.size();
      },
      seconds(20)))
      << "vehicles of the actor that left stand still";
  StopTrain();
  const std::set<std::string> made = Lines("actor-0007"), replay = Lines("learner");
  EXPECT_TRUE(std::includes(replay.begin(), replay.end(), made.begin(), made.end())) << "a transition was lost";
}

TEST_P(ElasticTest, ASecondHolderOfAnIdIsRefusedAndTheFirstGoesOn) {
  const std::unique_ptr<Program> first = StartActor("first.log");
  ExpectJoins(1);
  const std::unique_ptr<Program> second = StartActor("second.log");
  EXPECT_EQ(second->WaitFor(seconds(8)), 2);
  EXPECT_THAT(ReadFile(Dir("second.log")), HasSubstr("is held by a living process"));
  EXPECT_EQ(first->WaitFor(Duration::zero()), std::nullopt) << ReadFile(Dir("first.log"));
  EXPECT_EQ(Joins(), 1u);
  ExpectReplayGrows();
}

TEST_P(ElasticTest, AnActorThatHungIsGivenUpAndComesBackInANewSession) {
  const std::unique_ptr<Program> actor = StartActor("actor.log");
  ExpectJoins(1);
  ASSERT_TRUE(WaitUntil(
      *train_, [this] { return InReplay("actor-0007-00"); }, seconds(20)));
  kill(actor->pid(), SIGSTOP);
  ASSERT_TRUE(WaitUntil(
      *train_,
      [this] {
        return ReadFile(Dir("run") / "log" / "learner.log").find("actor 7 was silent for 1 s") != std::string::npos;
      },
      seconds(20)));
  ExpectReplayGrows();
  kill(actor->pid(), SIGCONT);
  ExpectJoins(2);
  EXPECT_TRUE(WaitUntil(
      *train_, [this] { return InReplay("actor-0007-01"); }, seconds(20)));
  EXPECT_EQ(actor->WaitFor(Duration::zero()), std::nullopt) << ReadFile(Dir("actor.log"));
  StopTrain();
}

INSTANTIATE_TEST_SUITE_P(Schedules, ElasticTest, ::testing::Values("LOCKSTEP", "ASYNC"),
                         [](const auto& p) { return std::string(p.param); });

TEST(TwoRunsTest, RunsStartedAtOnceOnOneHostNeverMix) {
  const TemporaryDirectory directory;
  const auto dir = [&](const std::string& name) { return directory.path() / name; };
  std::map<std::string, std::unique_ptr<Program>> runs;
  for (const std::string name : {"a", "b"}) {
    std::filesystem::create_directories(dir(name + "-audit"));
    runs[name] = std::make_unique<Program>(
        "cairn",
        SmallRun(dir(name), 5003, {"--actors", "2", "--set", "schedule=ASYNC", "--seed", name == "a" ? "1" : "2"}),
        dir(name + ".log"), std::map<std::string, std::string>{{"CAIRN_AUDIT_DIR", dir(name + "-audit").string()}});
  }
  for (const auto& [name, run] : runs) {
    EXPECT_EQ(run->WaitFor(seconds(120)), 0) << ReadFile(dir(name + ".log"));
    const nlohmann::json summary = ReadJson(dir(name) / "summary.json");
    EXPECT_EQ(summary["completed"], true);
    EXPECT_EQ(summary["transitions_lost"], 0);
    ExpectReplayMatchesActors(dir(name + "-audit"), 5003, false);
  }
  const std::vector<std::string> first = AuditLines(dir("a-audit"), "learner");
  std::set<std::string> both(first.begin(), first.end());
  for (const std::string& line : AuditLines(dir("b-audit"), "learner")) both.insert(line);
  EXPECT_EQ(both.size(), 2u * 5003) << "the runs have transitions in common";
  EXPECT_NE(ReadJson(dir("a") / "run.json")["base_port"], ReadJson(dir("b") / "run.json")["base_port"]);
}

}  // namespace
}  // namespace cairn::testing
