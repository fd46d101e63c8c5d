#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "actors/range_finder.h"
#include "actors/rewards/reward.h"
#include "actors/scene.h"
#include "actors/surprise_finder.h"
#include "actors/vehicles/vehicle.h"
#include "common/rl/episode.h"
#include "common/rl/segment.h"

namespace cairn::actors {

/// What one control step gave.
struct StepResult {
  float reward = 0;
  SegmentEnd end = SegmentEnd::kNone;  ///< kTerminated or kTruncated when the episode is over
};

/// One vehicle in its own small ODE world: observation, action → reward, episode bookkeeping. Reset decides whether it
/// is a training or an evaluation episode; all randomness is keyed by (seed, vehicle or start, purpose, episode), so
/// the result does not depend on which process runs it. One thread at a time.
class Environment {
 public:
  /// Shares what is large with `scene`.
  explicit Environment(const Scene& scene);
  explicit Environment(const std::shared_ptr<const Scene>& scene) : Environment(*scene) {}
  ~Environment();

  /// Goes over to this scene of the same experiment, for the next episode.
  void Enter(const Scene& scene);

  /// Starts training episode `episode` of `vehicle`.
  void ResetTraining(int vehicle, int episode) { ResetTraining(vehicle, episode, episode); }

  /// The same from the start pose that `start_episode` of the vehicle had.
  void ResetTraining(int vehicle, int episode, int start_episode);

  /// Starts evaluation from start `index` of `set`; `evaluation` numbers the check. Step limit EvaluationSteps.
  void ResetEvaluation(StartSet set, int index, int evaluation);

  /// The same from a pose of the caller's, with the disturbances of that start.
  void ResetEvaluation(StartSet set, int index, int evaluation, const Pose& start);

  /// Writes ObservationSize(experiment) floats.
  void Observe(float* observation) const;

  /// Applies an action in [−1, 1]^action_size for one control period; the first event (contact, goal) ends it early.
  /// A non-finite action or state ends the episode as kDiverged (truncated, reward 0): the caller counts it and keeps
  /// its last segment out of replay. Pose and observation stay those of the last finite state.
  StepResult Step(const float* action);

  /// Bookkeeping of the current episode; complete when the last Step returned an end.
  const EpisodeResult& episode() const { return episode_; }

  Pose pose() const;
  const Motion& motion() const;
  const Scene& scene() const { return *scene_; }
  /// Where the vehicle takes itself to be (observation.pose_noise); pose() without such noise.
  Pose believed_pose() const;
  /// The look around that the observation has, once more.
  RangeFinder Look() const;
  /// Where people stand now.
  const std::vector<Cylinder>& persons() const;
  /// D_min of the current episode under the reward's D [m], kUnreachable while no D was finite.
  float d_min() const;

  /// A new table in mid-episode (DESIGN 24): D_min = new D(s), no reward.
  void SetTable(std::shared_ptr<const RoadmapLookup> lookup);

  /// What the vehicle finds that the planner does not know, by planner.repair; after a step.
  Findings FindSurprises() const;

  /// Opaque, exact: after Load the same actions give the same bits, given the same experiment and cost table. Load
  /// throws Error when the blob does not fit the experiment.
  std::string Save() const;
  void Load(const std::string& blob);

 private:
  struct State;
  void Start(const EpisodeResult& next, const Pose& start, int step_limit);
  bool Drive(const float* action, StepEvent& event);
  float BelievedDistance(float distance) const;
  StepResult Finish(StepEvent event);
  StepResult Diverge();

  std::unique_ptr<Scene> scene_;  // its own, at a fixed place: State refers to it
  std::unique_ptr<State> state_;
  EpisodeResult episode_;
};

}  // namespace cairn::actors
