#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace cairn {

struct ImportedMap;  // common/world/import/import_map.h

// Plain mirror of experiment.proto, which holds defaults, units, ranges and reasons. All derived values are filled in
// by the loader (common/config/load.h) except those that need the roadmap, which are 0 until then.

enum class Schedule { kLockstep, kAsync };
enum class Goals { kWorld, kAny };

/// Axis-aligned region [m]; in a plane world z is ignored.
struct BoxConfig {
  std::array<double, 3> min{};
  std::array<double, 3> max{};

  bool operator==(const BoxConfig&) const = default;
};

/// Upright cylinder [m]; in a plane world a disc.
struct CylinderConfig {
  std::array<double, 3> base{};
  double radius = 0;
  double height = 1;

  bool operator==(const CylinderConfig&) const = default;
};

/// Where a map is and how it is read; unset: as the format has it.
struct MapConfig {
  std::string file;  ///< as read: relative to the working directory
  std::string hash;
  bool unknown_is_free = false;
  std::optional<double> resolution;
  std::optional<double> slice_min;
  std::optional<double> slice_max;

  bool operator==(const MapConfig&) const = default;
};

struct WorldConfig {
  enum class Kind { kCarMaze, kBoxes, kMap, kCubeMaze };
  Kind kind = Kind::kCarMaze;
  uint64_t seed = 1;
  int cells = 12;
  double corridor_width = 0.14;
  double wall_thickness = 0.02;
  double loop_fraction = 0.15;
  double square = 0.32;
  BoxConfig bounds;
  std::vector<BoxConfig> obstacles;
  std::vector<CylinderConfig> cylinders;
  BoxConfig start;  ///< empty: see start_point; of a map: everywhere
  BoxConfig goal;   ///< empty: see goal_point
  std::optional<std::array<double, 3>> start_point;
  std::optional<std::array<double, 3>> goal_point;
  double point_tolerance = 0.13;
  double field_resolution = 0.005;
  int floors = 4;
  int rooms = 4;
  double room_size = 0.25;
  double door_size = 0.16;
  double shaft_size = 0.18;
  std::vector<int> blocked_doors;
  int random_blocked_doors = 0;
  bool blocked_known = false;
  enum class BlockedWhen { kAlways, kEvaluation };
  BlockedWhen blocked_when = BlockedWhen::kAlways;
  int unseen_obstacles = 0;
  double unseen_obstacle_size = 0.043;
  int training_worlds = 1;
  int unseen_worlds = 0;
  int goals_per_world = 32;
  double goal_tolerance = 0.052;
  double goal_distance = 0.516;
  int persons = 0;
  double person_radius = 0.01075;
  double person_speed = 0.035;
  BlockedWhen persons_when = BlockedWhen::kEvaluation;
  MapConfig map;
  /// Worlds of training and evaluation together: those of seeds seed … seed + num_worlds() − 1.
  int num_worlds() const { return training_worlds + unseen_worlds; }

  std::shared_ptr<const ImportedMap> imported;  ///< kMap: what the map says; read once, by the loader

  bool operator==(const WorldConfig&) const = default;
};

struct ScanConfig {
  int beams = 16;
  double field_of_view = 6.283185307179586;
  double range = 0.4;
  double mount_x = 0.0;

  bool operator==(const ScanConfig&) const = default;
};

/// Limits of one command.
struct CommandRange {
  double min = -1;
  double max = 1;
};

/// No vehicle takes more commands.
constexpr int kMaxActionSize = 3;

struct VehicleConfig {
  enum class Kind { kWheeledCar, kPlaneCar, kHolonomic, kAckermann, kQuadrotor, kQuadruped };
  Kind kind = Kind::kWheeledCar;
  double length = 0.070;
  double width = 0.050;
  double radius = 0;  ///< > 0: the footprint is a disc (in space a sphere)
  double min_speed = 0.0;
  double max_speed = 1.0;
  double max_yaw_rate = 2.0;
  double lag = 0.05;
  double max_acceleration = 0.0;
  double command_exponent = 1.0;
  double max_steering = 0.6;
  double wheel_base = 0.042;
  ScanConfig scan;

  /// Radius of the largest disc inside the footprint [m].
  double inscribed_radius() const;
  /// Radius of the smallest disc around the footprint [m].
  double circumscribed_radius() const;
  /// 2: drives in the plane, 3: flies.
  int dimension() const { return kind == Kind::kQuadrotor ? 3 : 2; }
  /// Moves along all axes alike: commands are velocities, not speed and turn.
  bool holonomic() const { return kind == Kind::kHolonomic || kind == Kind::kQuadrotor; }
  /// Whether its yaw changes.
  bool turns() const { return kind != Kind::kQuadrotor; }
  /// Number of actions, each in [−1, 1] over the range of its command.
  int action_size() const { return holonomic() ? 3 : 2; }
  /// Fastest turn [rad/s]: max_yaw_rate, of ACKERMANN what top speed makes of the largest steering angle.
  double top_yaw_rate() const;
  /// Limits of the commands in order (m/s, rad/s, rad); see Vehicle.Kind in experiment.proto.
  std::array<CommandRange, kMaxActionSize> command_ranges() const;

  bool operator==(const VehicleConfig&) const = default;
};

struct PlannerConfig {
  enum class Kind { kRrg, kPrmStar, kRrt, kRrtStar, kGrid };
  Kind kind = Kind::kRrg;
  double eta = 0.1;
  double radius = 0.03;
  double min_spacing = 0.05;
  double coverage = 0.999;
  int max_samples = 2000000;
  uint64_t seed = 1;
  double grid_cell = 0.025;
  int grid_neighbors = 8;
  int path_samples = 20000;
  std::string roadmap;  ///< file to read; empty: none, build one
  enum class Repair { kNone, kContacts, kRays };
  Repair repair = Repair::kNone;
  double repair_margin = 0.0215;
  double repair_mark_radius = 0.0215;
  double repair_lifetime = 8;
  bool repair_kept = false;
  int table_cache_mb = 64;

  /// Paper: r = eta / 2 [m].
  double r_ball() const { return 0.5 * eta; }

  bool operator==(const PlannerConfig&) const = default;
};

struct EnvironmentConfig {
  enum class Start { kUniform, kStartRegion, kCostToGo };
  double control_period = 0.1;
  double physics_rate_hz = 240;
  int max_episode_steps = 0;  ///< 0: derived from the roadmap, see EpisodeSteps
  Start start = Start::kUniform;
  double retry_failed_start = 0.5;
  double speed_disturbance = 0.1;
  double yaw_rate_disturbance = 0.2;
  double disturbance_hold = 0.2;
  double observation_noise = 0.0;
  int action_delay_steps = 0;
  double parameter_spread = 0.0;
  double action_delay = 0.0;
  double action_delay_spread = 0.0;
  double slip = 0.0;
  double footprint_scale = 1.0;
  double footprint_spread = 0.0;

  /// The most that a footprint can exceed the vehicle's own.
  double largest_footprint() const { return footprint_scale * (1 + footprint_spread); }

  bool operator==(const EnvironmentConfig&) const = default;
};

struct ObservationConfig {
  bool position = false;
  bool heading = true;
  bool velocity = true;
  bool d_min = true;
  bool look_ahead = true;
  bool rays = true;
  double look_ahead_near = 0.12;
  double look_ahead_far = 0.30;
  double ray_scale = 0.06;
  double look_ahead_clearance = 0.015;
  double pose_noise = 0.0;
  double heading_noise = 0.0;
  double pose_jump = 0.0;
  double heading_jump = 0.0;
  double pose_jump_interval = 5.0;
  double pose_filter = 0.0;
  double range_noise = 0.0;
  double range_dropout = 0.0;
  int last_actions = 0;

  bool operator==(const ObservationConfig&) const = default;
};

struct RewardConfig {
  enum class Kind { kGraph, kSparse, kEuclidean };
  Kind kind = Kind::kGraph;
  double progress_reward = 1.0;
  double goal_reward = 10.0;
  double collision_reward = -2.0;
  double step_reward = 0.0;

  bool operator==(const RewardConfig&) const = default;
};

struct LearnerConfig {
  enum class Algorithm { kSac, kTd3 };
  Algorithm algorithm = Algorithm::kSac;
  std::vector<int> net_arch{64, 64};
  bool layer_norm = false;
  double learning_rate = 1e-3;
  double final_learning_rate_fraction = 1.0;
  int batch_size = 256;
  int buffer_size = 500000;
  int learning_starts = 5000;
  double gamma = 0.99;
  double tau = 0.005;
  int train_freq = 10;
  int gradient_steps = 1;
  int n_steps = 3;
  double initial_alpha = 0.1;
  bool auto_alpha = true;
  double target_entropy = -2.0;
  int policy_delay = 2;
  double target_policy_noise = 0.2;
  double target_noise_clip = 0.5;
  double action_noise = 0.1;
  double max_grad_norm = 0.0;
  std::string init_from;
  double checkpoint_interval_s = 30.0;
  int checkpoints_kept = 2;
  int max_bad_updates = 10;
  enum class OnCollapse { kContinue, kRevertToBest };
  OnCollapse on_collapse = OnCollapse::kContinue;
  int collapse_checks = 3;
  int update_threads = 1;

  bool operator==(const LearnerConfig&) const = default;
};

struct LockstepConfig {
  int round_steps = 10;
  bool overlap = true;
  double actor_timeout_s = 60.0;

  bool operator==(const LockstepConfig&) const = default;
};

struct AsyncConfig {
  int error_buffer = 2000;

  bool operator==(const AsyncConfig&) const = default;
};

struct EvaluationConfig {
  int64_t interval_env_steps = 10000;
  int max_steps = 0;  ///< 0: derived from the roadmap, see EvaluationSteps
  int consumption_starts = 10;
  int validation_starts = 50;
  int test_starts = 200;
  int validation_every = 4;

  bool operator==(const EvaluationConfig&) const = default;
};

struct TransportConfig {
  std::string group = "239.255.76.67";
  int base_port = 7700;
  int ttl = 0;
  std::string broker;            ///< "HOST:PORT" of LCM's TCP broker, which carries all planes; empty: UDP multicast
  std::string telemetry_broker;  ///< of another one for telemetry alone; empty: `broker`

  /// Whether other hosts can take part, so that messages need a key: ttl ≥ 1, or a broker that is not on loopback.
  bool leaves_host() const;

  bool operator==(const TransportConfig&) const = default;
};

struct SafetyConfig {
  enum class Filter { kOff, kEvaluation, kAlways };
  Filter filter = Filter::kOff;
  double margin = 0.0021;
  int beams = 180;
  double period = 1.0 / 60;
  double stopping_distance = 0.0;  ///< 0: measured, see BrakingTable
  double caution = 1.3;

  bool operator==(const SafetyConfig&) const = default;
};

struct Experiment {
  std::string name = "experiment";
  Schedule schedule = Schedule::kLockstep;
  int64_t total_env_steps = 250000;
  int num_vehicles = 32;
  uint64_t seed = 1;
  Goals goals = Goals::kWorld;
  WorldConfig world;
  VehicleConfig vehicle;
  PlannerConfig planner;
  EnvironmentConfig environment;
  ObservationConfig observation;
  RewardConfig reward;
  LearnerConfig learner;
  LockstepConfig lockstep;
  AsyncConfig async;
  EvaluationConfig evaluation;
  TransportConfig transport;
  SafetyConfig safety;

  bool operator==(const Experiment&) const = default;
};

/// Number of entries of an observation under this experiment.
int ObservationSize(const Experiment& experiment);

/// Steps of a training episode: the configured number, or six times what `max_cost` [m], the roadmap's longest finite
/// cost-to-go, takes at top speed.
int EpisodeSteps(const Experiment& experiment, double max_cost);

/// Steps after which an evaluation episode has failed: the configured number or twice EpisodeSteps.
int EvaluationSteps(const Experiment& experiment, double max_cost);

}  // namespace cairn
