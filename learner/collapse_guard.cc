#include "learner/collapse_guard.h"

#include "common/core/log.h"

namespace cairn::learner {

CollapseGuard::CollapseGuard(const Experiment& experiment, EvaluationSchedule* evaluation, Algorithm* algorithm)
    : consumption_starts_(experiment.evaluation.consumption_starts),
      collapse_checks_(experiment.learner.collapse_checks),
      reverts_(experiment.learner.on_collapse == LearnerConfig::OnCollapse::kRevertToBest),
      waits_(reverts_ && experiment.schedule == Schedule::kLockstep),
      evaluation_(evaluation),
      algorithm_(algorithm) {}

// What is published under a version is then what is kept and evaluated under it.
void CollapseGuard::BeforePublish(int64_t env_steps) {
  const bool check = evaluation_->CheckDue(env_steps);
  if (waits_ && check) evaluation_->ReceiveAll();
  if ((!waits_ || check) && evaluation_->TakeCollapse()) OnCollapse(env_steps);
}

void CollapseGuard::Visit(int64_t env_steps, int64_t version) {
  const bool check = evaluation_->CheckDue(env_steps);
  if (reverts_ && check) candidates_[version] = algorithm_->Save();
  evaluation_->Visit(env_steps, version, algorithm_->policy_parameters());
  if (evaluation_->last_solved() == consumption_starts_) collapse_.clear();
  if (evaluation_->hovering_checks() == 0) hovering_.clear();
  // Several results may have come in at once.
  if (evaluation_->hovering_checks() >= collapse_checks_ && hovering_.empty()) OnHovering(env_steps);
  const int64_t best = evaluation_->best() ? evaluation_->best()->version : -1;
  std::erase_if(candidates_, [&](const auto& c) { return c.first != best && !evaluation_->Pending(c.first); });
}

// Nothing to go back to, and other networks learn the same from the same replay.
void CollapseGuard::OnHovering(int64_t env_steps) {
  hovering_ = fmt::format(
      "the policy hovers: no consumption start is solved and most time out since {} checks; the cure is a price of "
      "time "
      "(reward.step_reward below 0)",
      collapse_checks_);
  log::Warning("{} ({} env steps)", hovering_, env_steps);
}

void CollapseGuard::OnCollapse(int64_t env_steps) {
  collapse_ =
      fmt::format("the policy collapsed: half of the consumption starts fail since {} checks", collapse_checks_);
  if (reverts_ && evaluation_->best()) {
    const auto best = candidates_.find(evaluation_->best()->version);
    if (best != candidates_.end()) {
      algorithm_->LoadNetworks(best->second);
      collapse_ += fmt::format("; back to the networks of {} env steps", evaluation_->best()->env_steps);
    }
  }
  log::Warning("{} ({} env steps)", collapse_, env_steps);
}

}  // namespace cairn::learner
