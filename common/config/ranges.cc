#include "common/config/ranges.h"

#include <cmath>
#include <vector>

#include "common/core/check.h"

namespace cairn::config {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::FieldOptions;
using google::protobuf::Message;
using google::protobuf::Reflection;

std::string Range(const FieldOptions& options) {
  std::string low, high;
  if (options.HasExtension(proto::min)) low = fmt::format("[{}", options.GetExtension(proto::min));
  if (options.HasExtension(proto::above)) low = fmt::format("({}", options.GetExtension(proto::above));
  if (options.HasExtension(proto::max)) high = fmt::format("{}]", options.GetExtension(proto::max));
  if (options.HasExtension(proto::below)) high = fmt::format("{})", options.GetExtension(proto::below));
  if (low.empty() && high.empty()) return "";
  return fmt::format(" in {}, {}", low.empty() ? "(-inf" : low, high.empty() ? "inf)" : high);
}

std::string EnumNames(const FieldDescriptor& field) {
  std::string names;
  for (int i = 0; i < field.enum_type()->value_count(); ++i) {
    names += (i == 0 ? "" : ", ") + field.enum_type()->value(i)->name();
  }
  return names;
}

std::string Kind(const FieldDescriptor& field) {
  switch (field.cpp_type()) {
    case FieldDescriptor::CPPTYPE_BOOL:
      return "true or false";
    case FieldDescriptor::CPPTYPE_ENUM:
      return "one of " + EnumNames(field);
    case FieldDescriptor::CPPTYPE_STRING:
      return "text in quotes";
    case FieldDescriptor::CPPTYPE_MESSAGE:
      return "a block in braces";
    case FieldDescriptor::CPPTYPE_UINT32:
    case FieldDescriptor::CPPTYPE_UINT64:
      return "a whole number, 0 or more";
    case FieldDescriptor::CPPTYPE_INT32:
    case FieldDescriptor::CPPTYPE_INT64:
      return "a whole number";
    case FieldDescriptor::CPPTYPE_FLOAT:
    case FieldDescriptor::CPPTYPE_DOUBLE:
      return "a finite number";
  }
  return "";
}

bool InRange(double value, const FieldOptions& options) {
  if (!std::isfinite(value)) return false;
  if (options.HasExtension(proto::min) && value < options.GetExtension(proto::min)) return false;
  if (options.HasExtension(proto::max) && value > options.GetExtension(proto::max)) return false;
  if (options.HasExtension(proto::above) && value <= options.GetExtension(proto::above)) return false;
  return !(options.HasExtension(proto::below) && value >= options.GetExtension(proto::below));
}

// Element `index` of a repeated number, or the number itself (index -1).
template <typename T>
T Number(const Message& message, const FieldDescriptor* field, int index) {
  const Reflection* reflection = message.GetReflection();
  if constexpr (std::is_same_v<T, int32_t>) {
    return index < 0 ? reflection->GetInt32(message, field) : reflection->GetRepeatedInt32(message, field, index);
  } else if constexpr (std::is_same_v<T, int64_t>) {
    return index < 0 ? reflection->GetInt64(message, field) : reflection->GetRepeatedInt64(message, field, index);
  } else {
    return index < 0 ? reflection->GetDouble(message, field) : reflection->GetRepeatedDouble(message, field, index);
  }
}

template <typename T>
void CheckNumber(const Draft& draft, const Message& message, const FieldDescriptor* field, int index,
                 const std::string& path) {
  const T value = Number<T>(message, field, index);
  if (InRange(static_cast<double>(value), field->options())) return;
  ThrowUsageError("{}: {} = {}; {}", draft.Origin(path), path, value, Rule(*field));
}

void CheckMessage(const Draft& draft, const Message& message, const std::string& parent);

void CheckValue(const Draft& draft, const Message& message, const FieldDescriptor* field, int index,
                const std::string& path) {
  switch (field->cpp_type()) {
    case FieldDescriptor::CPPTYPE_INT32:
      return CheckNumber<int32_t>(draft, message, field, index, path);
    case FieldDescriptor::CPPTYPE_INT64:
      return CheckNumber<int64_t>(draft, message, field, index, path);
    case FieldDescriptor::CPPTYPE_DOUBLE:
      return CheckNumber<double>(draft, message, field, index, path);
    case FieldDescriptor::CPPTYPE_MESSAGE:
      return CheckMessage(draft,
                          index < 0 ? message.GetReflection()->GetMessage(message, field)
                                    : message.GetReflection()->GetRepeatedMessage(message, field, index),
                          path);
    default:  // bool, enum, text and unsigned numbers carry no range
      return;
  }
}

void CheckMessage(const Draft& draft, const Message& message, const std::string& parent) {
  std::vector<const FieldDescriptor*> fields;
  message.GetReflection()->ListFields(message, &fields);
  for (const FieldDescriptor* field : fields) {
    const std::string path = JoinPath(parent, field->name());
    if (!field->is_repeated()) {
      CheckValue(draft, message, field, -1, path);
      continue;
    }
    for (int i = 0; i < message.GetReflection()->FieldSize(message, field); ++i) {
      CheckValue(draft, message, field, i, fmt::format("{}[{}]", path, i));
    }
  }
}

}  // namespace

std::string Rule(const FieldDescriptor& field) {
  const FieldOptions& options = field.options();
  std::string unit;
  if (options.HasExtension(proto::unit)) unit = " " + options.GetExtension(proto::unit);
  return fmt::format("it must be {}{}{}{}", field.is_repeated() ? "a list, each " : "", Kind(field), Range(options),
                     unit);
}

void CheckRanges(const Draft& draft) { CheckMessage(draft, draft.message, ""); }

}  // namespace cairn::config
