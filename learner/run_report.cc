#include "learner/run_report.h"

#include <sys/resource.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "common/core/check.h"
#include "common/core/clock.h"
#include "common/core/files.h"
#include "common/core/log.h"
#include "common/core/version.h"

namespace cairn::learner {
namespace {

using std::chrono::milliseconds;

constexpr auto kTelemetryInterval = milliseconds(250);
constexpr double kRateWindow_s = 1.0;
constexpr int64_t kScalarInterval = 2000;  // env steps
constexpr size_t kRecentEpisodes = 100;

double Rate(int64_t from, int64_t to, double seconds) {
  return seconds > 0 ? static_cast<double>(to - from) / seconds : 0.0;
}

template <typename Value>
double MeanOver(const std::deque<EpisodeResult>& episodes, Value value) {
  double sum = 0;
  for (const EpisodeResult& episode : episodes) sum += value(episode);
  return episodes.empty() ? 0.0 : sum / static_cast<double>(episodes.size());
}

double MeanSuccess(const std::deque<EpisodeResult>& episodes) {
  return MeanOver(episodes, [](const EpisodeResult& e) { return e.outcome == Outcome::kGoal ? 1.0 : 0.0; });
}

double ProcessCpuSeconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

double MeanLag(const CoordinatorCounters& stream) {
  return stream.policy_lag_count == 0 ? 0.0 : stream.policy_lag_sum / static_cast<double>(stream.policy_lag_count);
}

const char* SetName(StartSet set) {
  switch (set) {
    case StartSet::kConsumption:
      return "consumption";
    case StartSet::kValidation:
      return "validation";
    case StartSet::kTest:
      return "test";
    case StartSet::kTraining:
      break;
  }
  return "training";
}

nlohmann::ordered_json ToJson(const std::pair<std::string, LogCounters>& log) {
  const LogCounters& counters = log.second;
  nlohmann::ordered_json json;
  json["file"] = log.first;
  json["messages"] = counters.messages;
  json["transitions"] = counters.transitions;
  json["transitions_duplicate"] = counters.transitions_duplicate;
  json["transitions_not_finite"] = counters.transitions_not_finite;
  json["messages_missing"] = counters.messages_missing;
  json["frames_refused"] = counters.frames_refused;
  json["faults"] = counters.faults;
  return json;
}

}  // namespace

RunReport::RunReport(Bus* bus, const Experiment& experiment, const std::string& run_dir, int64_t launch_us)
    : bus_(bus), experiment_(experiment), run_dir_(run_dir), launch_us_(launch_us != 0 ? launch_us : MonotonicUs()) {}

void RunReport::Open(double wall_s, int64_t episode_log_bytes) {
  earlier_wall_s_ = wall_s;
  if (run_dir_.empty()) return;
  events_ = std::make_unique<EventWriter>(run_dir_);
  episode_log_ =
      std::make_unique<EpisodeLog>((std::filesystem::path(run_dir_) / "episodes.csv").string(), episode_log_bytes);
}

double RunReport::wall_s() const { return earlier_wall_s_ + static_cast<double>(MonotonicUs() - launch_us_) * 1e-6; }

// A disk that is full for a while is no reason to stop training: what could not be written is kept, said, and written
// when there is room again.
template <typename Write>
void RunReport::TryToWrite(const Write& write) {
  try {
    write();
  } catch (const Error& error) {
    if (log_error_.empty()) log::Error("{}", error.what());
    log_error_ = error.what();
  }
}

int64_t RunReport::FlushEpisodes() {
  if (!episode_log_) return 0;
  TryToWrite([this] { episode_log_->Flush(); });
  return episode_log_->size();
}

void RunReport::OnEpisodes(const std::vector<EpisodeResult>& episodes, int64_t env_steps) {
  for (const EpisodeResult& episode : episodes) {
    if (episode_log_) TryToWrite([&] { episode_log_->Add(episode, env_steps, wall_s()); });
    recent_.push_back(episode);
    if (recent_.size() > kRecentEpisodes) recent_.pop_front();
  }
}

void RunReport::OnEvaluation(const EvaluationReport& report, const EvaluationSummary& summary) {
  const char* set = SetName(report.request.set);
  log::Info("{} at {} env steps: {}", set, report.request.env_steps, ToString(summary));
  if (report.request.set != StartSet::kConsumption) last_success_ = summary.success_rate;
  if (!events_) return;
  const auto write = [&](const char* name, double value) {
    events_->Scalar(fmt::format("{}/{}", report.request.set == StartSet::kConsumption ? "eval" : set, name), value,
                    report.request.env_steps);
  };
  TryToWrite([&] {
    write("success_rate", summary.success_rate);
    write("mean_ep_length", static_cast<double>(summary.steps) / std::max(1, summary.trials));
    write("mean_reward", summary.mean_return);
    write("spl", summary.spl);
  });
}

void RunReport::Visit(const RunCounters& counters, Algorithm* algorithm) {
  if (counters.env_steps >= next_scalars_) {
    next_scalars_ = counters.env_steps + kScalarInterval;
    const UpdateInfo info = algorithm->TakeInfo();
    if (info.num_means > 0) last_info_.critic_loss = info.critic_loss;
    if (info.num_actor_updates > 0) {
      last_info_.actor_loss = info.actor_loss;
      last_info_.alpha = info.alpha;
    }
    if (events_) TryToWrite([&] { Scalars(counters, info); });
  }
  if (Clock::now() - last_telemetry_ < kTelemetryInterval) return;
  if (!log_error_.empty()) {
    TryToWrite([this] {
      episode_log_->Flush();
      events_->Flush();
      log_error_.clear();
    });
  }
  Telemetry(counters);
}

// Tags as Stable-Baselines3 writes them, so that its dashboards work. No point where nothing was learnt.
void RunReport::Scalars(const RunCounters& counters, const UpdateInfo& info) {
  const auto write = [&](const char* tag, double value) { events_->Scalar(tag, value, counters.env_steps); };
  write("time/fps", env_steps_per_s_);
  write("time/updates_per_s", updates_per_s_);
  if (!recent_.empty()) {
    write("rollout/success_rate", MeanSuccess(recent_));
    write("rollout/ep_rew_mean", MeanOver(recent_, [](const EpisodeResult& e) { return e.episode_return; }));
    write("rollout/ep_len_mean", MeanOver(recent_, [](const EpisodeResult& e) { return e.steps; }));
  }
  if (info.num_updates > 0) {
    write("train/n_updates", static_cast<double>(info.num_updates));
    write("train/bad_updates", static_cast<double>(info.bad_updates));
  }
  if (info.num_means > 0) {
    write("train/critic_loss", info.critic_loss);
    write("train/mean_q", info.mean_q);
  }
  if (info.num_actor_updates > 0) {
    write("train/actor_loss", info.actor_loss);
    if (experiment_.learner.algorithm == LearnerConfig::Algorithm::kSac) {
      write("train/ent_coef", info.alpha);
      write("train/ent_coef_loss", info.alpha_loss);
    }
  }
  write("stream/policy_lag", MeanLag(counters.stream));
  write("stream/refused", static_cast<double>(counters.stream.refused));
  write("stream/sent", static_cast<double>(counters.stream.messages_sent));
  write("stream/resent", static_cast<double>(counters.stream.messages_resent));
  write("stream/duplicates", static_cast<double>(counters.stream.stream_duplicates));
  write("stream/latency", counters.stream.stream_latency_s);
  write("stream/credit_wait", counters.stream.credit_wait_s);
}

void RunReport::Telemetry(const RunCounters& counters) {
  const TimePoint now = Clock::now();
  last_telemetry_ = now;
  const double seconds = std::chrono::duration<double>(now - rate_time_).count();
  if (rate_from_.phase != counters.phase) {
    if (counters.phase == "training") {
      training_started_s_ = wall_s();
      started_ = counters;
    }
    rate_from_ = counters;
    rate_time_ = now;
  } else if (seconds >= kRateWindow_s) {
    env_steps_per_s_ = Rate(rate_from_.env_steps, counters.env_steps, seconds);
    updates_per_s_ = Rate(rate_from_.updates, counters.updates, seconds);
    rate_from_ = counters;
    rate_time_ = now;
  }
  LearnerTelemetry message;
  message.env_steps = counters.env_steps;
  message.total_env_steps = experiment_.total_env_steps;
  message.eval_steps = counters.stream.eval_steps;
  message.updates = counters.updates;
  message.policy_version = counters.updates;
  message.consumption_env_steps = counters.consumption_env_steps;
  message.transitions_duplicate = counters.stream.transitions_duplicate;
  message.frames_refused = counters.stream.refused;
  message.num_actors = counters.stream.num_actors;
  message.replay_size = counters.replay_size;
  message.consumption_solved = counters.last_solved;
  message.env_steps_per_s = env_steps_per_s_;
  message.updates_per_s = updates_per_s_;
  message.training_success_rate = MeanSuccess(recent_);
  message.success_rate = last_success_ >= 0 ? last_success_ : message.training_success_rate;
  message.episode_return = MeanOver(recent_, [](const EpisodeResult& e) { return e.episode_return; });
  message.critic_loss = last_info_.critic_loss;
  message.actor_loss = last_info_.actor_loss;
  message.alpha = last_info_.alpha;
  message.policy_lag = MeanLag(counters.stream);
  message.messages_sent = counters.stream.messages_sent;
  message.messages_resent = counters.stream.messages_resent;
  message.stream_latency = counters.stream.stream_latency_s;
  message.credit_wait = counters.stream.credit_wait_s;
  message.wall_s = wall_s();
  message.warning = !counters.warning.empty() ? counters.warning : log_error_;
  message.phase = counters.phase;
  bus_->Publish(Plane::kTelemetry, kLearnerChannel, message);
}

void RunReport::TrainingEnded(const RunCounters& counters) {
  training_ended_s_ = wall_s();
  Telemetry(counters);
}

void RunReport::Finish(const RunCounters& counters, const RunResult& result) {
  const double training_s = training_started_s_ < 0 ? 0.0 : training_ended_s_ - training_started_s_;
  nlohmann::ordered_json json;
  json["completed"] = result.completed;
  json["env_steps"] = counters.env_steps;
  json["eval_steps"] = counters.stream.eval_steps;
  json["updates"] = counters.updates;
  json["wall_s"] = wall_s();
  json["training_s"] = training_s;
  json["learner_cpu_s"] = ProcessCpuSeconds();
  const bool reached = counters.consumption_env_steps >= 0;
  json["consumption_env_steps"] = reached ? nlohmann::ordered_json(counters.consumption_env_steps) : nullptr;
  json["consumption_wall_s"] = reached ? nlohmann::ordered_json(counters.consumption_wall_s) : nullptr;
  json["stays_solved"] = counters.stays_solved;
  json["bad_updates"] = result.bad_updates;
  const EvaluationSummary& test = result.test;
  json["success_rate"] = result.completed ? nlohmann::ordered_json(test.success_rate) : nullptr;
  json["success_interval"] = {test.success_interval.low, test.success_interval.high};
  json["trials"] = test.trials;
  json["policy_tested"] = result.policy_tested;
  json["collisions"] = test.collisions;
  json["timeouts"] = test.timeouts;
  json["mean_time_to_goal_s"] = test.mean_time_to_goal;
  json["mean_path_length_m"] = test.mean_path_length;
  json["spl"] = test.spl;
  json["min_clearance_m"] = test.min_clearance;
  json["mean_jerk"] = test.mean_jerk;
  json["test_steps"] = test.steps;
  json["filtered_steps"] = test.filtered_steps;
  json["transitions_lost"] = counters.stream.transitions_lost;
  json["transitions_duplicate"] = counters.stream.transitions_duplicate;
  json["transitions_rolled_back"] = counters.rolled_back;
  json["env_steps_per_s"] = Rate(started_.env_steps, counters.env_steps, training_s);
  json["updates_per_s"] = Rate(started_.updates, counters.updates, training_s);
  json["policy_lag_mean"] = MeanLag(counters.stream);
  json["messages_sent"] = counters.stream.messages_sent;
  json["messages_resent"] = counters.stream.messages_resent;
  json["messages_duplicate"] = counters.stream.stream_duplicates;
  json["frames_refused"] = counters.stream.refused;
  json["stream_latency_s"] = counters.stream.stream_latency_s;
  json["credit_wait_s"] = counters.stream.credit_wait_s;
  json["seed"] = experiment_.seed;
  json["deterministic"] =
      result.log.has_value() || (experiment_.schedule == Schedule::kLockstep && !counters.stream.disturbed);
  json["weights_crc32c"] = fmt::format("{:08x}", result.weights_crc32c);
  json["git_revision"] = GitRevision();
  if (result.log) json["replay_log"] = ToJson(*result.log);
  if (!run_dir_.empty()) {
    WriteFileAtomically((std::filesystem::path(run_dir_) / "summary.json").string(), json.dump(2) + "\n");
  }
  if (events_) events_->Flush();
  if (episode_log_) episode_log_->Flush();
  Telemetry(counters);
  log::Info("{}", json.dump());
}

}  // namespace cairn::learner
