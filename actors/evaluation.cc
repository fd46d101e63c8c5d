#include "actors/evaluation.h"

#include <algorithm>
#include <numeric>

#include "common/core/check.h"

namespace cairn::actors {

EvaluationBatch::EvaluationBatch(std::shared_ptr<Course> course, StartSet set, std::vector<int> starts,
                                 const EvaluationOptions& options)
    : course_(std::move(course)),
      set_(set),
      starts_(std::move(starts)),
      options_(options),
      action_size_(static_cast<size_t>(course_->home().experiment().vehicle.action_size())),
      results_(starts_.size()),
      trajectories_(starts_.size()) {
  PlannerConfig planner = course_->home().experiment().planner;
  planner.repair_kept = planner.repair_kept && options_.keep_marks;
  if (planner.repair != PlannerConfig::Repair::kNone && planner.repair_kept) options_.max_batch = 1;
  const size_t slots = std::min(starts_.size(), static_cast<size_t>(std::max(1, options_.max_batch)));
  for (size_t i = 0; i < slots; ++i) {
    active_.push_back({std::make_unique<Environment>(course_->home()), 0, Mender(planner)});
    TakeNext(active_.back());
  }
}

// False when no start is left. What the one after it needs is on its way while this one runs.
bool EvaluationBatch::TakeNext(Slot& slot) {
  slot.begun = slot.running = false;
  if (next_ == starts_.size()) return false;
  slot.start = next_++;
  course_->PrefetchEvaluation(set_, starts_[slot.start]);
  if (next_ < starts_.size()) course_->PrefetchEvaluation(set_, starts_[next_]);
  TryBegin(slot);
  return true;
}

void EvaluationBatch::TryBegin(Slot& slot) {
  const int start = starts_[slot.start];
  const std::optional<Scene> scene = course_->Evaluation(set_, start);
  if (!scene) return;
  slot.begun = slot.running = true;
  slot.environment->Enter(*scene);
  if (options_.poses.empty()) {
    slot.environment->ResetEvaluation(set_, start, options_.evaluation);
  } else {
    slot.environment->ResetEvaluation(set_, start, options_.evaluation, options_.poses.at(static_cast<size_t>(start)));
  }
  Record(slot);
  slot.mender.Begin(scene->experiment().world.seed);
  if (!slot.mender.marks().empty()) TryMend(slot);
}

void EvaluationBatch::TryMend(Slot& slot) {
  auto table = course_->MendedTable(slot.environment->scene(), slot.mender.marks());
  slot.running = table != nullptr;
  if (slot.running) slot.environment->SetTable(std::move(table));
}

// What a step has shown; the table that follows is the next step's (DESIGN 24).
void EvaluationBatch::Look(Slot& slot) {
  if (slot.mender.active() &&
      slot.mender.Report(slot.environment->FindSurprises(), slot.environment->episode().duration)) {
    TryMend(slot);
  }
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

bool EvaluationBatch::Step(Controller& controller) {
  environments_.clear();
  for (Slot& slot : active_) {
    if (!slot.running) slot.begun ? TryMend(slot) : TryBegin(slot);
    if (slot.running) environments_.push_back(slot.environment.get());
  }
  if (environments_.empty()) return false;
  actions_.resize(environments_.size() * action_size_);
  controller.Act(environments_, actions_.data());
  const float* action = actions_.data();
  for (Slot& slot : active_) {
    if (!slot.running) continue;
    const StepResult step = slot.environment->Step(action);
    action += action_size_;
    Record(slot);
    Look(slot);
    if (step.end == SegmentEnd::kNone) continue;
    Finish(slot);
    if (!TakeNext(slot)) slot.environment.reset();
  }
  std::erase_if(active_, [](const Slot& slot) { return slot.environment == nullptr; });
  return true;
}

std::vector<EpisodeResult> RunEpisodes(const std::shared_ptr<Course>& course, StartSet set, std::vector<int> starts,
                                       Controller& controller, EvaluationOptions options,
                                       std::vector<Trajectory>* trajectories) {
  options.record = trajectories != nullptr;
  EvaluationBatch batch(course, set, std::move(starts), options);
  while (!batch.done()) {
    const bool stepped = batch.Step(controller);
    CAIRN_CHECK(stepped, "a table is on its way, and nobody waits for it");
  }
  if (trajectories != nullptr) *trajectories = batch.trajectories();
  return batch.results();
}

std::vector<EpisodeResult> RunEpisodes(const std::shared_ptr<const Scene>& scene, StartSet set, std::vector<int> starts,
                                       Controller& controller, EvaluationOptions options,
                                       std::vector<Trajectory>* trajectories) {
  return RunEpisodes(std::make_shared<Course>(scene), set, std::move(starts), controller, std::move(options),
                     trajectories);
}

std::vector<int> AllStarts(int n) {
  std::vector<int> starts(static_cast<size_t>(n));
  std::iota(starts.begin(), starts.end(), 0);
  return starts;
}

}  // namespace cairn::actors
