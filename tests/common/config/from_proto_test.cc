#include "common/config/from_proto.h"

#include <gtest/gtest.h>

#include <functional>
#include <vector>

#include "common/config/ranges.h"
#include "common/config/resolve.h"

namespace cairn::config {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;

// Gives a scalar field a value that differs from its default.
void SetOther(Message* message, const FieldDescriptor* field) {
  const Reflection* reflection = message->GetReflection();
  switch (field->cpp_type()) {
    case FieldDescriptor::CPPTYPE_BOOL:
      return reflection->SetBool(message, field, !field->default_value_bool());
    case FieldDescriptor::CPPTYPE_INT32:
      return reflection->SetInt32(message, field, field->default_value_int32() + 7);
    case FieldDescriptor::CPPTYPE_INT64:
      return reflection->SetInt64(message, field, field->default_value_int64() + 7);
    case FieldDescriptor::CPPTYPE_UINT64:
      return reflection->SetUInt64(message, field, field->default_value_uint64() + 7);
    case FieldDescriptor::CPPTYPE_DOUBLE:
      return reflection->SetDouble(message, field, field->default_value_double() + 0.71);
    case FieldDescriptor::CPPTYPE_STRING:
      return reflection->SetString(message, field, "another");
    case FieldDescriptor::CPPTYPE_ENUM: {
      const auto* last = field->enum_type()->value(field->enum_type()->value_count() - 1);
      const auto* other = last == field->default_value_enum() ? field->enum_type()->value(0) : last;
      return reflection->SetEnumValue(message, field, other->number());
    }
    default:
      FAIL() << "no value for the type of " << field->full_name();
  }
}

// Calls `visit` for every scalar field below `message`, with the message mutable in place.
void VisitScalars(Message* message, const std::function<void(Message*, const FieldDescriptor*)>& visit) {
  const Reflection* reflection = message->GetReflection();
  for (int i = 0; i < message->GetDescriptor()->field_count(); ++i) {
    const FieldDescriptor* field = message->GetDescriptor()->field(i);
    if (field->message_type() == nullptr) {
      if (!field->is_repeated()) visit(message, field);
    } else if (field->is_repeated()) {
      VisitScalars(reflection->AddMessage(message, field), visit);
    } else {
      VisitScalars(reflection->MutableMessage(message, field), visit);
    }
  }
}

proto::Experiment Defaults() {
  proto::Experiment message;
  VisitScalars(&message, [](Message*, const FieldDescriptor*) {});
  return message;
}

TEST(FromProtoTest, EveryFieldReachesTheStruct) {
  const Experiment before = FromProto(Defaults());
  int count = 0;
  int next = 0;
  proto::Experiment message;
  // Field number `next` in visiting order is changed alone, then the next one, until there is none left.
  for (bool found = true; found; ++next) {
    found = false;
    int at = 0;
    std::string name;
    message.Clear();
    VisitScalars(&message, [&](Message* owner, const FieldDescriptor* field) {
      if (at++ != next) return;
      SetOther(owner, field);
      name = field->full_name();
      found = true;
    });
    // The loader compares it, nobody else does.
    if (!found || name == "cairn.proto.Planner.roadmap_hash") continue;
    EXPECT_FALSE(FromProto(message) == before) << name << " does not reach the struct";
    ++count;
  }
  EXPECT_GT(count, 100);
}

TEST(FromProtoTest, ListsReachTheStruct) {
  proto::Experiment message;
  message.mutable_learner()->add_net_arch(5);
  EXPECT_EQ(FromProto(message).learner.net_arch, std::vector<int>{5});
  message.mutable_world()->add_obstacles()->mutable_max()->set_y(3);
  ASSERT_EQ(FromProto(message).world.obstacles.size(), 1u);
  EXPECT_EQ(FromProto(message).world.obstacles[0].max[1], 3);
  message.mutable_world()->add_cylinders()->mutable_base()->set_y(4);
  ASSERT_EQ(FromProto(message).world.cylinders.size(), 1u);
  EXPECT_EQ(FromProto(message).world.cylinders[0].base[1], 4);
}

TEST(FromProtoTest, StructDefaultsAreThoseOfTheSchema) {
  Draft draft;
  Resolve(&draft, nullptr);
  Experiment resolved = FromProto(draft.message);
  const Experiment plain;
  // The lengths that follow from the vehicle are rounded in the struct.
  const auto rounded = [](double* exact, double value) {
    EXPECT_NEAR(value, *exact, 0.03 * *exact);
    *exact = value;
  };
  rounded(&resolved.planner.eta, plain.planner.eta);
  rounded(&resolved.planner.min_spacing, plain.planner.min_spacing);
  rounded(&resolved.planner.grid_cell, plain.planner.grid_cell);
  rounded(&resolved.planner.radius, plain.planner.radius);
  rounded(&resolved.vehicle.scan.range, plain.vehicle.scan.range);
  rounded(&resolved.planner.repair_margin, plain.planner.repair_margin);
  rounded(&resolved.planner.repair_mark_radius, plain.planner.repair_mark_radius);
  rounded(&resolved.world.unseen_obstacle_size, plain.world.unseen_obstacle_size);
  rounded(&resolved.world.goal_tolerance, plain.world.goal_tolerance);
  rounded(&resolved.world.goal_distance, plain.world.goal_distance);
  rounded(&resolved.world.person_radius, plain.world.person_radius);
  rounded(&resolved.world.person_speed, plain.world.person_speed);
  rounded(&resolved.safety.margin, plain.safety.margin);
  resolved.observation = plain.observation;
  EXPECT_EQ(resolved, plain);
}

TEST(FromProtoTest, DefaultsOfTheSchemaKeepItsOwnRanges) {
  Draft draft;
  Resolve(&draft, nullptr);
  EXPECT_NO_THROW(CheckRanges(draft));
}

}  // namespace
}  // namespace cairn::config
