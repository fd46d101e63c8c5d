#pragma once

#include <array>
#include <memory>
#include <vector>

#include "actors/controllers/controller.h"
#include "actors/course.h"
#include "actors/environment.h"
#include "actors/mender.h"
#include "common/rl/summary.h"

namespace cairn::actors {

/// Way of one episode: (x, y, z) of the vehicle's centre [m] at its start and after each control step.
using Trajectory = std::vector<std::array<float, 3>>;

struct EvaluationOptions {
  /// Key of the disturbances: a check has others than the next one, and all of one policy version have the same, so
  /// that `cairn eval` repeats a run's own test exactly.
  static int KeyOf(int64_t policy_version) { return static_cast<int>(policy_version & 0x7FFFFFFF); }

  int evaluation = 0;          ///< key of the disturbances
  int64_t policy_version = 0;  ///< copied into the results
  int max_batch = 32;          ///< episodes that run at the same time
  bool record = false;         ///< keep trajectories
  /// When not empty: start i is poses[i] instead of the set's.
  std::vector<Pose> poses;
  /// planner.repair_kept counts: episodes run one after the other, in the order of the starts. Else all begin without
  /// marks, so that results do not depend on how starts are shared out.
  bool keep_marks = false;
};

/// Rolls out a list of evaluation starts as one batch; as soon as an episode ends the next start takes its place. The
/// results do not depend on the batch, since everything random is keyed by start. One thread; stepwise, so that a
/// process can see to its messages in between.
class EvaluationBatch {
 public:
  EvaluationBatch(std::shared_ptr<Course> course, StartSet set, std::vector<int> starts,
                  const EvaluationOptions& options = {});

  bool done() const { return active_.empty(); }

  /// One control step of every running episode; false when all wait for tables of their goals.
  bool Step(Controller& controller);

  /// In the order of `starts`; complete when done.
  const std::vector<EpisodeResult>& results() const { return results_; }
  /// In the order of `starts`; empty ones unless recorded.
  const std::vector<Trajectory>& trajectories() const { return trajectories_; }

 private:
  struct Slot {
    std::unique_ptr<Environment> environment;
    size_t start = 0;  // index into starts_
    Mender mender;
    bool begun = false;
    bool running = false;  // else a table is on its way
  };
  bool TakeNext(Slot& slot);
  void TryBegin(Slot& slot);
  void TryMend(Slot& slot);
  void Look(Slot& slot);
  void Record(const Slot& slot);
  void Finish(const Slot& slot);

  std::shared_ptr<Course> course_;
  StartSet set_;
  std::vector<int> starts_;
  EvaluationOptions options_;
  size_t action_size_;
  size_t next_ = 0;
  std::vector<Slot> active_;
  std::vector<const Environment*> environments_;
  std::vector<float> actions_;
  std::vector<EpisodeResult> results_;
  std::vector<Trajectory> trajectories_;
};

/// Rolls out starts `starts` of `set` to their ends, where no table has to be waited for; `trajectories`, when not
/// null, receives one per start. A scene must have a table.
std::vector<EpisodeResult> RunEpisodes(const std::shared_ptr<Course>& course, StartSet set, std::vector<int> starts,
                                       Controller& controller, EvaluationOptions options = {},
                                       std::vector<Trajectory>* trajectories = nullptr);
std::vector<EpisodeResult> RunEpisodes(const std::shared_ptr<const Scene>& scene, StartSet set, std::vector<int> starts,
                                       Controller& controller, EvaluationOptions options = {},
                                       std::vector<Trajectory>* trajectories = nullptr);

/// 0, 1, …, n − 1: all of a set of n starts.
std::vector<int> AllStarts(int n);

}  // namespace cairn::actors
