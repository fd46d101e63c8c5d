#include "common/nn/policy.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <utility>
#include <vector>

#include "common/core/check.h"
#include "common/core/random.h"

namespace cairn {
namespace {

PolicyShape Shape(PolicyShape::Head head, bool layer_norm) {
  PolicyShape shape;
  shape.head = head;
  shape.observation_size = 27;
  shape.action_size = 2;
  shape.net_arch = {64, 48};
  shape.layer_norm = layer_norm;
  return shape;
}

std::vector<float> Normals(size_t count, uint32_t index, float scale = 1.0f) {
  RandomStream random(7, RandomPurpose::kTest, index);
  std::vector<float> x(count);
  for (float& v : x) v = scale * static_cast<float>(random.Normal());
  return x;
}

/// The network's output for one observation, in double, straight from the parameter order that PolicyShape states.
std::vector<double> Reference(const PolicyShape& shape, const std::vector<float>& parameters,
                              const float* observation) {
  std::vector<double> x(observation, observation + shape.observation_size);
  std::vector<int> sizes = shape.net_arch;
  sizes.push_back(shape.output_size());
  const float* p = parameters.data();
  for (size_t l = 0; l < sizes.size(); ++l) {
    const size_t in = x.size(), out = sizes[l];
    std::vector<double> z(out);
    for (size_t i = 0; i < out; ++i) {
      z[i] = p[out * in + i];
      for (size_t k = 0; k < in; ++k) z[i] += static_cast<double>(p[k * out + i]) * x[k];
    }
    p += out * in + out;
    if (l + 1 < sizes.size()) {
      if (shape.layer_norm) {
        double mean = 0, variance = 0;
        for (double v : z) mean += v / static_cast<double>(out);
        for (double v : z) variance += (v - mean) * (v - mean) / static_cast<double>(out);
        for (size_t i = 0; i < out; ++i) z[i] = (z[i] - mean) / std::sqrt(variance + 1e-5) * p[i] + p[out + i];
        p += 2 * out;
      }
      for (double& v : z) v = std::max(v, 0.0);
    }
    x = z;
  }
  EXPECT_EQ(p, parameters.data() + parameters.size());
  return x;
}

class PolicyTest : public testing::TestWithParam<std::tuple<PolicyShape::Head, bool>> {
 protected:
  PolicyTest()
      : shape_(Shape(std::get<0>(GetParam()), std::get<1>(GetParam()))),
        parameters_(Normals(shape_.num_parameters(), 1, 0.1f)),
        observations_(Normals(static_cast<size_t>(kMax) * shape_.observation_size, 2)),
        noise_(Normals(static_cast<size_t>(kMax) * shape_.action_size, 3)) {}

  static constexpr int kMax = 150;
  PolicyShape shape_;
  std::vector<float> parameters_, observations_, noise_;
};

TEST_P(PolicyTest, ActsAsTheReference) {
  Policy policy(shape_, kMax);
  policy.SetParameters(parameters_);
  std::vector<float> actions(kMax * shape_.action_size);
  policy.Act(observations_.data(), kMax, actions.data());
  for (int j = 0; j < kMax; ++j) {
    const std::vector<double> y = Reference(shape_, parameters_, &observations_[j * shape_.observation_size]);
    for (int a = 0; a < shape_.action_size; ++a) {
      EXPECT_NEAR(actions[j * shape_.action_size + a], std::tanh(y[a]), 2e-6);
    }
  }
}

TEST_P(PolicyTest, ExploresAsTheReference) {
  Policy policy(shape_, kMax);
  policy.SetParameters(parameters_);
  std::vector<float> actions(kMax * shape_.action_size);
  policy.Explore(observations_.data(), kMax, noise_.data(), 0.3f, actions.data());
  for (int j = 0; j < kMax; ++j) {
    const std::vector<double> y = Reference(shape_, parameters_, &observations_[j * shape_.observation_size]);
    for (int a = 0; a < shape_.action_size; ++a) {
      const double normal = noise_[j * shape_.action_size + a];
      const double expected =
          shape_.head == PolicyShape::Head::kGaussian
              ? std::tanh(y[a] + std::exp(std::clamp(y[a + shape_.action_size], -20.0, 2.0)) * normal)
              : std::clamp(std::tanh(y[a]) + 0.3 * normal, -1.0, 1.0);
      EXPECT_NEAR(actions[j * shape_.action_size + a], expected, 4e-6);
    }
  }
}

TEST_P(PolicyTest, SameBitsForEveryBatchSizeAndPlace) {
  Policy policy(shape_, kMax);
  policy.SetParameters(parameters_);
  std::vector<float> all(kMax * shape_.action_size), part(all.size());
  policy.Explore(observations_.data(), kMax, noise_.data(), 0.3f, all.data());
  for (int n : {1, 2, 3, 5, 11, 12, 16, 31, 64, 65, 128}) {
    Policy small(shape_, n);
    small.SetParameters(parameters_);
    for (Policy* p : {&policy, &small}) {
      for (int first = 0; first + n <= kMax; first += n) {
        p->Explore(&observations_[first * shape_.observation_size], n, &noise_[first * shape_.action_size], 0.3f,
                   part.data());
        ASSERT_EQ(std::memcmp(part.data(), &all[first * shape_.action_size], sizeof(float) * n * shape_.action_size), 0)
            << "n = " << n << ", first = " << first;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Heads, PolicyTest,
                         testing::Combine(testing::Values(PolicyShape::Head::kGaussian,
                                                          PolicyShape::Head::kDeterministic),
                                          testing::Bool()));

TEST(PolicyShapeTest, NamesItself) {
  EXPECT_EQ(Shape(PolicyShape::Head::kGaussian, false).ToString(), "gaussian 27-64-48-4");
  EXPECT_EQ(Shape(PolicyShape::Head::kDeterministic, true).ToString(), "deterministic 27-64-48-2 layer_norm");
}

TEST(PolicyParametersTest, RefusesWrongSizeAndNonFinite) {
  Policy policy(Shape(PolicyShape::Head::kGaussian, false), 1);
  std::vector<float> parameters(policy.shape().num_parameters());
  EXPECT_NO_THROW(policy.SetParameters(parameters));
  EXPECT_THROW(policy.SetParameters(std::span(parameters).first(10)), Error);
  parameters[3] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(policy.SetParameters(parameters), Error);
}

TEST(PolicyParametersTest, MovesWithItsParameters) {
  const PolicyShape shape = Shape(PolicyShape::Head::kGaussian, false);
  Policy first(shape, 4);
  first.SetParameters(Normals(shape.num_parameters(), 1, 0.1f));
  const std::vector<float> observation = Normals(shape.observation_size, 2);
  float before[2], after[2];
  first.Act(observation.data(), 1, before);
  Policy second = std::move(first);
  second.Act(observation.data(), 1, after);
  EXPECT_EQ(std::memcmp(before, after, sizeof(before)), 0);
}

}  // namespace
}  // namespace cairn
