#include "common/config/from_proto.h"

namespace cairn::config {
namespace {

// The enums of both sides have the same values in the same order; a new one must be added to both.
template <typename To, typename From>
To ConvertEnum(From value) {
  return static_cast<To>(static_cast<int>(value));
}
static_assert(proto::ASYNC == static_cast<int>(Schedule::kAsync) && proto::Schedule_MAX == proto::ASYNC);
static_assert(proto::Experiment::ANY == static_cast<int>(Goals::kAny) &&
              proto::Experiment::Goals_MAX == proto::Experiment::ANY);
static_assert(proto::World::BOXES == static_cast<int>(WorldConfig::Kind::kBoxes) &&
              proto::World::MAP == static_cast<int>(WorldConfig::Kind::kMap) &&
              proto::World::CUBE_MAZE == static_cast<int>(WorldConfig::Kind::kCubeMaze) &&
              proto::World::Kind_MAX == proto::World::CUBE_MAZE);
static_assert(proto::World::EVALUATION == static_cast<int>(WorldConfig::BlockedWhen::kEvaluation) &&
              proto::World::BlockedWhen_MAX == proto::World::EVALUATION);
static_assert(proto::Vehicle::HOLONOMIC == static_cast<int>(VehicleConfig::Kind::kHolonomic) &&
              proto::Vehicle::QUADRUPED == static_cast<int>(VehicleConfig::Kind::kQuadruped) &&
              proto::Vehicle::Kind_MAX == proto::Vehicle::QUADRUPED);
static_assert(proto::Planner::RRG == static_cast<int>(PlannerConfig::Kind::kRrg) &&
              proto::Planner::PRM_STAR == static_cast<int>(PlannerConfig::Kind::kPrmStar) &&
              proto::Planner::RRT == static_cast<int>(PlannerConfig::Kind::kRrt) &&
              proto::Planner::RRT_STAR == static_cast<int>(PlannerConfig::Kind::kRrtStar) &&
              proto::Planner::GRID == static_cast<int>(PlannerConfig::Kind::kGrid) &&
              proto::Planner::Kind_MAX == proto::Planner::GRID);
static_assert(proto::Planner::RAYS == static_cast<int>(PlannerConfig::Repair::kRays) &&
              proto::Planner::Repair_MAX == proto::Planner::RAYS);
static_assert(proto::Environment::COST_TO_GO == static_cast<int>(EnvironmentConfig::Start::kCostToGo) &&
              proto::Environment::Start_MAX == proto::Environment::COST_TO_GO);
static_assert(proto::Reward::SPARSE == static_cast<int>(RewardConfig::Kind::kSparse) &&
              proto::Reward::EUCLIDEAN == static_cast<int>(RewardConfig::Kind::kEuclidean) &&
              proto::Reward::Kind_MAX == proto::Reward::EUCLIDEAN);
static_assert(proto::Safety::EVALUATION == static_cast<int>(SafetyConfig::Filter::kEvaluation) &&
              proto::Safety::Filter_MAX == proto::Safety::ALWAYS);
static_assert(proto::Learner::TD3 == static_cast<int>(LearnerConfig::Algorithm::kTd3) &&
              proto::Learner::Algorithm_MAX == proto::Learner::TD3);

std::array<double, 3> Vector(const proto::Vector3& message) { return {message.x(), message.y(), message.z()}; }

BoxConfig Box(const proto::Box& message) { return {Vector(message.min()), Vector(message.max())}; }

MapConfig Map(const proto::World& message) {
  MapConfig map;
  map.file = message.map();
  map.hash = message.map_hash();
  map.unknown_is_free = message.unknown_is_free();
  if (message.has_map_resolution()) map.resolution = message.map_resolution();
  if (message.has_slice_min()) map.slice_min = message.slice_min();
  if (message.has_slice_max()) map.slice_max = message.slice_max();
  return map;
}

WorldConfig World(const proto::World& message) {
  WorldConfig world;
  world.kind = ConvertEnum<WorldConfig::Kind>(message.kind());
  world.seed = message.seed();
  world.cells = message.cells();
  world.corridor_width = message.corridor_width();
  world.wall_thickness = message.wall_thickness();
  world.loop_fraction = message.loop_fraction();
  world.square = message.square();
  world.bounds = Box(message.bounds());
  for (const proto::Box& obstacle : message.obstacles()) world.obstacles.push_back(Box(obstacle));
  for (const proto::Cylinder& cylinder : message.cylinders()) {
    world.cylinders.push_back({Vector(cylinder.base()), cylinder.radius(), cylinder.height()});
  }
  world.start = Box(message.start());
  world.goal = Box(message.goal());
  if (message.has_start_point()) world.start_point = Vector(message.start_point());
  if (message.has_goal_point()) world.goal_point = Vector(message.goal_point());
  if (message.has_point_tolerance()) world.point_tolerance = message.point_tolerance();
  world.field_resolution = message.field_resolution();
  world.floors = message.floors();
  world.rooms = message.rooms();
  world.room_size = message.room_size();
  world.door_size = message.door_size();
  world.shaft_size = message.shaft_size();
  world.blocked_doors.assign(message.blocked_doors().begin(), message.blocked_doors().end());
  world.random_blocked_doors = message.random_blocked_doors();
  world.blocked_known = message.blocked_known();
  world.blocked_when = ConvertEnum<WorldConfig::BlockedWhen>(message.blocked_when());
  world.unseen_obstacles = message.unseen_obstacles();
  world.unseen_obstacle_size = message.unseen_obstacle_size();
  world.training_worlds = message.training_worlds();
  world.unseen_worlds = message.unseen_worlds();
  world.goals_per_world = message.goals_per_world();
  world.goal_tolerance = message.goal_tolerance();
  world.goal_distance = message.goal_distance();
  world.persons = message.persons();
  world.person_radius = message.person_radius();
  world.person_speed = message.person_speed();
  world.persons_when = ConvertEnum<WorldConfig::BlockedWhen>(message.persons_when());
  world.map = Map(message);
  return world;
}

VehicleConfig Vehicle(const proto::Vehicle& message) {
  VehicleConfig vehicle;
  vehicle.kind = ConvertEnum<VehicleConfig::Kind>(message.kind());
  vehicle.length = message.length();
  vehicle.width = message.width();
  vehicle.radius = message.radius();
  vehicle.min_speed = message.min_speed();
  vehicle.max_speed = message.max_speed();
  vehicle.max_yaw_rate = message.max_yaw_rate();
  vehicle.lag = message.lag();
  vehicle.max_acceleration = message.max_acceleration();
  vehicle.command_exponent = message.command_exponent();
  vehicle.max_steering = message.max_steering();
  vehicle.wheel_base = message.wheel_base();
  vehicle.scan.beams = message.scan().beams();
  vehicle.scan.field_of_view = message.scan().field_of_view();
  vehicle.scan.range = message.scan().range();
  vehicle.scan.mount_x = message.scan().mount_x();
  return vehicle;
}

PlannerConfig Planner(const proto::Planner& message) {
  PlannerConfig planner;
  planner.kind = ConvertEnum<PlannerConfig::Kind>(message.kind());
  planner.eta = message.eta();
  planner.radius = message.radius();
  planner.min_spacing = message.min_spacing();
  planner.coverage = message.coverage();
  planner.max_samples = message.max_samples();
  planner.seed = message.seed();
  planner.grid_cell = message.grid_cell();
  planner.grid_neighbors = message.grid_neighbors();
  planner.path_samples = message.path_samples();
  planner.roadmap = message.roadmap();
  planner.repair = ConvertEnum<PlannerConfig::Repair>(message.repair());
  planner.repair_margin = message.repair_margin();
  planner.repair_mark_radius = message.repair_mark_radius();
  planner.repair_lifetime = message.repair_lifetime();
  planner.repair_kept = message.repair_kept();
  planner.table_cache_mb = message.table_cache_mb();
  return planner;
}

EnvironmentConfig Environment(const proto::Environment& message) {
  EnvironmentConfig environment;
  environment.control_period = message.control_period();
  environment.physics_rate_hz = message.physics_rate_hz();
  environment.max_episode_steps = message.max_episode_steps();
  environment.start = ConvertEnum<EnvironmentConfig::Start>(message.start());
  environment.retry_failed_start = message.retry_failed_start();
  environment.speed_disturbance = message.speed_disturbance();
  environment.yaw_rate_disturbance = message.yaw_rate_disturbance();
  environment.disturbance_hold = message.disturbance_hold();
  environment.observation_noise = message.observation_noise();
  environment.action_delay_steps = message.action_delay_steps();
  environment.parameter_spread = message.parameter_spread();
  environment.action_delay = message.action_delay();
  environment.action_delay_spread = message.action_delay_spread();
  environment.slip = message.slip();
  environment.footprint_scale = message.footprint_scale();
  environment.footprint_spread = message.footprint_spread();
  return environment;
}

ObservationConfig Observation(const proto::Observation& message) {
  ObservationConfig observation;
  observation.position = message.position();
  observation.heading = message.heading();
  observation.velocity = message.velocity();
  observation.d_min = message.d_min();
  observation.look_ahead = message.look_ahead();
  observation.rays = message.rays();
  observation.look_ahead_near = message.look_ahead_near();
  observation.look_ahead_far = message.look_ahead_far();
  observation.ray_scale = message.ray_scale();
  observation.look_ahead_clearance = message.look_ahead_clearance();
  observation.pose_noise = message.pose_noise();
  observation.heading_noise = message.heading_noise();
  observation.pose_jump = message.pose_jump();
  observation.heading_jump = message.heading_jump();
  observation.pose_jump_interval = message.pose_jump_interval();
  observation.pose_filter = message.pose_filter();
  observation.range_noise = message.range_noise();
  observation.range_dropout = message.range_dropout();
  observation.last_actions = message.last_actions();
  return observation;
}

RewardConfig Reward(const proto::Reward& message) {
  RewardConfig reward;
  reward.kind = ConvertEnum<RewardConfig::Kind>(message.kind());
  reward.progress_reward = message.progress_reward();
  reward.goal_reward = message.goal_reward();
  reward.collision_reward = message.collision_reward();
  reward.step_reward = message.step_reward();
  return reward;
}

LearnerConfig Learner(const proto::Learner& message) {
  LearnerConfig learner;
  learner.algorithm = ConvertEnum<LearnerConfig::Algorithm>(message.algorithm());
  learner.net_arch.assign(message.net_arch().begin(), message.net_arch().end());
  learner.layer_norm = message.layer_norm();
  learner.learning_rate = message.learning_rate();
  learner.final_learning_rate_fraction = message.final_learning_rate_fraction();
  learner.batch_size = message.batch_size();
  learner.buffer_size = message.buffer_size();
  learner.learning_starts = message.learning_starts();
  learner.gamma = message.gamma();
  learner.tau = message.tau();
  learner.train_freq = message.train_freq();
  learner.gradient_steps = message.gradient_steps();
  learner.n_steps = message.n_steps();
  learner.initial_alpha = message.initial_alpha();
  learner.auto_alpha = message.auto_alpha();
  learner.target_entropy = message.target_entropy();
  learner.policy_delay = message.policy_delay();
  learner.target_policy_noise = message.target_policy_noise();
  learner.target_noise_clip = message.target_noise_clip();
  learner.action_noise = message.action_noise();
  learner.max_grad_norm = message.max_grad_norm();
  learner.init_from = message.init_from();
  learner.checkpoint_interval_s = message.checkpoint_interval_s();
  learner.checkpoints_kept = message.checkpoints_kept();
  learner.max_bad_updates = message.max_bad_updates();
  learner.on_collapse = ConvertEnum<LearnerConfig::OnCollapse>(message.on_collapse());
  learner.collapse_checks = message.collapse_checks();
  learner.update_threads = message.update_threads();
  return learner;
}

// "HOST:PORT" of a checked tcpq://HOST:PORT.
std::string Broker(const std::string& url) { return url.substr(url.rfind('/') + 1); }

TransportConfig Transport(const proto::Transport& message) {
  return {message.group(), message.base_port(), message.ttl(), Broker(message.url()), Broker(message.telemetry_url())};
}

EvaluationConfig Evaluation(const proto::Evaluation& message) {
  EvaluationConfig evaluation;
  evaluation.interval_env_steps = message.interval_env_steps();
  evaluation.max_steps = message.max_steps();
  evaluation.consumption_starts = message.consumption_starts();
  evaluation.validation_starts = message.validation_starts();
  evaluation.test_starts = message.test_starts();
  evaluation.validation_every = message.validation_every();
  return evaluation;
}

SafetyConfig Safety(const proto::Safety& message) {
  SafetyConfig safety;
  safety.filter = ConvertEnum<SafetyConfig::Filter>(message.filter());
  safety.margin = message.margin();
  safety.beams = message.beams();
  safety.period = message.period();
  safety.stopping_distance = message.stopping_distance();
  safety.caution = message.caution();
  return safety;
}

}  // namespace

Experiment FromProto(const proto::Experiment& message) {
  Experiment experiment;
  experiment.name = message.name();
  experiment.schedule = ConvertEnum<Schedule>(message.schedule());
  experiment.total_env_steps = message.total_env_steps();
  experiment.num_vehicles = message.num_vehicles();
  experiment.seed = message.seed();
  experiment.goals = ConvertEnum<Goals>(message.goals());
  experiment.world = World(message.world());
  experiment.vehicle = Vehicle(message.vehicle());
  experiment.planner = Planner(message.planner());
  experiment.environment = Environment(message.environment());
  experiment.observation = Observation(message.observation());
  experiment.reward = Reward(message.reward());
  experiment.learner = Learner(message.learner());
  experiment.lockstep = {message.lockstep().round_steps(), message.lockstep().overlap(),
                         message.lockstep().actor_timeout_s()};
  experiment.async = {message.async().error_buffer()};
  experiment.evaluation = Evaluation(message.evaluation());
  experiment.transport = Transport(message.transport());
  experiment.safety = Safety(message.safety());
  return experiment;
}

}  // namespace cairn::config
