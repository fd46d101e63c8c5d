#include <algorithm>
#include <cairn_lcm/robot_command_t.hpp>
#include <cairn_lcm/robot_state_t.hpp>

#include "common/bus/codec.h"
#include "common/bus/codec_type.h"

namespace cairn {

using codec::DecodeType;
using codec::EncodeType;

Bytes Encode(const RobotState& m) {
  cairn_lcm::robot_state_t t;
  t.utime = m.utime;
  std::copy(m.pose.begin(), m.pose.end(), t.pose);
  std::copy(m.velocity.begin(), m.velocity.end(), t.velocity);
  t.angle_min = m.angle_min;
  t.angle_step = m.angle_step;
  t.num_ranges = static_cast<int32_t>(m.ranges.size());
  t.range = m.ranges;
  return EncodeType(t);
}

template <>
std::optional<RobotState> Decode<RobotState>(ByteSpan bytes) {
  SizeWalker walker(bytes);
  walker.Skip(8 + 8 + 10 * 8);
  walker.Array(walker.Count(), 4);
  auto t = DecodeType<cairn_lcm::robot_state_t>(bytes, walker.Done());
  if (!t) return std::nullopt;
  RobotState m;
  m.utime = t->utime;
  std::copy(std::begin(t->pose), std::end(t->pose), m.pose.begin());
  std::copy(std::begin(t->velocity), std::end(t->velocity), m.velocity.begin());
  m.angle_min = t->angle_min;
  m.angle_step = t->angle_step;
  m.ranges = std::move(t->range);
  return m;
}

Bytes Encode(const RobotCommand& m) {
  cairn_lcm::robot_command_t t;
  t.utime = m.utime;
  t.state_utime = m.state_utime;
  t.valid = m.valid;
  t.way_to_go = m.way_to_go;
  t.mode = static_cast<int8_t>(m.mode);
  t.num_commands = static_cast<int32_t>(m.command.size());
  t.command = m.command;
  t.note = m.note;
  return EncodeType(t);
}

template <>
std::optional<RobotCommand> Decode<RobotCommand>(ByteSpan bytes) {
  SizeWalker walker(bytes);
  walker.Skip(8 + 4 * 8 + 1);
  walker.Array(walker.Count(), 8);
  walker.String();
  auto t = DecodeType<cairn_lcm::robot_command_t>(bytes, walker.Done());
  if (!t || t->mode < 0 || t->mode > static_cast<int8_t>(RobotCommand::Mode::kStop)) return std::nullopt;
  return RobotCommand{t->utime,
                      t->state_utime,
                      t->valid,
                      t->way_to_go,
                      static_cast<RobotCommand::Mode>(t->mode),
                      std::move(t->command),
                      std::move(t->note)};
}

}  // namespace cairn
