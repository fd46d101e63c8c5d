#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "actors/blob.h"
#include "actors/course.h"
#include "actors/environment.h"
#include "actors/mender.h"
#include "common/core/bytes.h"
#include "common/core/random.h"
#include "common/nn/policy.h"
#include "common/rl/episode.h"
#include "common/rl/segment.h"

namespace cairn::actors {

/// Which policy makes the actions of a rollout step, and under which names its segments go out.
struct RolloutContext {
  Policy* policy = nullptr;
  bool warm_up = false;  ///< uniform actions instead of the policy's
  int64_t policy_incarnation = 0;
  int64_t policy_version = 0;
};

/// The training vehicles of one actor process: steps them as one batch and collects their segments and finished
/// episodes. What a vehicle does depends on (seed, vehicle, episode, step, policy) alone, not on its company.
class Rollout {
 public:
  explicit Rollout(std::shared_ptr<Course> course);
  explicit Rollout(const std::shared_ptr<const Scene>& scene) : Rollout(std::make_shared<Course>(scene)) {}

  /// Makes the set of vehicles exactly `vehicles` (ascending); new ones start with their `next_episode` and count on
  /// from the `steps_done` transitions that the learner has of them, or go on with a state of SaveVehicle if `states`
  /// has one for them; ones that stay go on, the others are dropped with their open segments. Throws Error when a state
  /// does not fit the experiment.
  void Assign(const std::vector<int32_t>& vehicles, const std::vector<int32_t>& next_episode,
              const std::vector<int64_t>& steps_done, const std::vector<Bytes>& states = {});

  /// Exact state of the vehicle with this index between two steps, without an open segment (after TakeSegments), for
  /// another process's Assign. Of a vehicle that is not ready the same, without its episode's beginning.
  Bytes SaveVehicle(int index) const;

  int num_vehicles() const { return static_cast<int>(vehicles_.size()); }
  int32_t vehicle(int index) const { return vehicles_[static_cast<size_t>(index)].id; }

  /// Whether the vehicle can make a step; else a table is on its way, and is looked for again here.
  bool Ready(int index);

  /// One control step of the vehicles with these indices, all ready, in one policy batch. `indices` is ascending. A
  /// step that diverges (non-finite state) ends its episode and makes no transition; see transitions().
  void Step(const std::vector<int>& indices, const RolloutContext& context);

  /// Closes the open segments (their episodes go on in new ones) and returns everything collected since the last call.
  std::vector<Segment> TakeSegments();
  std::vector<EpisodeResult> TakeEpisodes();

  /// Transitions made since the run's start by the vehicle with this index, whichever process made them.
  int64_t transitions(int index) const { return vehicles_[static_cast<size_t>(index)].transitions; }

  int64_t env_steps() const { return env_steps_; }
  int64_t num_episodes() const { return num_episodes_; }
  /// For telemetry: the first vehicle's environment; nullptr without vehicles.
  const Environment* first() const { return vehicles_.empty() ? nullptr : vehicles_.front().environment.get(); }

 private:
  /// kWaiting: for the table of its episode's goal. kMending: in the middle of an episode, for one around new marks.
  enum class Stage : int32_t { kWaiting = 0, kRunning = 1, kMending = 2 };
  struct VehicleState {
    explicit VehicleState(const PlannerConfig& planner) : mender(planner) {}

    int32_t id = 0;
    int32_t episode = 0;
    int32_t start_episode = 0;  ///< whose start pose this episode has
    int32_t step = 0;           ///< of the episode
    int64_t transitions = 0;
    Mender mender;
    Stage stage = Stage::kWaiting;
    Bytes state;  ///< to go on from once its table is here; empty: a new episode
    std::unique_ptr<Environment> environment;
    RandomStream exploration{0, RandomPurpose::kExploration};
    std::vector<float> observation;  ///< current
    Segment segment;                 ///< open
  };
  void TryBegin(VehicleState* vehicle);
  void TryMend(VehicleState* vehicle);
  void Look(VehicleState* vehicle);
  RandomStream ExplorationStream(const VehicleState& vehicle) const;
  static void ReadHead(BlobReader& blob, VehicleState* vehicle);
  static void TakeState(const Bytes& state, VehicleState* vehicle);
  void LoadVehicle(VehicleState* vehicle);
  void Act(const std::vector<int>& indices, const RolloutContext& context);
  void Advance(VehicleState* vehicle, const float* action, const RolloutContext& context);
  bool RetriesStart(VehicleState& vehicle, Outcome outcome) const;
  void EndEpisode(VehicleState* vehicle, SegmentEnd end, int64_t policy_version);
  void CloseSegment(VehicleState* vehicle, SegmentEnd end);

  const Experiment& experiment() const { return course_->home().experiment(); }

  std::shared_ptr<Course> course_;
  const int observation_size_;
  const size_t action_size_;
  std::vector<VehicleState> vehicles_;
  std::vector<float> observations_, noise_, actions_;  // batch buffers, row per vehicle
  std::vector<Segment> segments_;
  std::vector<EpisodeResult> episodes_;
  int64_t env_steps_ = 0;
  int64_t num_episodes_ = 0;
};

}  // namespace cairn::actors
