#include "common/config/text_reader.h"

#include <google/protobuf/text_format.h>

#include <cctype>
#include <memory>

#include "common/config/parse_error.h"
#include "common/config/ranges.h"
#include "common/config/text_scanner.h"
#include "common/core/check.h"

namespace cairn::config {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::TextFormat;
using Tree = TextFormat::ParseInfoTree;

std::string LowerFirst(std::string text) {
  if (!text.empty()) text[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(text[0])));
  if (!text.empty() && text.back() == '.') text.pop_back();
  return text;
}

// The name in `… has no field named "x".` or `… for field "x"`; empty for other errors. In these the parser has already
// read on, so that the error's place is behind the field.
std::string NameAfter(const std::string& what, const std::string& mark) {
  const size_t at = what.find(mark);
  if (at == std::string::npos) return "";
  const size_t begin = at + mark.size();
  return what.substr(begin, what.find('"', begin) - begin);
}

std::string PathOf(const ParseError& error, const std::string& text, const std::string& outer) {
  const std::string inner = error.line < 0 ? "" : FieldPathAt(text, error.line, error.column);
  const std::string path = inner.empty() ? outer : JoinPath(outer, inner);
  std::string name = NameAfter(error.what, "has no field named \"");
  if (name.empty()) name = NameAfter(error.what, "field \"");
  return name.empty() || path == name || path.ends_with("." + name) ? path : JoinPath(path, name);
}

// A list in brackets has one place for all its elements.
int LineOf(const Tree& tree, const FieldDescriptor* field, int index) {
  int line = tree.GetLocation(field, index).line;
  for (; line < 0 && index > 0; --index) line = tree.GetLocation(field, index - 1).line;
  return line + 1;
}

void CollectOrigins(const Message& message, Tree* tree, const std::string& parent, const std::string& source,
                    std::map<std::string, std::string>* origins) {
  const auto* reflection = message.GetReflection();
  std::vector<const FieldDescriptor*> fields;
  reflection->ListFields(message, &fields);
  for (const FieldDescriptor* field : fields) {
    const int count = field->is_repeated() ? reflection->FieldSize(message, field) : 1;
    for (int i = 0; i < count; ++i) {
      const int index = field->is_repeated() ? i : -1;
      const std::string name = JoinPath(parent, field->name());
      const std::string path = field->is_repeated() ? fmt::format("{}[{}]", name, i) : name;
      (*origins)[path] = fmt::format("{}:{}", source, LineOf(*tree, field, index));
      if (field->message_type() == nullptr) continue;
      const Message& child = field->is_repeated() ? reflection->GetRepeatedMessage(message, field, i)
                                                  : reflection->GetMessage(message, field);
      if (Tree* nested = tree->GetTreeForNested(field, index)) CollectOrigins(child, nested, path, source, origins);
    }
  }
}

}  // namespace

void FirstError::AddError(int line, int column, const std::string& message) {
  if (error_.what.empty()) error_ = {line, column, message};
}

void ThrowUnknown(const std::string& where, const std::string& path) {
  ThrowUsageError("{}: {}: unknown key; the nearest known one is {}", where, path, NearestField(path));
}

// `outer` is the path of the text's message within the experiment.
void ThrowParseError(const ParseError& error, const std::string& text, const std::string& where,
                     const std::string& outer) {
  const std::string path = PathOf(error, text, outer);
  const FieldDescriptor* field = path.empty() ? nullptr : FindField(path);
  if (field == nullptr && error.what.find("has no field named") != std::string::npos) ThrowUnknown(where, path);
  ThrowUsageError("{}: {}{}{}", where, path.empty() ? "" : path + ": ", LowerFirst(error.what),
                  field == nullptr ? "" : "; " + Rule(*field));
}

// `path` is that of the message within the experiment.
void Parse(const std::string& text, const std::string& source, const std::string& path, Message* message,
           std::map<std::string, std::string>* origins) {
  FirstError collector;
  Tree tree;
  TextFormat::Parser parser;
  parser.RecordErrorsTo(&collector);
  parser.WriteLocationsTo(&tree);
  if (!parser.ParseFromString(text, message)) {
    const ParseError& error = collector.error();
    ThrowParseError(error, text, error.line < 0 ? source : source + ":" + std::to_string(error.line + 1), path);
  }
  CollectOrigins(*message, &tree, path, source, origins);
}

Draft ReadText(const std::string& text, const std::string& source) {
  Draft draft;
  Parse(text, source, "", &draft.message, &draft.origins);
  return draft;
}

void ReadVehicle(const std::string& text, const std::string& source, Draft* draft) {
  draft->ForgetOrigins("vehicle");
  draft->origins["vehicle"] = source;
  draft->message.clear_vehicle();
  Parse(text, source, "vehicle", draft->message.mutable_vehicle(), &draft->origins);
}

}  // namespace cairn::config
