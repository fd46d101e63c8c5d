#include "learner/run_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>

#include "common/core/clock.h"
#include "common/core/hash.h"

namespace cairn::learner {
namespace {

namespace fs = std::filesystem;
using ::testing::Each;
using ::testing::HasSubstr;

BusConfig MakeBusConfig() { return {TransportConfig().group, 22000, 0, RandomId(), RandomId()}; }

// Gives what it is told.
class FakeAlgorithm final : public Algorithm {
 public:
  void Update(const ReplayBuffer&, int, double) override {}
  std::span<const float> policy_parameters() const override { return {}; }
  UpdateInfo TakeInfo() override { return info; }
  std::vector<StateArray> Save() override { return {}; }
  void Load(const std::vector<StateArray>&) override {}
  void LoadNetworks(const std::vector<StateArray>&) override {}
  uint32_t WeightsCrc32c() const override { return 0; }

  UpdateInfo info;
};

class RunReportTest : public ::testing::Test {
 protected:
  RunReportTest() : bus_(MakeBusConfig()) {
    std::string name = (fs::temp_directory_path() / "cairn-report-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("mkdtemp");
    directory_ = name;
    report_ = std::make_unique<RunReport>(&bus_, experiment_, directory_.string(), 0);
    report_->Open();
  }
  ~RunReportTest() override { fs::remove_all(directory_); }

  // A window of curves, which ends at these env steps.
  void VisitAt(int64_t env_steps, const UpdateInfo& info) {
    algorithm_.info = info;
    RunCounters counters;
    counters.env_steps = env_steps;
    report_->Visit(counters, &algorithm_);
  }

  static std::string Text(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(file), {});
  }

  // Points of a curve, once Finish has written them.
  int Points(const std::string& tag) const {
    int count = 0;
    for (const auto& entry : fs::directory_iterator(directory_)) {
      if (!entry.path().filename().string().starts_with("events.")) continue;
      const std::string text = Text(entry.path());
      for (size_t at = text.find(tag); at != std::string::npos; at = text.find(tag, at + 1)) ++count;
    }
    return count;
  }

  Experiment experiment_;
  Bus bus_;
  FakeAlgorithm algorithm_;
  fs::path directory_;
  std::unique_ptr<RunReport> report_;
};

TEST_F(RunReportTest, CurvesHaveNoPointsWhereNothingWasLearnt) {
  UpdateInfo both, critic, none;
  both.num_updates = critic.num_updates = none.num_updates = 7;
  both.num_means = critic.num_means = 7;
  both.num_actor_updates = 3;
  VisitAt(2000, {});
  VisitAt(4000, both);
  VisitAt(6000, critic);
  VisitAt(8000, none);
  report_->Finish({}, {});
  EXPECT_EQ(Points("time/fps"), 4);
  EXPECT_EQ(Points("train/n_updates"), 3);
  EXPECT_EQ(Points("train/critic_loss"), 2);
  EXPECT_EQ(Points("train/mean_q"), 2);
  EXPECT_EQ(Points("train/actor_loss"), 1);
  EXPECT_EQ(Points("train/ent_coef_loss"), 1);
}

TEST_F(RunReportTest, TheSummaryHasTheBadUpdatesOfTheEnd) {
  UpdateInfo info;
  info.num_updates = 7;
  info.bad_updates = 1;
  VisitAt(2000, info);
  RunResult result;
  result.bad_updates = 4;
  report_->Finish({}, result);
  EXPECT_EQ(nlohmann::json::parse(Text(directory_ / "summary.json"))["bad_updates"], 4);
}

// A limit on the size of files stands for a disk that is full for a while. Tried again with each telemetry.
TEST_F(RunReportTest, ADiskThatStaysFullIsSaidOnce) {
  BusConfig config = bus_.config();
  config.session = RandomId();
  Bus people(config);
  std::vector<std::string> warnings;
  people.Subscribe<LearnerTelemetry>(
      Plane::kTelemetry, kLearnerChannel,
      [&](const LearnerTelemetry& t, const FrameInfo&) { warnings.push_back(t.warning); });
  const auto visit_until = [&](const auto& done) {
    warnings.clear();
    for (const TimePoint end = Clock::now() + std::chrono::seconds(20); Clock::now() < end && !done();) {
      VisitAt(0, {});
      people.Poll(std::chrono::milliseconds(5));
    }
  };
  rlimit old_limit{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &old_limit), 0);
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit limit = old_limit;
  limit.rlim_cur = 2000;
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &limit), 0);
  ::testing::internal::CaptureStderr();
  report_->OnEpisodes(std::vector<EpisodeResult>(100), 0);
  report_->FlushEpisodes();
  visit_until([&] { return warnings.size() >= 4; });
  const std::string said = ::testing::internal::GetCapturedStderr();
  EXPECT_THAT(warnings, Each(HasSubstr("episodes.csv")));
  EXPECT_THAT(said, HasSubstr("episodes.csv"));
  EXPECT_EQ(said.find("episodes.csv"), said.rfind("episodes.csv")) << said;
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &old_limit), 0);
  std::signal(SIGXFSZ, old_handler);
  visit_until([&] { return !warnings.empty() && warnings.back().empty(); });
  ASSERT_FALSE(warnings.empty());
  EXPECT_EQ(warnings.back(), "") << "there is room again";
}

}  // namespace
}  // namespace cairn::learner
