#include "common/config/draft.h"

#include <algorithm>
#include <vector>

#include "common/config/nearest_name.h"

namespace cairn::config {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;

std::vector<std::string> Split(const std::string& path) {
  std::vector<std::string> parts;
  size_t begin = 0;
  for (size_t dot = path.find('.'); dot != std::string::npos; dot = path.find('.', begin)) {
    parts.push_back(path.substr(begin, dot - begin));
    begin = dot + 1;
  }
  parts.push_back(path.substr(begin));
  return parts;
}

void ListPaths(const Descriptor* type, const std::string& parent, std::vector<std::string>* paths) {
  for (int i = 0; i < type->field_count(); ++i) {
    const FieldDescriptor* field = type->field(i);
    const std::string path = JoinPath(parent, field->name());
    paths->push_back(path);
    if (field->message_type() != nullptr) ListPaths(field->message_type(), path, paths);
  }
}

std::string LastPart(const std::string& path) { return path.substr(path.rfind('.') + 1); }

/// The longest leading part of `path` that names a message, and that message.
std::pair<std::string, const Descriptor*> KnownParent(const std::string& path) {
  std::string known;
  const Descriptor* type = proto::Experiment::descriptor();
  for (const std::string& part : Split(path)) {
    const FieldDescriptor* field = type->FindFieldByName(part);
    if (field == nullptr || field->message_type() == nullptr) break;
    known = JoinPath(known, part);
    type = field->message_type();
  }
  return {known, type};
}

}  // namespace

std::string JoinPath(const std::string& parent, const std::string& name) {
  return parent.empty() ? name : parent + "." + name;
}

std::string Draft::Origin(const std::string& path) const {
  const auto found = origins.find(path);
  return found == origins.end() ? "default" : found->second;
}

void Draft::ForgetOrigins(const std::string& path) {
  const auto below = [&](const std::string& key) {
    return key.compare(0, path.size(), path) == 0 &&
           (key.size() == path.size() || key[path.size()] == '.' || key[path.size()] == '[');
  };
  for (auto it = origins.lower_bound(path); it != origins.end() && it->first.compare(0, path.size(), path) == 0;) {
    it = below(it->first) ? origins.erase(it) : std::next(it);
  }
}

const FieldDescriptor* FindField(const std::string& path) {
  const Descriptor* type = proto::Experiment::descriptor();
  const FieldDescriptor* field = nullptr;
  for (const std::string& part : Split(path)) {
    if (type == nullptr) return nullptr;
    field = type->FindFieldByName(part);
    if (field == nullptr) return nullptr;
    type = field->message_type();
  }
  return field;
}

std::string NearestField(const std::string& path) {
  const auto [parent, type] = KnownParent(path);
  const std::string rest = parent.empty() ? path : path.substr(parent.size() + 1);
  std::vector<std::string> siblings;
  for (int i = 0; i < type->field_count(); ++i) siblings.push_back(type->field(i)->name());
  const std::string sibling = NearestName(rest, siblings);
  const int near_enough = std::max<int>(2, static_cast<int>(rest.size()) / 3);
  if (EditDistance(rest, sibling) <= near_enough) return JoinPath(parent, sibling);

  std::vector<std::string> paths;
  ListPaths(proto::Experiment::descriptor(), "", &paths);
  std::vector<std::string> names;
  for (const std::string& candidate : paths) names.push_back(LastPart(candidate));
  const std::string name = NearestName(LastPart(path), names);
  if (EditDistance(LastPart(path), name) <= near_enough) {
    return paths[std::find(names.begin(), names.end(), name) - names.begin()];
  }
  return NearestName(path, paths);
}

}  // namespace cairn::config
