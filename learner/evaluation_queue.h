#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <utility>
#include <vector>

#include "common/rl/episode.h"

namespace cairn::learner {

/// A check of one policy version on one start set.
struct EvaluationRequest {
  int64_t version = 0;
  StartSet set = StartSet::kConsumption;
  int num_starts = 0;
  int64_t env_steps = 0;  ///< when the evaluated version was published
  int64_t tag = 0;        ///< the caller's: number of the check
};

struct EvaluationReport {
  EvaluationRequest request;
  std::vector<EpisodeResult> results;  ///< by start index
};

/// Evaluations asked for, of which the oldest runs: its starts are shared out over the actors and every result counts
/// once, whoever sends it and however often. Plain bookkeeping; the Coordinator locks around it.
class EvaluationQueue {
 public:
  /// Ids of a learner's evaluations differ from those of the learner before it.
  explicit EvaluationQueue(int64_t incarnation = 1) : next_id_(((incarnation - 1) % 1024 << 20) + 1) {}

  void Add(const EvaluationRequest& request);

  /// Takes a result of the running evaluation; ignores one that is foreign, late or known.
  void Accept(const EpisodeResult& result);

  /// Begins the running evaluation anew under a fresh id: the shares have changed hands.
  void Restart();

  /// Number of the running evaluation, ascending; 0: none.
  int64_t id() const { return pending_.empty() ? 0 : pending_.front().id; }
  /// The running one's; only while there is one.
  const EvaluationRequest& running() const { return pending_.front().request; }
  bool empty() const { return pending_.empty(); }
  bool Uses(int64_t version) const;

  /// Starts [first, end) of the running evaluation for the rank-th of `n` actors.
  std::pair<int, int> Share(int rank, int n) const;

  /// Finished ones in the order of their requests.
  std::vector<EvaluationReport> TakeReports() { return std::exchange(reports_, {}); }

 private:
  struct Pending {
    int64_t id = 0;
    EvaluationRequest request;
    std::vector<std::optional<EpisodeResult>> results;
    int missing = 0;
  };
  void Start();

  std::deque<Pending> pending_;
  std::vector<EvaluationReport> reports_;
  int64_t next_id_;
};

}  // namespace cairn::learner
