#include "common/config/arguments.h"

#include <charconv>
#include <cmath>

#include "common/core/check.h"

namespace cairn::config {
namespace {

// "X,Y" or "X,Y,Z" in metres.
proto::Vector3 ParsePoint(const std::string& option, const std::string& text) {
  double values[3] = {0, 0, 0};
  int count = 0;
  const char *at = text.data(), *end = text.data() + text.size();
  for (bool more = true; more && count < 3; ++count) {
    const auto [next, error] = std::from_chars(at, end, values[count]);
    if (error != std::errc() || !std::isfinite(values[count])) break;
    more = next != end && *next == ',';
    at = more ? next + 1 : next;
  }
  if (at != end || count < 2) ThrowUsageError("{} {}: write it as X,Y or X,Y,Z, in metres", option, text);
  proto::Vector3 point;
  point.set_x(values[0]);
  point.set_y(values[1]);
  point.set_z(values[2]);
  return point;
}

void SetOrigin(Draft* draft, const std::string& path, const std::string& origin) {
  draft->ForgetOrigins(path);
  draft->origins[path] = origin;
}

}  // namespace

void ApplyArguments(const PlaceArguments& arguments, Draft* draft) {
  proto::World* world = draft->message.mutable_world();
  if (!arguments.map.empty()) {
    world->set_kind(proto::World::MAP);
    world->set_map(arguments.map);
    SetOrigin(draft, "world.kind", "--map " + arguments.map);
    SetOrigin(draft, "world.map", "--map " + arguments.map);
  }
  if (!arguments.goal.empty()) {
    world->clear_goal();
    *world->mutable_goal_point() = ParsePoint("--goal", arguments.goal);
    SetOrigin(draft, "world.goal_point", "--goal " + arguments.goal);
  }
  if (!arguments.start.empty()) {
    world->clear_start();
    *world->mutable_start_point() = ParsePoint("--start", arguments.start);
    SetOrigin(draft, "world.start_point", "--start " + arguments.start);
  }
}

}  // namespace cairn::config
