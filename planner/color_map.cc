#include "planner/color_map.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace cairn::planner {
namespace {

constexpr std::array<std::array<int, 3>, 10> kViridis{{{68, 1, 84},
                                                       {72, 40, 120},
                                                       {62, 73, 137},
                                                       {49, 104, 142},
                                                       {38, 130, 142},
                                                       {31, 158, 137},
                                                       {53, 183, 121},
                                                       {110, 206, 88},
                                                       {181, 222, 43},
                                                       {253, 231, 37}}};

}  // namespace

std::string CostColor(double t) {
  const double u = (1 - std::clamp(t, 0.0, 1.0)) * (kViridis.size() - 1);
  const auto low = std::min(static_cast<size_t>(u), kViridis.size() - 2);
  std::array<int, 3> rgb;
  for (size_t k = 0; k < 3; ++k) {
    const double a = kViridis[low][k], b = kViridis[low + 1][k];
    rgb[k] = static_cast<int>(std::lround(a + (b - a) * (u - static_cast<double>(low))));
  }
  return fmt::format("#{:02x}{:02x}{:02x}", rgb[0], rgb[1], rgb[2]);
}

}  // namespace cairn::planner
