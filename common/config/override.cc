#include "common/config/override.h"

#include <google/protobuf/stubs/strutil.h>
#include <google/protobuf/text_format.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "common/config/parse_error.h"
#include "common/core/check.h"

namespace cairn::config {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::TextFormat;

std::string Trim(const std::string& text) {
  const size_t begin = text.find_first_not_of(" \t");
  return begin == std::string::npos ? "" : text.substr(begin, text.find_last_not_of(" \t") - begin + 1);
}

std::string QuoteIfText(const FieldDescriptor& field, const std::string& value) {
  const bool quoted = !value.empty() && (value[0] == '"' || value[0] == '\'');
  if (field.type() != FieldDescriptor::TYPE_STRING || quoted) return value;
  return fmt::format("\"{}\"", google::protobuf::CEscape(value));
}

Message* MutableParent(proto::Experiment* experiment, const std::string& parent) {
  Message* message = experiment;
  for (size_t begin = 0; begin < parent.size();) {
    const size_t end = std::min(parent.find('.', begin), parent.size());
    const FieldDescriptor* field = message->GetDescriptor()->FindFieldByName(parent.substr(begin, end - begin));
    message = message->GetReflection()->MutableMessage(message, field);
    begin = end + 1;
  }
  return message;
}

// Parses `name: value` into a message of the parent's type; more than the one field is an injection or a typo.
std::unique_ptr<Message> ParseAssignment(const Message& parent, const FieldDescriptor& field, const std::string& value,
                                         const std::string& where, const std::string& parent_path) {
  const std::string text = field.name() + ": " + QuoteIfText(field, value);
  std::unique_ptr<Message> parsed(parent.New());
  FirstError collector;
  TextFormat::Parser parser;
  parser.RecordErrorsTo(&collector);
  if (!parser.ParseFromString(text, parsed.get())) ThrowParseError(collector.error(), text, where, parent_path);
  std::vector<const FieldDescriptor*> fields;
  parsed->GetReflection()->ListFields(*parsed, &fields);
  for (const FieldDescriptor* other : fields) {
    if (other != &field) ThrowUsageError("{}: one value for one key, please; it also sets {}", where, other->name());
  }
  return parsed;
}

// A field inside a repeated message cannot be named by a plain path.
void CheckNoRepeatedParent(const std::string& key, const std::string& where) {
  for (size_t dot = key.find('.'); dot != std::string::npos; dot = key.find('.', dot + 1)) {
    const FieldDescriptor* field = FindField(key.substr(0, dot));
    if (field != nullptr && field->is_repeated()) {
      ThrowUsageError("{}: {} is a list; set it whole: {}=[{{…}}, {{…}}]", where, key.substr(0, dot),
                      key.substr(0, dot));
    }
  }
}

void MarkField(const Message& message, const FieldDescriptor* field, const std::string& path, const std::string& where,
               Draft* draft);

void MarkOrigins(const Message& message, const std::string& path, const std::string& where, Draft* draft) {
  draft->origins[path] = where;
  std::vector<const FieldDescriptor*> fields;
  const auto* reflection = message.GetReflection();
  reflection->ListFields(message, &fields);
  for (const FieldDescriptor* field : fields) MarkField(message, field, JoinPath(path, field->name()), where, draft);
}

void MarkField(const Message& message, const FieldDescriptor* field, const std::string& path, const std::string& where,
               Draft* draft) {
  const auto* reflection = message.GetReflection();
  draft->origins[path] = where;
  for (int i = 0; field->is_repeated() && i < reflection->FieldSize(message, field); ++i) {
    const std::string element = fmt::format("{}[{}]", path, i);
    draft->origins[element] = where;
    if (field->message_type() == nullptr) continue;
    MarkOrigins(reflection->GetRepeatedMessage(message, field, i), element, where, draft);
  }
  if (!field->is_repeated() && field->message_type() != nullptr) {
    MarkOrigins(reflection->GetMessage(message, field), path, where, draft);
  }
}

}  // namespace

void ApplyOverride(const std::string& assignment, Draft* draft) {
  const std::string where = "--set " + assignment;
  const size_t equals = assignment.find('=');
  if (equals == std::string::npos) ThrowUsageError("{}: write it as key=value", where);
  const std::string key = Trim(assignment.substr(0, equals));
  CheckNoRepeatedParent(key, where);
  const FieldDescriptor* field = FindField(key);
  if (field == nullptr) ThrowUnknown(where, key);

  const size_t dot = key.rfind('.');
  const std::string parent_path = dot == std::string::npos ? "" : key.substr(0, dot);
  Message* parent = MutableParent(&draft->message, parent_path);
  const auto parsed = ParseAssignment(*parent, *field, Trim(assignment.substr(equals + 1)), where, parent_path);
  parent->GetReflection()->ClearField(parent, field);
  parent->MergeFrom(*parsed);
  draft->ForgetOrigins(key);
  MarkField(*parsed, field, key, where, draft);
}

}  // namespace cairn::config
