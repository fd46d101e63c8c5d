#include "common/nn/vector_math.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "common/nn/full_width.h"

namespace cairn::math {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// Distance of `value` from the exact result in units of the exact result's last place.
double UlpError(float value, double exact) {
  const float nearest = static_cast<float>(exact);
  if (value == nearest) return 0.0;
  const double ulp = std::nextafter(std::fabs(nearest), kInfinity) - std::fabs(nearest);
  return std::fabs(value - exact) / ulp;
}

template <typename Function, typename Reference>
double LargestUlpError(Function function, Reference reference, float low, float high, float* where) {
  double worst = 0;
  const int count = 2000000;
  for (int i = 0; i <= count; ++i) {
    const float x = low + (high - low) * (static_cast<float>(i) / count);
    const double error = UlpError(function(x), reference(static_cast<double>(x)));
    if (error > worst) {
      worst = error;
      *where = x;
    }
  }
  return worst;
}

// Every 997th positive float in [low, high]: all magnitudes.
template <typename Function, typename Reference>
double LargestUlpErrorByBits(Function function, Reference reference, float low, float high, float* where) {
  double worst = 0;
  for (uint32_t bits = std::bit_cast<uint32_t>(low); bits <= std::bit_cast<uint32_t>(high); bits += 997) {
    const float x = std::bit_cast<float>(bits);
    const double error = UlpError(function(x), reference(static_cast<double>(x)));
    if (error > worst) {
      worst = error;
      *where = x;
    }
  }
  return worst;
}

float FloatExp(float x) { return Exp(x); }
float FloatLog(float x) { return Log(x); }
float FloatTanh(float x) { return Tanh(x); }
double DoubleExp(double x) { return std::exp(x); }
double DoubleLog(double x) { return std::log(x); }
double DoubleTanh(double x) { return std::tanh(x); }

TEST(VectorMathTest, ExpIsWithinTwoUlp) {
  float x = 0;
  EXPECT_LE(LargestUlpError(FloatExp, DoubleExp, -87.0f, 88.7f, &x), 2.0) << "at " << x;
  EXPECT_LE(LargestUlpError(FloatExp, DoubleExp, -1.0f, 1.0f, &x), 2.0) << "at " << x;
}

TEST(VectorMathTest, ExpReachesItsEnds) {
  EXPECT_EQ(Exp(0.0f), 1.0f);
  EXPECT_EQ(Exp(89.0f), kInfinity);
  EXPECT_EQ(Exp(kInfinity), kInfinity);
  EXPECT_EQ(Exp(-kInfinity), 0.0f);
  EXPECT_NEAR(Exp(-100.0f) / std::exp(-100.0), 1.0, 0.02);  // subnormal
  EXPECT_TRUE(std::isnan(Exp(std::nanf(""))));
}

TEST(VectorMathTest, LogIsWithinTwoUlp) {
  float x = 0;
  EXPECT_LE(LargestUlpErrorByBits(FloatLog, DoubleLog, 1e-44f, 3e38f, &x), 2.0) << "at " << x;
  EXPECT_LE(LargestUlpError(FloatLog, DoubleLog, 0.5f, 2.0f, &x), 2.0) << "at " << x;
}

TEST(VectorMathTest, LogReachesItsEnds) {
  EXPECT_EQ(Log(1.0f), 0.0f);
  EXPECT_EQ(Log(0.0f), -kInfinity);
  EXPECT_EQ(Log(kInfinity), kInfinity);
  EXPECT_TRUE(std::isnan(Log(-1.0f)));
  EXPECT_TRUE(std::isnan(Log(std::nanf(""))));
}

TEST(VectorMathTest, TanhIsWithinTwoUlp) {
  float x = 0;
  EXPECT_LE(LargestUlpErrorByBits(FloatTanh, DoubleTanh, 1e-38f, 50.0f, &x), 2.0) << "at " << x;
  EXPECT_LE(LargestUlpError(FloatTanh, DoubleTanh, -10.0f, 10.0f, &x), 2.0) << "at " << x;
}

TEST(VectorMathTest, TanhIsOddAndSaturates) {
  for (float x : {0.0f, 1e-30f, 0.3f, 0.625f, 2.0f, 20.0f, kInfinity}) EXPECT_EQ(Tanh(-x), -Tanh(x)) << x;
  EXPECT_EQ(Tanh(20.0f), 1.0f);
  EXPECT_EQ(Tanh(kInfinity), 1.0f);
  EXPECT_TRUE(std::isnan(Tanh(std::nanf(""))));
}

TEST(VectorMathTest, CosSinAreAccurateOverTheTurn) {
  for (int i = 0; i <= 1000000; ++i) {
    const float t = static_cast<float>(i) / 1000000.0f;
    const double angle = 2.0 * M_PI * static_cast<double>(t);
    float c, s;
    CosSin2Pi(t, &c, &s);
    ASSERT_NEAR(c, std::cos(angle), 1.5e-7) << t;
    ASSERT_NEAR(s, std::sin(angle), 1.5e-7) << t;
  }
}

/// A loop that the compiler turns into vector code, over a part of an array that starts and ends anywhere.
template <typename Function>
CAIRN_INLINE_LOOP inline void Apply(Function function, const float* x, int n, float* y) {
  for (int i = 0; i < n; ++i) y[i] = function(x[i]);
}

TEST(VectorMathTest, SameBitsWhereverInAnArrayAndAtFullWidth) {
  std::vector<float> x(203), one(x.size()), many(x.size());
  for (size_t i = 0; i < x.size(); ++i) x[i] = 0.02f + 0.07f * static_cast<float>(i);
  const auto check = [&](auto function) {
    for (size_t i = 0; i < x.size(); ++i) Apply(function, &x[i], 1, &one[i]);
    for (int begin = 0; begin < 20; ++begin) {
      for (int n : {1, 7, 8, 31, 64, 183}) {
        Apply(function, &x[begin], n, &many[begin]);
        ASSERT_EQ(std::memcmp(&one[begin], &many[begin], n * sizeof(float)), 0) << begin << " " << n;
        AtFullWidth([&]() CAIRN_INLINE_LOOP { Apply(function, &x[begin], n, &many[begin]); });
        ASSERT_EQ(std::memcmp(&one[begin], &many[begin], n * sizeof(float)), 0) << begin << " " << n;
      }
    }
  };
  check([](float v) { return Exp(v); });
  check([](float v) { return Log(v); });
  check([](float v) { return Tanh(v - 5.0f); });
}

}  // namespace
}  // namespace cairn::math
