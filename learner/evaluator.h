#pragma once

#include <span>
#include <vector>

#include "learner/evaluation_queue.h"

namespace cairn::learner {

/// Whoever has policies evaluated; in a run it is the Coordinator, which lets the actors do it.
class Evaluator {
 public:
  virtual ~Evaluator() = default;

  /// Queues an evaluation of the policy with these parameters, which need not be the newest.
  virtual void Evaluate(const EvaluationRequest& request, std::span<const float> parameters) = 0;

  /// Finished evaluations in the order of their requests; with `wait`, blocks until the queue is empty or stopped().
  virtual std::vector<EvaluationReport> TakeEvaluations(bool wait) = 0;

  virtual bool stopped() const = 0;
};

}  // namespace cairn::learner
