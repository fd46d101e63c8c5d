#include "common/config/resolve.h"

#include <algorithm>
#include <cmath>

#include "common/config/experiment.h"

namespace cairn::config {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;

// Derived lengths in radii of the vehicle: one recipe for robots of any size. On the paper's car (circumscribed
// 0.0430 m, inscribed 0.025 m) they give the metres with which the recipe was found (docs/recipes.md).
constexpr double kEtaRadii = 2.3;       // 0.099 m
constexpr double kPlanningRadii = 1.2;  // of the inscribed radius: 0.030 m
constexpr double kGridCellEtas = 0.25;  // of eta: 0.025 m
constexpr double kLeastMaxSamples = 2e6;
constexpr double kSamplesPerCell = 1000;  // of side eta; a floor of 40 x 40 m took 106
constexpr double kMostMaxSamples = 2e9;
constexpr double kScanRangeRadii = 9.3;            // 0.400 m
constexpr double kLookAheadNearRadii = 2.8;        // 0.120 m
constexpr double kLookAheadFarRadii = 7.0;         // 0.301 m
constexpr double kRayScaleRadii = 1.4;             // 0.060 m
constexpr double kLookAheadClearanceRadii = 0.35;  // 0.015 m
constexpr double kSafetyMarginRadii = 0.05;        // 0.002 m
constexpr double kPersonRadii = 0.25;              // 0.011 m
constexpr double kPersonLengths = 0.5;             // 0.035 m/s
constexpr double kSafetyPeriod = 1.0 / 60;         // [s]
constexpr double kMovePerActionRadii = 2.3;        // 0.1 s at 1 m/s
constexpr double kTurnPerAction = 0.7;             // [rad]

// What a vehicle is when nothing is said of it (paper, Experimental Setup; MEASURED, section 2).
constexpr double kCarLength = 0.070, kCarWidth = 0.050, kCarSpeed = 1.0;
constexpr double kQuadrotorRadius = 0.045, kQuadrotorSpeed = 1.5;
constexpr double kQuadrupedLength = 0.060, kQuadrupedWidth = 0.030, kQuadrupedSpeed = 0.3;
constexpr double kRepairRadii = 0.5;         // 0.022 m
constexpr double kGoalToleranceRadii = 1.2;  // 0.052 m
constexpr double kGoalDistanceRadii = 12;    // 0.516 m
constexpr double kPointToleranceRadii = 3;   // 0.129 m; the paper's own square has 0.160 m

constexpr double kMazeFieldParts = 3;       // field nodes on an inscribed radius, of mazes
constexpr double kCubeFieldParts = 4;       // of cubes
constexpr double kMapFieldParts = 5;        // of maps
constexpr double kMapFieldNodes = 1 << 25;  // 128 MiB of floats in each process

void SetDefault(Message* message, const FieldDescriptor* field) {
  const Reflection* reflection = message->GetReflection();
  switch (field->cpp_type()) {
    case FieldDescriptor::CPPTYPE_BOOL:
      return reflection->SetBool(message, field, field->default_value_bool());
    case FieldDescriptor::CPPTYPE_INT32:
      return reflection->SetInt32(message, field, field->default_value_int32());
    case FieldDescriptor::CPPTYPE_INT64:
      return reflection->SetInt64(message, field, field->default_value_int64());
    case FieldDescriptor::CPPTYPE_UINT32:
      return reflection->SetUInt32(message, field, field->default_value_uint32());
    case FieldDescriptor::CPPTYPE_UINT64:
      return reflection->SetUInt64(message, field, field->default_value_uint64());
    case FieldDescriptor::CPPTYPE_FLOAT:
      return reflection->SetFloat(message, field, field->default_value_float());
    case FieldDescriptor::CPPTYPE_DOUBLE:
      return reflection->SetDouble(message, field, field->default_value_double());
    case FieldDescriptor::CPPTYPE_ENUM:
      return reflection->SetEnum(message, field, field->default_value_enum());
    case FieldDescriptor::CPPTYPE_STRING:
      return reflection->SetString(message, field, field->default_value_string());
    case FieldDescriptor::CPPTYPE_MESSAGE:
      return;
  }
}

void FillDefaults(Message* message);

void FillField(Message* message, const FieldDescriptor* field) {
  const Reflection* reflection = message->GetReflection();
  // Regions and points of the world are not invented.
  const bool is_place =
      field->message_type() == proto::Box::descriptor() ||
      (field->message_type() == proto::Vector3::descriptor() && field->containing_type() == proto::World::descriptor());
  if (field->is_repeated()) {
    if (field->message_type() == nullptr) return;
    for (int i = 0; i < reflection->FieldSize(*message, field); ++i) {
      FillDefaults(reflection->MutableRepeatedMessage(message, field, i));
    }
  } else if (field->message_type() != nullptr) {
    if (!is_place || reflection->HasField(*message, field)) FillDefaults(reflection->MutableMessage(message, field));
  } else if (field->has_default_value() && !reflection->HasField(*message, field)) {
    SetDefault(message, field);
  }
}

void FillDefaults(Message* message) {
  for (int i = 0; i < message->GetDescriptor()->field_count(); ++i)
    FillField(message, message->GetDescriptor()->field(i));
}

void DeriveFootprint(proto::Vehicle* vehicle) {
  if (vehicle->kind() == proto::Vehicle::QUADROTOR && vehicle->radius() == 0) vehicle->set_radius(kQuadrotorRadius);
  const bool quadruped = vehicle->kind() == proto::Vehicle::QUADRUPED;
  const bool disc = vehicle->radius() > 0;
  const double side = std::sqrt(2.0) * vehicle->radius();
  if (!vehicle->has_length()) vehicle->set_length(disc ? side : quadruped ? kQuadrupedLength : kCarLength);
  if (!vehicle->has_width()) vehicle->set_width(disc ? side : quadruped ? kQuadrupedWidth : kCarWidth);
  if (!vehicle->has_radius()) vehicle->set_radius(0);
  if (!vehicle->has_wheel_base()) vehicle->set_wheel_base(0.6 * vehicle->length());
}

VehicleConfig DeriveVehicle(proto::Vehicle* vehicle) {
  DeriveFootprint(vehicle);
  VehicleConfig config;
  config.kind = static_cast<VehicleConfig::Kind>(vehicle->kind());
  config.length = vehicle->length();
  config.width = vehicle->width();
  config.radius = vehicle->radius();
  if (!vehicle->has_max_speed()) {
    const bool quadruped = vehicle->kind() == proto::Vehicle::QUADRUPED;
    vehicle->set_max_speed(config.dimension() == 3 ? kQuadrotorSpeed : quadruped ? kQuadrupedSpeed : kCarSpeed);
  }
  if (!vehicle->has_min_speed()) vehicle->set_min_speed(config.holonomic() ? -vehicle->max_speed() : 0);
  proto::Scan* scan = vehicle->mutable_scan();
  if (!scan->has_beams()) scan->set_beams(config.dimension() == 3 ? 14 : 16);
  if (!scan->has_range()) scan->set_range(kScanRangeRadii * config.circumscribed_radius());
  return config;
}

// A vehicle at top speed moves by about two of its radii between two actions, and turns by less than kTurnPerAction.
void DeriveEnvironment(const VehicleConfig& config, const proto::Vehicle& vehicle, proto::Environment* environment) {
  if (!environment->has_physics_rate_hz()) {
    environment->set_physics_rate_hz(config.kind == VehicleConfig::Kind::kQuadruped ? 120 : 240);
  }
  if (environment->has_control_period()) return;
  double period = kMovePerActionRadii * config.circumscribed_radius() / vehicle.max_speed();
  if (config.kind != VehicleConfig::Kind::kAckermann && config.turns()) {
    period = std::min(period, kTurnPerAction / vehicle.max_yaw_rate());
  }
  const double rate = environment->physics_rate_hz();
  environment->set_control_period(std::max(1.0, std::round(std::clamp(period, 0.004, 10.0) * rate)) / rate);
}

// A map's own cell or the largest whole part of it whose diagonal is at most r_ball = eta / 2. One of eta would do in
// the open, but beside walls the nearest free centre is farther than half a diagonal.
double GridCell(const ImportedMap* map, double eta) {
  if (map == nullptr || map->cell == 0) return kGridCellEtas * eta;
  return map->cell / std::max(1.0, std::ceil(2 * map->cell * std::sqrt(map->dimension) / eta - 1e-9));
}

// Sides of the world [m]; z is not above 0 in the plane.
Vector3d SizeOf(const ImportedMap* map, const proto::World& world) {
  const double pitch = world.corridor_width() + world.wall_thickness();
  const double maze = world.cells() * pitch + world.wall_thickness(), cube = world.rooms() * world.room_size();
  const proto::Vector3 &min = world.bounds().min(), &max = world.bounds().max();
  switch (world.kind()) {
    case proto::World::CAR_MAZE:
      return {maze, maze, 0};
    case proto::World::CUBE_MAZE:
      return {cube, cube, world.floors() * world.room_size()};
    case proto::World::BOXES:
      return {max.x() - min.x(), max.y() - min.y(), max.z() - min.z()};
    case proto::World::MAP:
      break;
  }
  return {map->bounds.size().x(), map->bounds.size().y(), map->dimension == 3 ? map->bounds.size().z() : 0};
}

double MaxSamples(const Vector3d& size, double eta) {
  const Vector3d cells = size / eta;
  const double count = cells.x() * cells.y() * (cells.z() > 0 ? cells.z() : 1);
  return std::clamp(kSamplesPerCell * count, kLeastMaxSamples, kMostMaxSamples);
}

void DerivePlanner(const VehicleConfig& vehicle, const ImportedMap* map, const proto::World& world,
                   proto::Planner* planner) {
  const double circumscribed = vehicle.circumscribed_radius(), inscribed = vehicle.inscribed_radius();
  if (!planner->has_eta()) planner->set_eta(kEtaRadii * circumscribed);
  if (!planner->has_radius()) planner->set_radius(kPlanningRadii * inscribed);
  if (!planner->has_min_spacing()) planner->set_min_spacing(0.5 * planner->eta());
  if (!planner->has_max_samples()) {
    planner->set_max_samples(static_cast<int>(MaxSamples(SizeOf(map, world), planner->eta())));
  }
  if (!planner->has_grid_cell()) planner->set_grid_cell(GridCell(map, planner->eta()));
  if (!planner->has_grid_neighbors()) planner->set_grid_neighbors(vehicle.dimension() == 3 ? 26 : 8);
  if (!planner->has_repair_margin()) planner->set_repair_margin(kRepairRadii * circumscribed);
  if (!planner->has_repair_mark_radius()) planner->set_repair_mark_radius(kRepairRadii * circumscribed);
}

void DeriveObservation(double circumscribed, proto::Observation* observation) {
  if (!observation->has_look_ahead_near()) observation->set_look_ahead_near(kLookAheadNearRadii * circumscribed);
  if (!observation->has_look_ahead_far()) observation->set_look_ahead_far(kLookAheadFarRadii * circumscribed);
  if (!observation->has_ray_scale()) observation->set_ray_scale(kRayScaleRadii * circumscribed);
  if (!observation->has_look_ahead_clearance()) {
    observation->set_look_ahead_clearance(kLookAheadClearanceRadii * circumscribed);
  }
}

// The coarsest whole part of a cell that resolves the robot, so that the field's nodes lie on the cells' edges; coarser
// again, down to the cell, where that would take too many nodes.
double MapFieldResolution(const ImportedMap& map, double inscribed) {
  const Vector3d size = map.bounds.size();
  const double volume = size.x() * size.y() * (map.dimension == 3 ? size.z() : 1);
  const double finest = std::pow(volume / kMapFieldNodes, 1.0 / map.dimension);
  if (map.cell == 0) return std::max(inscribed / 10, finest);
  const double parts = std::ceil(map.cell / (inscribed / kMapFieldParts) - 1e-9);
  return map.cell / std::max(1.0, std::min(parts, std::floor(map.cell / finest)));
}

// Resolves a maze's walls, and the robot where they are thicker than it.
double FieldResolution(double inscribed, const ImportedMap* map, const proto::World& world) {
  if (map != nullptr) return MapFieldResolution(*map, inscribed);
  const double wall = world.wall_thickness();
  if (world.kind() == proto::World::CAR_MAZE) return std::min(wall / 4, inscribed / kMazeFieldParts);
  if (world.kind() == proto::World::CUBE_MAZE) return std::min(wall / 2, inscribed / kCubeFieldParts);
  return inscribed / 10;
}

void DeriveWorld(double circumscribed, double inscribed, const ImportedMap* map, proto::World* world) {
  if ((world->has_goal_point() || world->has_start_point()) && !world->has_point_tolerance()) {
    world->set_point_tolerance(kPointToleranceRadii * circumscribed);
  }
  if (!world->has_goal_tolerance()) world->set_goal_tolerance(kGoalToleranceRadii * circumscribed);
  if (!world->has_goal_distance()) world->set_goal_distance(kGoalDistanceRadii * circumscribed);
  if (!world->has_field_resolution()) world->set_field_resolution(FieldResolution(inscribed, map, *world));
}

void DerivePersons(const VehicleConfig& config, proto::World* world) {
  const double length = config.radius > 0 ? 2 * config.radius : config.length;
  if (!world->has_person_radius()) world->set_person_radius(kPersonRadii * config.circumscribed_radius());
  if (!world->has_person_speed()) world->set_person_speed(kPersonLengths * length);
}

void DeriveSafety(const VehicleConfig& config, double physics_rate, proto::Safety* safety) {
  if (!safety->has_margin()) safety->set_margin(kSafetyMarginRadii * config.circumscribed_radius());
  if (!safety->has_beams()) safety->set_beams(config.dimension() == 3 ? 256 : 180);
  if (!safety->has_period()) safety->set_period(std::max(1.0, std::round(kSafetyPeriod * physics_rate)) / physics_rate);
}

void DeriveLearner(int action_size, proto::Learner* learner) {
  if (learner->net_arch().empty()) {
    learner->add_net_arch(64);
    learner->add_net_arch(64);
  }
  if (!learner->has_target_entropy()) learner->set_target_entropy(-action_size);
}

}  // namespace

void Resolve(Draft* draft, const ImportedMap* map) {
  proto::Experiment& experiment = draft->message;
  FillDefaults(&experiment);
  if (map == nullptr) experiment.mutable_world()->clear_unknown_is_free();  // what is not read is not part of the hash
  const VehicleConfig vehicle = DeriveVehicle(experiment.mutable_vehicle());
  const double circumscribed = vehicle.circumscribed_radius();
  const double inscribed = vehicle.inscribed_radius();
  DeriveEnvironment(vehicle, experiment.vehicle(), experiment.mutable_environment());
  DerivePlanner(vehicle, map, experiment.world(), experiment.mutable_planner());
  DeriveObservation(circumscribed, experiment.mutable_observation());
  if (!experiment.world().has_unseen_obstacle_size()) {
    experiment.mutable_world()->set_unseen_obstacle_size(circumscribed);
  }
  DerivePersons(vehicle, experiment.mutable_world());
  DeriveSafety(vehicle, experiment.environment().physics_rate_hz(), experiment.mutable_safety());
  DeriveWorld(circumscribed, inscribed, map, experiment.mutable_world());
  DeriveLearner(vehicle.action_size(), experiment.mutable_learner());
}

}  // namespace cairn::config
