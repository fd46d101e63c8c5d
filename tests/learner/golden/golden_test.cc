// 20 consecutive updates against PyTorch in float64 (make_golden.py, which also describes the files).

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <type_traits>
#include <vector>

#include "common/core/check.h"
#include "learner/algorithms/sac.h"
#include "learner/algorithms/td3.h"
#include "tests/learner/algorithms/update_fixture.h"

namespace cairn::learner {
namespace {

constexpr int kObservations = 5;
constexpr int kActions = 2;
constexpr int kBatchSize = 32;
constexpr int kUpdates = 20;

/// name → values, as in one golden file.
class Records {
 public:
  explicit Records(const std::string& name) {
    std::ifstream file(std::string(CAIRN_SOURCE_DIR) + "/tests/learner/golden/" + name + ".txt");
    for (std::string line; std::getline(file, line);) {
      const size_t name_end = line.find(' ');
      std::vector<double>& values = records_[line.substr(0, name_end)];
      const char* p = line.c_str() + name_end;
      for (char* end; *p != '\0'; p = end) values.push_back(std::strtod(p, &end));
    }
    CAIRN_CHECK(!records_.empty(), "no golden file {}", name);
  }

  const std::vector<double>& operator[](const std::string& name) const { return records_.at(name); }
  double scalar(const std::string& name) const { return records_.at(name).at(0); }
  bool has(const std::string& name) const { return records_.count(name) > 0; }

 private:
  std::map<std::string, std::vector<double>> records_;
};

template <typename Scalar>
void ReadBatch(const Records& file, int number, Batch<Scalar>* batch) {
  const std::string prefix = std::to_string(number) + "/";
  const auto copy = [](const std::vector<double>& from, int j, int n, Scalar* to) {
    for (int i = 0; i < n; ++i) to[i] = static_cast<Scalar>(from.at(static_cast<size_t>(j) * n + i));
  };
  for (int j = 0; j < kBatchSize; ++j) {
    copy(file[prefix + "observation"], j, kObservations, batch->input(j));
    copy(file[prefix + "action"], j, kActions, batch->action(j));
    copy(file[prefix + "reward"], j, 1, &batch->reward(j));
    copy(file[prefix + "discount"], j, 1, &batch->discount(j));
    copy(file[prefix + "next_observation"], j, kObservations, batch->next_input(j));
    for (int a = 0; a < kActions; ++a) {
      const size_t from = static_cast<size_t>(j) * kActions + a, to = static_cast<size_t>(a) * kBatchSize + j;
      batch->noise()[to] = static_cast<Scalar>(file[prefix + "noise"].at(from));
      batch->next_noise()[to] = static_cast<Scalar>(file[prefix + "next_noise"].at(from));
    }
  }
}

/// Calls visit(name in the files, weights) for every tensor of `network`.
template <typename Scalar, typename Weights, typename Visit>
void ForEachTensor(const std::string& network, const Mlp<Scalar>& mlp, Weights* weights, Visit visit) {
  int l = 0;
  for (const MlpLayer& layer : mlp.layers()) {
    const std::string prefix = network + "/" + std::to_string(l++) + "/";
    const auto tensor = [&](const char* name, size_t first, size_t size) {
      visit(prefix + name, std::span(weights->values.data() + first, size));
    };
    tensor("weights", layer.weights, layer.bias - layer.weights);
    tensor("bias", layer.bias, layer.out);
    if (!layer.hidden || !mlp.shape().layer_norm) continue;
    tensor("gain", layer.gain, layer.out);
    tensor("offset", layer.offset, layer.out);
  }
}

/// Sac or Td3 in float or double on the golden batches, started from the golden weights.
template <typename Method, typename Scalar>
class GoldenRun {
 public:
  static constexpr bool kIsSac = Method::kUsesNoise;

  explicit GoldenRun(const Records& file)
      : config_(Config(file)),
        method_(config_, SmallShapeOf(config_), 1),
        batch_(kBatchSize, kObservations, kActions),
        batches_("batches") {
    ForEachNetwork([&](const std::string& name, const Mlp<Scalar>& mlp, MlpWeights<Scalar>* weights) {
      ForEachTensor(name, mlp, weights, [&](const std::string& tensor, std::span<Scalar> values) {
        const std::vector<double>& from = file["0/" + tensor];
        CAIRN_CHECK(from.size() == values.size(), "{}: {} values, not {}", tensor, from.size(), values.size());
        std::transform(from.begin(), from.end(), values.begin(), [](double v) { return static_cast<Scalar>(v); });
      });
      mlp.RefreshTransposed(weights);
    });
  }

  /// Makes update `number` (from 1 on) and returns what the files call its losses; the last of SAC's is the new alpha.
  std::vector<double> Update(int number) {
    ReadBatch(batches_, number, &batch_);
    const UpdateInfo info = method_.Update(&batch_, config_.learning_rate, Complete());
    std::vector<double> losses{info.critic_loss};
    if (info.num_actor_updates > 0) losses.push_back(info.actor_loss);
    if constexpr (kIsSac) {
      losses.push_back(info.alpha_loss);
      losses.push_back(method_.alpha());
    }
    return losses;
  }

  /// visit(network, mlp, weights), targets included.
  template <typename Visit>
  void ForEachNetwork(Visit visit) {
    const Mlp<Scalar>& critic = method_.critics().mlp();
    visit("policy", method_.policy_mlp(), &method_.policy().weights);
    visit("q1", critic, &method_.critics().critic(0).weights);
    visit("q2", critic, &method_.critics().critic(1).weights);
    visit("target_q1", critic, &method_.critics().target(0));
    visit("target_q2", critic, &method_.critics().target(1));
    if constexpr (!kIsSac) visit("target_policy", method_.policy_mlp(), &method_.policy_target());
  }

  /// name → values of all tensors now.
  std::map<std::string, std::vector<double>> Tensors() {
    std::map<std::string, std::vector<double>> tensors;
    ForEachNetwork([&](const std::string& name, const Mlp<Scalar>& mlp, const MlpWeights<Scalar>* weights) {
      ForEachTensor(name, mlp, weights, [&](const std::string& tensor, std::span<const Scalar> values) {
        tensors[tensor].assign(values.begin(), values.end());
      });
    });
    return tensors;
  }

 private:
  static LearnerConfig Config(const Records& file) {
    LearnerConfig config;
    config.algorithm = kIsSac ? LearnerConfig::Algorithm::kSac : LearnerConfig::Algorithm::kTd3;
    config.net_arch = {16, 16};
    config.batch_size = kBatchSize;
    config.layer_norm = file.scalar("layer_norm") != 0;
    config.max_grad_norm = file.scalar("max_grad_norm");
    config.learning_rate = file.scalar("learning_rate");
    config.tau = file.scalar("tau");
    config.initial_alpha = file.scalar("initial_alpha");
    config.target_entropy = file.scalar("target_entropy");
    config.policy_delay = static_cast<int>(file.scalar("policy_delay"));
    config.target_policy_noise = file.scalar("target_policy_noise");
    config.target_noise_clip = file.scalar("target_noise_clip");
    return config;
  }

  static PolicyShape SmallShapeOf(const LearnerConfig& config) {
    PolicyShape shape = SmallShape(config, kIsSac ? PolicyShape::Head::kGaussian : PolicyShape::Head::kDeterministic);
    shape.observation_size = kObservations;
    shape.action_size = kActions;
    return shape;
  }

  LearnerConfig config_;
  Method method_;
  Batch<Scalar> batch_;
  Records batches_;
};

void ExpectRelative(const std::vector<double>& values, const std::vector<double>& expected, double tolerance,
                    const std::string& what) {
  ASSERT_EQ(values.size(), expected.size()) << what;
  for (size_t i = 0; i < values.size(); ++i) {
    EXPECT_NEAR(values[i], expected[i], tolerance * std::fabs(expected[i])) << what << ", entry " << i;
  }
}

/// The double path against the file: every loss, alpha and weight.
template <typename Method>
void ExpectDoubleAgrees(const Records& file) {
  GoldenRun<Method, double> run(file);
  int snapshots = 0;
  for (int number = 1; number <= kUpdates; ++number) {
    const std::string prefix = std::to_string(number) + "/";
    ExpectRelative(run.Update(number), file[prefix + "losses"], 1e-9, prefix + "losses");
    if (!file.has(prefix + "policy/0/weights")) continue;
    ++snapshots;
    for (const auto& [name, values] : run.Tensors()) ExpectRelative(values, file[prefix + name], 1e-9, prefix + name);
  }
  EXPECT_EQ(snapshots, 3);
}

/// The float path against the double path.
template <typename FloatMethod, typename DoubleMethod>
void ExpectFloatFollows(const Records& file) {
  GoldenRun<FloatMethod, float> run(file);
  GoldenRun<DoubleMethod, double> reference(file);
  for (int number = 1; number <= kUpdates; ++number) {
    const std::vector<double> losses = run.Update(number);
    ExpectRelative(losses, reference.Update(number), 1e-4, std::to_string(number) + "/losses");
  }
  const auto expected = reference.Tensors();
  for (const auto& [name, values] : run.Tensors()) EXPECT_LE(RelativeDistance(values, expected.at(name)), 1e-3) << name;
}

class GoldenTest : public testing::TestWithParam<const char*> {
 protected:
  GoldenTest() : file_(GetParam()), sac_(std::string(GetParam()).starts_with("sac")) {}

  Records file_;
  bool sac_;
};

TEST_P(GoldenTest, DoubleAgreesWithPyTorch) {
  if (sac_) {
    ExpectDoubleAgrees<Sac<double>>(file_);
  } else {
    ExpectDoubleAgrees<Td3<double>>(file_);
  }
}

TEST_P(GoldenTest, FloatFollowsDouble) {
  if (sac_) {
    ExpectFloatFollows<Sac<float>, Sac<double>>(file_);
  } else {
    ExpectFloatFollows<Td3<float>, Td3<double>>(file_);
  }
}

INSTANTIATE_TEST_SUITE_P(Cases, GoldenTest, testing::Values("sac", "sac_layer_norm", "td3", "td3_layer_norm"),
                         [](const auto& test) { return std::string(test.param); });

}  // namespace
}  // namespace cairn::learner
