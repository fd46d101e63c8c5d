#include "learner/evaluation_queue.h"

#include <algorithm>

namespace cairn::learner {

void EvaluationQueue::Add(const EvaluationRequest& request) {
  Pending pending;
  pending.request = request;
  pending_.push_back(std::move(pending));
  if (pending_.size() == 1) Start();
}

void EvaluationQueue::Start() {
  Pending& front = pending_.front();
  front.id = next_id_++;
  front.missing = front.request.num_starts;
  front.results.assign(static_cast<size_t>(front.missing), std::nullopt);
}

void EvaluationQueue::Restart() {
  if (!pending_.empty()) Start();
}

void EvaluationQueue::Accept(const EpisodeResult& result) {
  if (pending_.empty() || result.episode != pending_.front().id) return;
  Pending& front = pending_.front();
  if (result.vehicle < 0 || result.vehicle >= static_cast<int32_t>(front.results.size())) return;
  auto& slot = front.results[static_cast<size_t>(result.vehicle)];
  if (slot) return;  // a replaced actor did it again
  slot = result;
  if (--front.missing > 0) return;
  EvaluationReport report{front.request, {}};
  for (const auto& r : front.results) report.results.push_back(*r);
  reports_.push_back(std::move(report));
  pending_.pop_front();
  Restart();
}

bool EvaluationQueue::Uses(int64_t version) const {
  return std::any_of(pending_.begin(), pending_.end(),
                     [version](const Pending& p) { return p.request.version == version; });
}

std::pair<int, int> EvaluationQueue::Share(int rank, int n) const {
  const int starts = pending_.empty() ? 0 : pending_.front().request.num_starts;
  return {starts * rank / n, starts * (rank + 1) / n};
}

}  // namespace cairn::learner
