#include "actors/command.h"

#include <algorithm>
#include <cmath>

namespace cairn::actors {
namespace {

// The share of the range's end on the command's side, raised to `exponent`.
double Bend(double command, const CommandRange& range, double exponent) {
  if (exponent == 1) return command;
  const double end = command < 0 ? range.min : range.max;
  return end == 0 ? 0 : end * std::pow(command / end, exponent);
}

}  // namespace

VehicleCommand ToCommand(const VehicleConfig& vehicle, const float* action) {
  const auto ranges = vehicle.command_ranges();
  VehicleCommand command{};
  for (int i = 0; i < vehicle.action_size(); ++i) {
    const double a = std::clamp<double>(action[i], -1, 1);
    const double c = 0.5 * (ranges[i].min + ranges[i].max) + a * 0.5 * (ranges[i].max - ranges[i].min);
    command[i] = Bend(c, ranges[i], vehicle.command_exponent);
  }
  return command;
}

void ToAction(const VehicleConfig& vehicle, const VehicleCommand& command, float* action) {
  const auto ranges = vehicle.command_ranges();
  for (int i = 0; i < vehicle.action_size(); ++i) {
    const CommandRange& range = ranges[i];
    const double c = Bend(std::clamp(command[i], range.min, range.max), range, 1 / vehicle.command_exponent);
    const double a = 2 * (c - range.min) / (range.max - range.min) - 1;
    action[i] = static_cast<float>(std::clamp(a, -1.0, 1.0));
  }
}

VehicleCommand RestCommand(const VehicleConfig& vehicle) {
  const auto ranges = vehicle.command_ranges();
  VehicleCommand command{};
  for (int i = 0; i < vehicle.action_size(); ++i) command[i] = std::clamp(0.0, ranges[i].min, ranges[i].max);
  return command;
}

}  // namespace cairn::actors
