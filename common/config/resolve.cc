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
constexpr double kEtaRadii = 2.3;                  // 0.099 m
constexpr double kPlanningRadii = 1.2;             // of the inscribed radius: 0.030 m
constexpr double kScanRangeRadii = 9.3;            // 0.400 m
constexpr double kLookAheadNearRadii = 2.8;        // 0.120 m
constexpr double kLookAheadFarRadii = 7.0;         // 0.301 m
constexpr double kRayScaleRadii = 1.4;             // 0.060 m
constexpr double kLookAheadClearanceRadii = 0.35;  // 0.015 m
constexpr double kPointToleranceRadii = 3;         // 0.129 m; the paper's own square has 0.160 m

constexpr double kMapFieldParts = 5;        // field nodes on an inscribed radius, of maps
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

VehicleConfig Footprint(const proto::Vehicle& vehicle) {
  VehicleConfig footprint;
  footprint.length = vehicle.length();
  footprint.width = vehicle.width();
  return footprint;
}

void DerivePlanner(double circumscribed, double inscribed, proto::Planner* planner) {
  if (!planner->has_eta()) planner->set_eta(kEtaRadii * circumscribed);
  if (!planner->has_radius()) planner->set_radius(kPlanningRadii * inscribed);
  if (!planner->has_min_spacing()) planner->set_min_spacing(0.5 * planner->eta());
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

void DeriveWorld(double circumscribed, double inscribed, const ImportedMap* map, proto::World* world) {
  if ((world->has_goal_point() || world->has_start_point()) && !world->has_point_tolerance()) {
    world->set_point_tolerance(kPointToleranceRadii * circumscribed);
  }
  if (world->has_field_resolution()) return;
  const bool maze = world->kind() == proto::World::CAR_MAZE;
  const double vehicles = map != nullptr ? MapFieldResolution(*map, inscribed) : inscribed / 10;
  world->set_field_resolution(maze ? world->wall_thickness() / 4 : vehicles);
}

void DeriveLearner(proto::Learner* learner) {
  if (learner->net_arch().empty()) {
    learner->add_net_arch(64);
    learner->add_net_arch(64);
  }
  if (!learner->has_target_entropy()) learner->set_target_entropy(-kActionSize);
}

}  // namespace

void Resolve(Draft* draft, const ImportedMap* map) {
  proto::Experiment& experiment = draft->message;
  FillDefaults(&experiment);
  if (map == nullptr) experiment.mutable_world()->clear_unknown_is_free();  // what is not read is not part of the hash
  const VehicleConfig footprint = Footprint(experiment.vehicle());
  const double circumscribed = footprint.circumscribed_radius();
  const double inscribed = footprint.inscribed_radius();
  DerivePlanner(circumscribed, inscribed, experiment.mutable_planner());
  DeriveObservation(circumscribed, experiment.mutable_observation());
  DeriveWorld(circumscribed, inscribed, map, experiment.mutable_world());
  DeriveLearner(experiment.mutable_learner());
  proto::Scan* scan = experiment.mutable_vehicle()->mutable_scan();
  if (!scan->has_range()) scan->set_range(kScanRangeRadii * circumscribed);
}

}  // namespace cairn::config
