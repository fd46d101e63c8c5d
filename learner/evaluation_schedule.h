#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "common/config/experiment.h"
#include "common/rl/summary.h"
#include "learner/evaluation_state.h"
#include "learner/evaluator.h"

namespace cairn::learner {

/// Decides what is evaluated when (DESIGN 17–18): every interval_env_steps the consumption starts; after every
/// validation_every-th check that solved all of them, the validation starts, which choose the best policy; the test
/// starts once, at the end. As long as no check has solved all of them, one that solved half is enough; what that has
/// chosen goes when the first one does. It never influences training, so training does not wait for it.
class EvaluationSchedule {
 public:
  /// `run_seconds` gives the wall time since launch [s]. `on_report` hears of every finished evaluation.
  EvaluationSchedule(const EvaluationConfig& config, int collapse_checks, Evaluator* evaluator,
                     std::function<double()> run_seconds,
                     std::function<void(const EvaluationReport&, const EvaluationSummary&)> on_report);

  /// Where it stands, for a checkpoint, and back.
  EvaluationState State() const;
  void Restore(const EvaluationState& state);

  /// Asks for what was asked for and not answered then, when there is somebody to ask.
  void AskAgain(const EvaluationState& state);

  /// To be called after each training phase with the policy just published; asks for a check when one is due.
  void Visit(int64_t env_steps, int64_t version, std::span<const float> parameters);

  /// Whether Visit at these env steps would ask for a check.
  bool CheckDue(int64_t env_steps) const { return env_steps >= next_check_; }

  /// Whether a policy is still under evaluation.
  bool Pending(int64_t version) const { return pending_.contains(version); }

  /// Takes in finished evaluations; with `wait`, blocks until those asked for are.
  void Receive(bool wait);

  /// Blocks until no policy is under evaluation, validations that a check leads to included.
  void ReceiveAll();

  /// Validates the last policy when any policy was validated and it was not, then tests the best (or else the last)
  /// one; blocks. Returns nullopt when the run was stopped.
  std::optional<EvaluationSummary> Test(const PolicySnapshot& last);

  /// True once after `collapse_checks` checks in a row failed at least half of their starts, after one that solved all.
  bool TakeCollapse() { return std::exchange(collapsed_, false); }

  /// Checks in a row up to the newest in which no start was solved and at least half timed out.
  int hovering_checks() const { return hovering_checks_; }

  int64_t consumption_env_steps() const { return consumption_env_steps_; }  ///< −1: not reached
  double consumption_wall_s() const { return consumption_wall_s_; }
  /// Share of the checks after the first solved one that were solved as well; 1 when there was none.
  double stays_solved() const { return later_checks_ == 0 ? 1.0 : static_cast<double>(later_solved_) / later_checks_; }
  int last_solved() const { return last_solved_; }  ///< consumption starts solved in the newest check; −1: none yet
  const std::optional<PolicySnapshot>& best() const { return best_; }
  double best_success() const { return best_score_.first; }

 private:
  void Ask(StartSet set, int starts, const PolicySnapshot& policy, int64_t tag);
  void OnConsumption(const EvaluationReport& report, const EvaluationSummary& summary);
  void OnValidation(const EvaluationReport& report, const EvaluationSummary& summary);

  const EvaluationConfig config_;
  const int collapse_checks_;
  Evaluator* evaluator_;
  std::function<double()> run_seconds_;
  std::function<void(const EvaluationReport&, const EvaluationSummary&)> on_report_;
  std::map<int64_t, PolicySnapshot> pending_;  // by version
  std::deque<EvaluationRequest> asked_;        // not answered yet, in order
  int64_t next_check_;
  int64_t num_checks_ = 0;
  int64_t consumption_env_steps_ = -1;
  double consumption_wall_s_ = -1;
  int later_checks_ = 0;
  int later_solved_ = 0;
  int last_solved_ = -1;
  int failed_checks_ = 0;
  bool collapsed_ = false;
  int hovering_checks_ = 0;      // since launch or resume
  int64_t last_validated_ = -1;  // version, since launch or resume
  std::optional<PolicySnapshot> best_;
  std::pair<double, double> best_score_{-1, 0};  // success rate, minus mean time to goal
  std::optional<EvaluationSummary> test_;
};

}  // namespace cairn::learner
