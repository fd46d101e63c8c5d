#include "actors/evaluation.h"

#include <algorithm>
#include <numeric>

namespace cairn::actors {

EvaluationBatch::EvaluationBatch(const std::shared_ptr<const Scene>& scene, StartSet set, std::vector<int> starts,
                                 const EvaluationOptions& options)
    : set_(set),
      starts_(std::move(starts)),
      options_(options),
      action_size_(static_cast<size_t>(scene->experiment().vehicle.action_size())),
      results_(starts_.size()),
      trajectories_(starts_.size()) {
  const size_t slots = std::min(starts_.size(), static_cast<size_t>(std::max(1, options_.max_batch)));
  for (size_t i = 0; i < slots; ++i) {
    active_.push_back({std::make_unique<Environment>(Scene::ForEvaluation(scene)), 0});
    Begin(active_.back());
  }
}

// False when no start is left.
bool EvaluationBatch::Begin(Slot& slot) {
  if (next_ == starts_.size()) return false;
  slot.start = next_++;
  const int start = starts_[slot.start];
  if (options_.poses.empty()) {
    slot.environment->ResetEvaluation(set_, start, options_.evaluation);
  } else {
    slot.environment->ResetEvaluation(set_, start, options_.evaluation, options_.poses.at(static_cast<size_t>(start)));
  }
  Record(slot);
  return true;
}

void EvaluationBatch::Record(const Slot& slot) {
  if (!options_.record) return;
  const Pose pose = slot.environment->pose();
  trajectories_[slot.start].push_back(
      {static_cast<float>(pose.x), static_cast<float>(pose.y), static_cast<float>(pose.z)});
}

void EvaluationBatch::Finish(const Slot& slot) {
  results_[slot.start] = slot.environment->episode();
  results_[slot.start].policy_version = options_.policy_version;
}

void EvaluationBatch::Step(Controller& controller) {
  environments_.clear();
  for (const Slot& slot : active_) environments_.push_back(slot.environment.get());
  actions_.resize(active_.size() * action_size_);
  controller.Act(environments_, actions_.data());
  const float* action = actions_.data();
  for (Slot& slot : active_) {
    const StepResult step = slot.environment->Step(action);
    action += action_size_;
    Record(slot);
    if (step.end == SegmentEnd::kNone) continue;
    Finish(slot);
    if (!Begin(slot)) slot.environment.reset();
  }
  std::erase_if(active_, [](const Slot& slot) { return slot.environment == nullptr; });
}

std::vector<EpisodeResult> RunEpisodes(const std::shared_ptr<const Scene>& scene, StartSet set, std::vector<int> starts,
                                       Controller& controller, EvaluationOptions options,
                                       std::vector<Trajectory>* trajectories) {
  options.record = trajectories != nullptr;
  EvaluationBatch batch(scene, set, std::move(starts), options);
  while (!batch.done()) batch.Step(controller);
  if (trajectories != nullptr) *trajectories = batch.trajectories();
  return batch.results();
}

std::vector<int> AllStarts(int n) {
  std::vector<int> starts(static_cast<size_t>(n));
  std::iota(starts.begin(), starts.end(), 0);
  return starts;
}

}  // namespace cairn::actors
