#pragma once

#include <map>
#include <string>

#include "common/config/experiment.pb.h"

namespace cairn::config {

/// An experiment while it is being read: the message and where each of its values was typed.
struct Draft {
  proto::Experiment message;
  /// Field path ("learner.net_arch[1]") → "file:line" or the override; what is missing was not typed.
  std::map<std::string, std::string> origins;

  /// Where the value at `path` comes from: "car.textproto:12", "--set a=b" or "default".
  std::string Origin(const std::string& path) const;

  /// "learner.batch_size = 512 (car.textproto:12)", for errors.
  template <typename T>
  std::string Show(const std::string& path, const T& value) const;

  /// Forgets the origins of `path` and of everything below it.
  void ForgetOrigins(const std::string& path);
};

/// "a.b" and "c" → "a.b.c"; an empty parent adds nothing.
std::string JoinPath(const std::string& parent, const std::string& name);

/// The field at a dotted path ("learner.batch_size") of the experiment, nullptr when there is none.
const google::protobuf::FieldDescriptor* FindField(const std::string& path);

/// The known path nearest to a mistyped one: same message first, then the same name in another message.
std::string NearestField(const std::string& path);

}  // namespace cairn::config

#include <fmt/core.h>

template <typename T>
std::string cairn::config::Draft::Show(const std::string& path, const T& value) const {
  return fmt::format("{} = {} ({})", path, value, Origin(path));
}
