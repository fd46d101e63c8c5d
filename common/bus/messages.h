#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/core/bytes.h"
#include "common/rl/episode.h"
#include "common/rl/segment.h"
#include "common/roadmap/world_goal.h"

namespace cairn {

// Plain structs of what travels; lcmtypes/*.lcm has units and meaning of every field. Hashes are uint64_t here and
// int64_t on the wire (LCM has no unsigned types).

/// Version of the wire protocol; changes when a type or a rule of docs/messages.md does.
constexpr int32_t kProtocolVersion = 4;

constexpr int32_t kMaxActorId = 65535;

struct Echo {
  int64_t nonce = 0;
  int32_t size = 0;  ///< bytes of payload (zeros)
};

struct Hello {
  int64_t session = 0;
  uint64_t experiment_hash = 0;
  int64_t incarnation = 0;
  int64_t transitions = 0;
  int32_t protocol = kProtocolVersion;
  int32_t actor_id = 0;
  int32_t generation = 0;
  int32_t num_vehicles = 0;
  int32_t observation_size = 0;
  std::string git_revision;
  std::string isa;
};

/// A piece of a vehicle's state, as an actor saves it at the end of a round and another takes it up again.
struct VehicleStatePiece {
  int32_t vehicle = 0;
  int64_t steps = 0;  ///< transitions of the vehicle since the run's start
  int32_t total = 0;  ///< bytes of the whole state
  int32_t offset = 0;
  Bytes data;
};

struct Welcome {
  enum class Status : int8_t { kAccepted = 0, kRefused = 1, kIdTaken = 2, kUnknown = 3 };
  int64_t incarnation = 0;
  int64_t session = 0;
  int64_t assignment = 0;
  int64_t received = 0;
  Status status = Status::kAccepted;
  std::vector<int32_t> vehicle;
  std::vector<int32_t> next_episode;
  std::vector<int64_t> steps_done;
  std::vector<int32_t> state_bytes;
  std::string reason;
};

struct AssignedState {
  int64_t incarnation = 0;
  int64_t session = 0;
  int64_t assignment = 0;
  VehicleStatePiece piece;
};

struct ActorStatus {
  int64_t session = 0;
  int64_t assignment = 0;
  int64_t round = 0;
  int64_t policy_version = -1;
  int64_t wanted_policy_version = -1;
  int64_t last_sequence = 0;
  int64_t sent = 0;
  int64_t resent = 0;
  int64_t wait_us = 0;
  int64_t round_trip_us = 0;
  int32_t actor_id = 0;
  bool leaving = false;
};

struct Experience {
  int64_t send_us = 0;  ///< stamped at each (re)send, echoed in control for round-trip estimates
  int64_t session = 0;
  int64_t sequence = 0;
  int64_t policy_incarnation = 0;
  int32_t actor_id = 0;
  int32_t observation_size = 0;
  int32_t action_size = 0;
  std::vector<Segment> segments;
  std::vector<EpisodeResult> episodes;
  std::vector<VehicleStatePiece> states;
};

/// Sequence numbers first … last of a stream.
struct SequenceRange {
  int64_t first = 0;
  int64_t last = 0;
};

struct Control {
  enum class Phase : int8_t { kStarting = 0, kRunning = 1, kFinished = 2 };
  struct Actor {
    int32_t actor_id = 0;
    int64_t session = 0;
    int64_t received = 0;
    int64_t durable = 0;
    int64_t credit = 0;
    int64_t window = 0;
    int64_t echo_us = 0;
    int32_t evaluation_first = 0;
    int32_t evaluation_count = 0;
    std::vector<SequenceRange> gaps;  ///< of its stream, ascending
  };
  struct Round {
    int64_t round = 0;
    int64_t vehicle_steps = 0;
    int32_t extra = 0;
    int64_t policy_version = 0;
    bool warm_up = false;
    bool save = false;

    /// Transitions that a vehicle has made since the run's start when this round is complete.
    int64_t Target(int32_t vehicle) const { return vehicle_steps + (vehicle < extra ? 1 : 0); }
  };
  int64_t utime = 0;
  int64_t incarnation = 0;
  int64_t number = 0;
  uint64_t roadmap_hash = 0;
  uint64_t table_hash = 0;
  Phase phase = Phase::kStarting;
  bool lockstep = true;
  bool warm_up = false;
  int64_t policy_version = 0;
  std::vector<Round> rounds;
  int64_t evaluation_id = 0;
  int64_t evaluation_version = 0;
  StartSet evaluation_set = StartSet::kTraining;
  std::vector<Actor> actors;
};

struct PolicyChunk {
  int64_t incarnation = 0;
  int64_t version = 0;
  uint32_t parameters_crc = 0;
  int32_t total = 0;
  int32_t offset = 0;
  std::vector<float> parameters;
};

struct TableRequest {
  int64_t session = 0;
  uint64_t experiment_hash = 0;
  uint64_t hash = 0;
  int32_t first_chunk = 0;
  int32_t num_chunks = 0;
  std::optional<WorldGoal> goal;  ///< of the table that is asked for, instead of a hash
};

struct TableInfo {
  uint64_t experiment_hash = 0;
  uint64_t roadmap_hash = 0;
  uint64_t table_hash = 0;
  int32_t roadmap_bytes = 0;
  int32_t table_bytes = 0;
  int32_t num_vertices = 0;
  int32_t num_edges = 0;
  double coverage = 0;
  double max_cost = 0;
  double build_s = 0;
  std::optional<WorldGoal> goal;  ///< that was asked for; none: the experiment's
};

struct TableChunk {
  uint64_t hash = 0;
  int32_t total_bytes = 0;
  int32_t chunk = 0;
  int32_t chunk_bytes = 0;
  std::vector<uint8_t> data;
};

struct LearnerTelemetry {
  int64_t env_steps = 0;
  int64_t total_env_steps = 0;
  int64_t eval_steps = 0;
  int64_t updates = 0;
  int64_t policy_version = 0;
  int64_t consumption_env_steps = -1;
  int64_t transitions_duplicate = 0;
  int64_t frames_refused = 0;
  int64_t messages_sent = 0;
  int64_t messages_resent = 0;
  int32_t num_actors = 0;
  int32_t replay_size = 0;
  int32_t consumption_solved = -1;
  double env_steps_per_s = 0;
  double updates_per_s = 0;
  double success_rate = 0;
  double training_success_rate = 0;
  double episode_return = 0;
  double critic_loss = 0;
  double actor_loss = 0;
  double alpha = 0;
  double policy_lag = 0;
  double stream_latency = 0;
  double credit_wait = 0;
  double wall_s = 0;
  std::string warning;
  std::string phase;
};

struct ActorTelemetry {
  int64_t env_steps = 0;
  int64_t eval_steps = 0;
  int64_t episodes = 0;
  int64_t policy_version = 0;
  int64_t sent_messages = 0;
  int64_t resent_messages = 0;
  int32_t actor_id = 0;
  int32_t num_vehicles = 0;
  double env_steps_per_s = 0;
  double busy = 0;
  std::array<float, 4> pose{};
  float d_min = 0;
};

struct PlannerTelemetry {
  uint64_t roadmap_hash = 0;
  uint64_t table_hash = 0;
  int64_t requests = 0;
  int64_t chunks_sent = 0;
  int32_t num_vertices = 0;
  int32_t num_edges = 0;
  double coverage = 0;
  double max_cost = 0;
};

/// What a robot measures at one moment.
struct RobotState {
  int64_t utime = 0;
  std::array<double, 4> pose{};      ///< x, y, z [m], yaw [rad]
  std::array<double, 4> velocity{};  ///< forward, left, up [m/s], yaw rate [rad/s]
  double angle_min = 0;
  double angle_step = 0;
  std::vector<float> ranges;
};

/// What a robot is to do now.
struct RobotCommand {
  enum class Mode : int8_t { kDrive = 0, kArrived = 1, kStop = 2 };
  int64_t utime = 0;
  int64_t state_utime = 0;
  double valid = 0;
  double way_to_go = -1;
  Mode mode = Mode::kStop;
  std::vector<double> command;
  std::string note;
};

}  // namespace cairn
