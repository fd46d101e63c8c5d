#pragma once

#include <cstdint>
#include <vector>

#include "common/core/bytes.h"

namespace cairn::learner {

/// What the stream and the books have seen.
struct CoordinatorCounters {
  int64_t transitions_accepted = 0;
  int64_t transitions_lost = 0;       ///< gaps within a living session's trajectories
  int64_t transitions_duplicate = 0;  ///< refused because the replay has them
  int64_t stream_duplicates = 0;      ///< messages resent though they had arrived
  int64_t eval_steps = 0;
  int64_t refused = 0;  ///< frames and segments that failed a check
  double policy_lag_sum = 0;
  int64_t policy_lag_count = 0;
  int64_t recovered = 0;  ///< accepted though made under an earlier incarnation of the learner
  int num_actors = 0;
  bool disturbed = false;
  // Of the actors' streams, those that are gone included.
  int64_t messages_sent = 0;
  int64_t messages_resent = 0;
  double credit_wait_s = 0;     ///< time in which actors had nothing to do, all together
  double stream_latency_s = 0;  ///< mean over the actors: from sending a message to the frame that acknowledges it
};

/// A policy as it was at some point of the run.
struct PolicySnapshot {
  int64_t version = -1;
  int64_t env_steps = 0;
  std::vector<float> parameters;
};

/// One training vehicle's trajectory so far, and the environment at its end if the next owner shall go on with it.
struct VehicleState {
  int32_t next_episode = 0;  ///< first episode number not used yet
  int32_t episode = -1;      ///< of the newest accepted segment; −1: none
  int32_t next_step = 0;     ///< step that continues it
  bool open = false;         ///< the episode goes on
  int32_t diverged = -1;     ///< newest episode reported as ended by a non-finite state, which sends no last segment
  int64_t steps = 0;         ///< transitions accepted since the run's start
  Bytes environment;         ///< Rollout::SaveVehicle after `steps` transitions; empty: a new episode begins
  int32_t owner = -1;        ///< actor id; −1: nobody
};

/// ASYNC: an actor's session, which goes on with the next learner if both live.
struct SessionState {
  int32_t actor_id = 0;
  int64_t session = 0;
  int32_t generation = 0;
  int64_t assignment = 0;
  int64_t received = 0;  ///< position of its stream
  int64_t accepted = 0;  ///< transitions
  int64_t credit = 0;
};

/// A LOCKSTEP round that is granted and not complete.
struct RoundState {
  int steps = 0;
  int extra = 0;
  bool warm_up = false;
  PolicySnapshot policy;
};

/// The coordinator's books at the end of a round.
struct CoordinatorState {
  CoordinatorCounters counters;
  std::vector<VehicleState> vehicles;
  int64_t rounds = 0;               ///< taken so far
  std::vector<RoundState> granted;  ///< open ones, oldest first
  std::vector<SessionState> sessions;
};

}  // namespace cairn::learner
