#include "learner/optim/adam.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <span>
#include <string>
#include <vector>

namespace cairn::learner {
namespace {

// The paper's algorithm 1, one parameter, written out.
TEST(AdamTest, FollowsThePaper) {
  Adam<double> adam(3);
  std::vector<double> values{1.0, -2.0, 0.5};
  std::vector<double> expected = values, m(3), v(3);
  for (int t = 1; t <= 50; ++t) {
    std::vector<double> gradient(3);
    for (int i = 0; i < 3; ++i) {
      gradient[i] = std::sin(t + i) * std::pow(10.0, i - 1);
      m[i] = 0.9 * m[i] + 0.1 * gradient[i];
      v[i] = 0.999 * v[i] + 0.001 * gradient[i] * gradient[i];
      const double m_hat = m[i] / (1 - std::pow(0.9, t)), v_hat = v[i] / (1 - std::pow(0.999, t));
      expected[i] -= 0.01 * m_hat / (std::sqrt(v_hat) + 1e-8);
    }
    adam.Step(0.01, gradient, 1.0, values);
  }
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(values[i], expected[i], 1e-12);
  EXPECT_EQ(adam.num_steps(), 50);
}

TEST(AdamTest, ScalesTheGradient) {
  Adam<double> scaled(1), plain(1);
  double a = 0, b = 0;
  for (double g : {1.0, -3.0, 0.2}) {
    const double half = 0.5 * g;
    scaled.Step(0.1, {&g, 1}, 0.5, {&a, 1});
    plain.Step(0.1, {&half, 1}, 1.0, {&b, 1});
  }
  EXPECT_DOUBLE_EQ(a, b);
}

// Subnormal numbers would slow every later step down.
TEST(AdamTest, LeavesNoSubnormalMoments) {
  Adam<float> adam(1);
  float value = 1;
  for (const float size : {1.0f, 1e-20f, 1e-37f}) {
    for (int step = 0; step < 2000; ++step) {
      const float gradient = step == 0 ? size : 0.0f;
      adam.Step(1e-3, {&gradient, 1}, 1.0, {&value, 1});
      adam.VisitState("adam", [](const std::string& name, bool, std::span<std::byte> numbers) {
        if (name == "adam.steps") return;
        float moment;
        std::memcpy(&moment, numbers.data(), sizeof(moment));
        EXPECT_NE(std::fpclassify(moment), FP_SUBNORMAL) << name;
      });
    }
  }
}

TEST(PolyakTest, MovesByTau) {
  const std::vector<double> online{1.0, 2.0};
  std::vector<double> target{0.0, 4.0};
  Polyak<double>(0.25, online, target);
  EXPECT_DOUBLE_EQ(target[0], 0.25);
  EXPECT_DOUBLE_EQ(target[1], 3.5);
}

TEST(GradientNormTest, ClipsToTheLargestNorm) {
  const std::vector<double> gradient{3.0, 4.0};
  EXPECT_DOUBLE_EQ(SquaredNorm<double>(gradient), 25.0);
  EXPECT_NEAR(ClipFactor(25.0, 1.0), 0.2, 1e-6);
  EXPECT_EQ(ClipFactor(25.0, 10.0), 1.0);
  EXPECT_EQ(ClipFactor(25.0, 0.0), 1.0);
}

TEST(GradientNormTest, ShowsEveryNonFiniteEntry) {
  for (float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    for (size_t place = 0; place < 37; ++place) {
      std::vector<float> gradient(37, 1.0f);
      gradient[place] = bad;
      EXPECT_FALSE(std::isfinite(SquaredNorm<float>(gradient))) << place;
    }
  }
}

TEST(LinearDecayTest, GoesFromStartToFraction) {
  EXPECT_DOUBLE_EQ(LinearDecay(1e-3, 0.1, 0.0), 1e-3);
  EXPECT_DOUBLE_EQ(LinearDecay(1e-3, 0.1, 0.5), 5.5e-4);
  EXPECT_DOUBLE_EQ(LinearDecay(1e-3, 0.1, 1.0), 1e-4);
  EXPECT_DOUBLE_EQ(LinearDecay(1e-3, 1.0, 0.7), 1e-3);
  EXPECT_DOUBLE_EQ(LinearDecay(1e-3, 0.1, 1.5), 1e-4);
}

}  // namespace
}  // namespace cairn::learner
