#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <span>

namespace cairn::learner {

/// Compares `gradient` with central differences of `loss` by each of `values`. `changed` is called after every change.
inline void ExpectGradient(std::span<double> values, std::span<const double> gradient,
                           const std::function<double()>& loss, const std::function<void()>& changed,
                           double tolerance = 2e-7) {
  constexpr double kStep = 1e-5;
  double largest = 0;
  for (double g : gradient.first(values.size())) largest = std::max(largest, std::fabs(g));
  EXPECT_GT(largest, 0.0) << "a gradient of zeros proves nothing";
  for (size_t i = 0; i < values.size(); ++i) {
    const double value = values[i];
    const auto at = [&](double v) {
      values[i] = v;
      changed();
      return loss();
    };
    const double difference = (at(value + kStep) - at(value - kStep)) / (2 * kStep);
    at(value);
    EXPECT_NEAR(gradient[i], difference, tolerance * std::max(1.0, largest)) << "parameter " << i;
  }
}

}  // namespace cairn::learner
