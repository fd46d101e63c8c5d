#include "learner/algorithms/mlp.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <numeric>
#include <vector>

#include "common/core/random.h"
#include "common/nn/policy.h"
#include "learner/algorithms/trained_mlp.h"
#include "tests/learner/algorithms/gradient_check.h"

namespace cairn::learner {
namespace {

std::vector<double> Normals(size_t count, uint32_t index) {
  RandomStream random(3, RandomPurpose::kTest, index);
  std::vector<double> x(count);
  for (double& v : x) v = static_cast<float>(random.Normal());
  return x;
}

class MlpGradientTest : public testing::TestWithParam<MlpShape> {};

constexpr int kStride = 9;

// Loss = Σ c · y with random c, in two chunks of different size.
TEST_P(MlpGradientTest, LossGradientIsTheDerivative) {
  const MlpShape shape = GetParam();
  const std::vector<int> sizes{5, 6};
  const Mlp<double> mlp(shape, kStride, sizes);
  TrainedMlp<double> net(mlp, 1, 0);
  MlpTape<double> tape(shape, 6);
  const std::vector<double> x = Normals(11 * kStride, 1);
  const std::vector<double> c = Normals(11 * shape.num_outputs, 2);
  const auto loss = [&] {
    double sum = 0;
    for (int first = 0, chunk = 1; first < 11; first += sizes[chunk--]) {
      const double* y = mlp.Forward(net.weights, &x[first * kStride], sizes[chunk], &tape);
      for (int i = 0; i < sizes[chunk] * shape.num_outputs; ++i) sum += c[first * shape.num_outputs + i] * y[i];
    }
    return sum;
  };
  std::fill(net.gradient.begin(), net.gradient.end(), 7.0);  // of an earlier batch
  for (int first = 0, chunk = 1; first < 11; first += sizes[chunk--]) {
    mlp.LossGradient(net.weights, &x[first * kStride], sizes[chunk],
                     first == 0 ? Accumulate::kOverwrite : Accumulate::kAdd, &tape, &net.gradient,
                     [&](int block, int count, const double* /*y*/, double* d_y) {
                       std::copy_n(&c[(first + block) * shape.num_outputs], count * shape.num_outputs, d_y);
                     });
  }
  mlp.FinishGradient(&net.gradient);
  ExpectGradient({net.weights.values.data(), net.weights.values.size()}, net.finished_gradient(), loss,
                 [&] { mlp.RefreshTransposed(&net.weights); });
}

TEST_P(MlpGradientTest, InputGradientIsTheDerivativeForChosenSamples) {
  MlpShape shape = GetParam();
  shape.num_outputs = 1;
  const int n = 7;
  const Mlp<double> mlp(shape, kStride, {n});
  const TrainedMlp<double> net(mlp, 1, 0);
  MlpTape<double> tape(shape, n), other(shape, n);
  std::vector<double> x = Normals(n * kStride, 1);
  mlp.Forward(net.weights, x.data(), n, &tape);
  const std::vector<int> samples{6, 1, 2, 4, 5};
  const int first = 3, count = shape.num_inputs - first;
  std::vector<double> d_input(count * samples.size());
  mlp.InputGradient(net.weights, samples, first, count, &tape, d_input.data());
  for (size_t p = 0; p < samples.size(); ++p) {
    ExpectGradient(
        std::span(x).subspan(samples[p] * kStride + first, count), std::span(d_input).subspan(p * count),
        [&] { return mlp.Forward(net.weights, x.data(), n, &other)[samples[p]]; }, [] {});
  }
}

// Includes narrow layers (fewer than 16 outputs), wide heads and one hidden layer.
INSTANTIATE_TEST_SUITE_P(Shapes, MlpGradientTest,
                         testing::Values(MlpShape{5, {18, 7}, 2, false}, MlpShape{5, {18, 7}, 2, true},
                                         MlpShape{7, {24}, 1, false}, MlpShape{5, {6, 17, 20}, 19, true}));

TEST(MlpTest, ForwardAgreesWithPolicyInference) {
  PolicyShape policy_shape;
  policy_shape.observation_size = 9;
  policy_shape.action_size = 2;
  policy_shape.head = PolicyShape::Head::kDeterministic;
  policy_shape.net_arch = {32, 24};
  for (bool layer_norm : {false, true}) {
    policy_shape.layer_norm = layer_norm;
    const MlpShape shape{9, {32, 24}, 2, layer_norm};
    const Mlp<float> mlp(shape, 9, {16});
    const TrainedMlp<float> net(mlp, 4, 0);
    ASSERT_EQ(net.parameters().size(), policy_shape.num_parameters());
    Policy policy(policy_shape, 16);
    policy.SetParameters(net.parameters());
    const std::vector<double> normals = Normals(16 * 9, 5);
    const std::vector<float> x(normals.begin(), normals.end());
    MlpTape<float> tape(shape, 16);
    const float* y = mlp.Forward(net.weights, x.data(), 16, &tape);
    std::vector<float> actions(32);
    policy.Act(x.data(), 16, actions.data());
    for (int i = 0; i < 32; ++i) EXPECT_NEAR(actions[i], std::tanh(y[i]), 1e-6);
  }
}

// Across blocks, which share the room for activations that are not kept.
TEST(MlpTest, ValueHasTheBitsOfForwardWhateverStandsBesideASample) {
  for (const MlpShape& shape : {MlpShape{9, {64, 64}, 1, false}, MlpShape{9, {40, 24}, 3, false},
                                MlpShape{9, {64, 24}, 2, true}, MlpShape{9, {32}, 20, false}}) {
    const int n = 203;
    const Mlp<float> mlp(shape, kStride, {1, n});
    const TrainedMlp<float> net(mlp, 4, 0);
    MlpTape<float> tape(shape, n), other(shape, n);
    const std::vector<double> normals = Normals(n * kStride, 5);
    const std::vector<float> x(normals.begin(), normals.end());
    const float* y = mlp.Forward(net.weights, x.data(), n, &tape);
    const size_t size = shape.num_outputs * sizeof(float);
    EXPECT_EQ(std::memcmp(y, mlp.Value(net.weights, x.data(), n, &other), n * size), 0);
    for (int j = 0; j < n; ++j) {
      const float* alone = mlp.Value(net.weights, x.data() + j * kStride, 1, &other);
      ASSERT_EQ(std::memcmp(y + j * shape.num_outputs, alone, size), 0) << "sample " << j;
    }
  }
}

TEST(TrainedMlpTest, StartsUniformWithinPyTorchsBound) {
  const MlpShape shape{16, {64}, 4, false};
  const Mlp<float> mlp(shape, 16, {8});
  const TrainedMlp<float> net(mlp, 4, 0), other(mlp, 5, 0), twin(mlp, 4, 1);
  double sum = 0, squares = 0;
  for (size_t i = 0; i < 16 * 64; ++i) {
    ASSERT_LE(std::fabs(net.weights.values[i]), 0.25f);
    sum += net.weights.values[i];
    squares += net.weights.values[i] * net.weights.values[i];
  }
  EXPECT_NEAR(sum / 1024, 0.0, 0.02);
  EXPECT_NEAR(squares / 1024, 0.25 * 0.25 / 3, 0.002);
  EXPECT_NE(net.weights.values[0], other.weights.values[0]);
  EXPECT_NE(net.weights.values[0], twin.weights.values[0]);
}

}  // namespace
}  // namespace cairn::learner
