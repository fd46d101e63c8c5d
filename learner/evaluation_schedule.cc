#include "learner/evaluation_schedule.h"

namespace cairn::learner {

EvaluationSchedule::EvaluationSchedule(const EvaluationConfig& config, int collapse_checks, Evaluator* evaluator,
                                       std::function<double()> run_seconds,
                                       std::function<void(const EvaluationReport&, const EvaluationSummary&)> on_report)
    : config_(config),
      collapse_checks_(collapse_checks),
      evaluator_(evaluator),
      run_seconds_(std::move(run_seconds)),
      on_report_(std::move(on_report)),
      next_check_(config.interval_env_steps) {}

void EvaluationSchedule::Ask(StartSet set, int starts, const PolicySnapshot& policy, int64_t tag) {
  pending_.insert_or_assign(policy.version, policy);
  asked_.push_back({policy.version, set, starts, policy.env_steps, tag});
  evaluator_->Evaluate(asked_.back(), policy.parameters);
}

EvaluationState EvaluationSchedule::State() const {
  EvaluationState state;
  state.next_check = next_check_;
  state.num_checks = num_checks_;
  state.consumption_env_steps = consumption_env_steps_;
  state.consumption_wall_s = consumption_wall_s_;
  state.later_checks = later_checks_;
  state.later_solved = later_solved_;
  state.last_solved = last_solved_;
  state.failed_checks = failed_checks_;
  state.collapsed = collapsed_;
  state.best = best_;
  state.best_success = best_score_.first;
  state.best_time = best_score_.second;
  for (const EvaluationRequest& request : asked_) {
    const auto policy = pending_.find(request.version);
    if (policy != pending_.end()) state.asked.push_back({request, policy->second});
  }
  return state;
}

void EvaluationSchedule::Restore(const EvaluationState& state) {
  next_check_ = state.next_check;
  num_checks_ = state.num_checks;
  consumption_env_steps_ = state.consumption_env_steps;
  consumption_wall_s_ = state.consumption_wall_s;
  later_checks_ = state.later_checks;
  later_solved_ = state.later_solved;
  last_solved_ = state.last_solved;
  failed_checks_ = state.failed_checks;
  collapsed_ = state.collapsed;
  best_ = state.best;
  best_score_ = {state.best_success, state.best_time};
}

void EvaluationSchedule::AskAgain(const EvaluationState& state) {
  for (const EvaluationState::Asked& asked : state.asked) {
    Ask(asked.request.set, asked.request.num_starts, asked.policy, asked.request.tag);
  }
}

void EvaluationSchedule::Visit(int64_t env_steps, int64_t version, std::span<const float> parameters) {
  Receive(false);
  if (env_steps < next_check_) return;
  next_check_ += config_.interval_env_steps * ((env_steps - next_check_) / config_.interval_env_steps + 1);
  Ask(StartSet::kConsumption, config_.consumption_starts,
      {version, env_steps, std::vector<float>(parameters.begin(), parameters.end())}, num_checks_++);
}

void EvaluationSchedule::Receive(bool wait) {
  for (const EvaluationReport& report : evaluator_->TakeEvaluations(wait)) {
    const EvaluationSummary summary = Summarise(report.results);
    if (!asked_.empty()) asked_.pop_front();
    if (report.request.set == StartSet::kConsumption) OnConsumption(report, summary);
    if (report.request.set == StartSet::kValidation) OnValidation(report, summary);
    if (report.request.set == StartSet::kTest) test_ = summary;
    on_report_(report, summary);
  }
}

void EvaluationSchedule::ReceiveAll() {
  do {
    Receive(true);
  } while (!pending_.empty() && !evaluator_->stopped());
}

void EvaluationSchedule::OnConsumption(const EvaluationReport& report, const EvaluationSummary& summary) {
  const bool solved = summary.successes == summary.trials;
  last_solved_ = summary.successes;
  const bool hovers = summary.successes == 0 && 2 * summary.timeouts >= summary.trials;
  hovering_checks_ = hovers ? hovering_checks_ + 1 : 0;
  if (consumption_env_steps_ >= 0) {
    ++later_checks_;
    later_solved_ += solved ? 1 : 0;
    failed_checks_ = 2 * summary.successes <= summary.trials ? failed_checks_ + 1 : 0;
    collapsed_ = collapsed_ || (failed_checks_ > 0 && failed_checks_ % collapse_checks_ == 0);
  } else if (solved) {
    consumption_env_steps_ = report.request.env_steps;
    consumption_wall_s_ = run_seconds_();
    best_.reset();  // it had solved some only
    best_score_ = {-1, 0};
  }
  const int64_t check = report.request.tag;
  // Not the first check: most of its starts may still time out, and that takes long.
  const bool promising = consumption_env_steps_ < 0 && check > 0 && 2 * summary.successes >= summary.trials;
  const auto policy = pending_.find(report.request.version);
  if (policy == pending_.end()) return;
  if ((solved || promising) && check % config_.validation_every == 0) {
    Ask(StartSet::kValidation, config_.validation_starts, PolicySnapshot(policy->second), check);
  } else {
    pending_.erase(policy);
  }
}

// The later of two equally good policies has seen more; equal success is decided by the time to the goal.
void EvaluationSchedule::OnValidation(const EvaluationReport& report, const EvaluationSummary& summary) {
  last_validated_ = report.request.version;
  const auto policy = pending_.find(report.request.version);
  if (policy == pending_.end()) return;
  const std::pair<double, double> score{summary.success_rate, -summary.mean_time_to_goal};
  const bool overtaken = report.request.env_steps < consumption_env_steps_;
  if (!overtaken && score >= best_score_) {
    best_score_ = score;
    best_ = std::move(policy->second);
  }
  pending_.erase(policy);
}

std::optional<EvaluationSummary> EvaluationSchedule::Test(const PolicySnapshot& last) {
  ReceiveAll();
  if (!evaluator_->stopped() && best_ && best_->version != last.version && last_validated_ != last.version) {
    Ask(StartSet::kValidation, config_.validation_starts, last, num_checks_);
    Receive(true);
  }
  if (evaluator_->stopped()) return std::nullopt;
  const PolicySnapshot& tested = best_ ? *best_ : last;
  evaluator_->Evaluate({tested.version, StartSet::kTest, config_.test_starts, tested.env_steps, 0}, tested.parameters);
  Receive(true);
  return test_;
}

}  // namespace cairn::learner
