#pragma once

#include <algorithm>
#include <functional>
#include <utility>
#include <vector>

#include "learner/evaluator.h"

namespace cairn::learner {

/// Answers every request with as many successes as `successes` says of (set, version).
class FakeEvaluator final : public Evaluator {
 public:
  void Evaluate(const EvaluationRequest& request, std::span<const float> policy) override {
    asked.push_back(request);
    parameters.emplace_back(policy.begin(), policy.end());
    if (!answering) return;
    EvaluationReport report{request, {}};
    const int solved = std::min(request.num_starts, successes(request));
    for (int i = 0; i < request.num_starts; ++i) {
      EpisodeResult r;
      r.outcome = i < solved ? Outcome::kGoal : failure;
      r.duration = duration(request);
      report.results.push_back(r);
    }
    ready.push_back(std::move(report));
  }
  std::vector<EvaluationReport> TakeEvaluations(bool) override { return std::exchange(ready, {}); }
  bool stopped() const override { return is_stopped; }

  std::vector<int64_t> Versions(StartSet set) const {
    std::vector<int64_t> versions;
    for (const EvaluationRequest& r : asked) {
      if (r.set == set) versions.push_back(r.version);
    }
    return versions;
  }

  std::function<int(const EvaluationRequest&)> successes = [](const EvaluationRequest&) { return 1000; };
  std::function<float(const EvaluationRequest&)> duration = [](const EvaluationRequest&) { return 5.0f; };
  Outcome failure = Outcome::kCollision;
  bool answering = true;
  bool is_stopped = false;
  std::vector<EvaluationRequest> asked;
  std::vector<std::vector<float>> parameters;
  std::vector<EvaluationReport> ready;
};

}  // namespace cairn::learner
