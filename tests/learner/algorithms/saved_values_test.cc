#include "learner/algorithms/saved_values.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "common/core/check.h"
#include "common/core/random.h"
#include "learner/algorithms/algorithm.h"

namespace cairn::learner {
namespace {

constexpr int kObservations = 5, kActions = 2, kHidden = 16;

// One hidden layer written out: W column-major [out × in], b, and the same for the output.
std::vector<double> Forward(const std::vector<float>& p, const std::vector<double>& x, int outputs) {
  const size_t in = x.size();
  const float* w2 = p.data() + kHidden * in + kHidden;
  std::vector<double> y(static_cast<size_t>(outputs));
  for (int o = 0; o < outputs; ++o) y[o] = static_cast<double>(w2[kHidden * outputs + o]);
  for (int h = 0; h < kHidden; ++h) {
    double z = static_cast<double>(p[kHidden * in + h]);
    for (size_t i = 0; i < in; ++i) z += static_cast<double>(p[i * kHidden + h]) * x[i];
    for (int o = 0; o < outputs; ++o) y[o] += static_cast<double>(w2[h * outputs + o]) * std::max(z, 0.0);
  }
  return y;
}

class SavedValuesTest : public testing::TestWithParam<LearnerConfig::Algorithm> {
 protected:
  SavedValuesTest() {
    config_.algorithm = GetParam();
    config_.net_arch = {kHidden};
    config_.batch_size = 32;
    const bool sac = GetParam() == LearnerConfig::Algorithm::kSac;
    shape_ = {sac ? PolicyShape::Head::kGaussian : PolicyShape::Head::kDeterministic,
              kObservations,
              kActions,
              {kHidden},
              false};
    networks_ = MakeAlgorithm(config_, shape_, 3)->Save();
  }

  StateArray& Array(const std::string& name) {
    return *std::find_if(networks_.begin(), networks_.end(), [&](const StateArray& a) { return a.name == name; });
  }

  std::vector<float> Numbers(const std::string& name) {
    const StateArray& array = Array(name);
    std::vector<float> numbers(array.data.size() / sizeof(float));
    std::memcpy(numbers.data(), array.data.data(), array.data.size());
    return numbers;
  }

  LearnerConfig config_;
  PolicyShape shape_;
  std::vector<StateArray> networks_;
};

TEST_P(SavedValuesTest, AreTheSmallerCriticsAtThePolicysAction) {
  constexpr int kSamples = 150;  // two full batches and a part
  RandomStream random(5, RandomPurpose::kTest);
  std::vector<float> observations(kSamples * kObservations), values(kSamples);
  for (float& o : observations) o = static_cast<float>(random.Normal());
  SavedValues(shape_, networks_).Evaluate(observations.data(), kSamples, values.data());
  const std::vector<float> policy = Numbers("policy"), q1 = Numbers("q1"), q2 = Numbers("q2");
  int first_smaller = 0;
  for (int j = 0; j < kSamples; ++j) {
    std::vector<double> x(observations.begin() + j * kObservations, observations.begin() + (j + 1) * kObservations);
    const std::vector<double> mean = Forward(policy, x, shape_.output_size());
    for (int a = 0; a < kActions; ++a) x.push_back(std::tanh(mean[a]));
    const double a = Forward(q1, x, 1)[0], b = Forward(q2, x, 1)[0];
    EXPECT_NEAR(values[j], std::min(a, b), 1e-5);
    first_smaller += a < b ? 1 : 0;
  }
  EXPECT_GT(first_smaller, 0);  // so that both critics were asked
  EXPECT_LT(first_smaller, kSamples);
}

TEST_P(SavedValuesTest, ArraysThatAreMissingOrOfAnotherSizeAreNamed) {
  Array("q2").data.pop_back();
  EXPECT_THAT([&] { SavedValues(shape_, networks_); },
              testing::ThrowsMessage<Error>(testing::HasSubstr("the saved q2 has")));
  Array("q2").name = "q3";
  EXPECT_THAT([&] { SavedValues(shape_, networks_); }, testing::ThrowsMessage<Error>(testing::HasSubstr("have no q2")));
}

INSTANTIATE_TEST_SUITE_P(SacAndTd3, SavedValuesTest,
                         testing::Values(LearnerConfig::Algorithm::kSac, LearnerConfig::Algorithm::kTd3));

}  // namespace
}  // namespace cairn::learner
