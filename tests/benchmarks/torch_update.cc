#include "tests/benchmarks/torch_update.h"

#include <dlfcn.h>
#include <torch/torch.h>
#include <unistd.h>

#include <climits>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <vector>

namespace cairn::learner {
namespace {

using torch::Tensor;

/// Adam on one flat tensor.
class FlatAdam {
 public:
  explicit FlatAdam(const Tensor& values) : first_(torch::zeros_like(values)), second_(torch::zeros_like(values)) {}

  void Step(double learning_rate, const Tensor& gradient, Tensor* values) {
    ++steps_;
    first_.mul_(0.9).add_(gradient, 0.1);
    second_.mul_(0.999).addcmul_(gradient, gradient, 0.001);
    const double root = std::sqrt(1 - std::pow(0.999, steps_));
    // lr m^ / (sqrt(v^) + epsilon) with both corrections in the scalars
    values->addcdiv_(first_, second_.sqrt().add_(1e-8 * root), -learning_rate * root / (1 - std::pow(0.9, steps_)));
  }

 private:
  Tensor first_, second_;
  int steps_ = 0;
};

/// Networks of ReLU layers and their Adam. kPlain: a tensor for each weight and bias and libtorch's own optimiser.
/// kFlat: parameters are views of one flat tensor, and so are the gradients, so that Adam and Polyak averages are a few
/// passes.
class Mlps {
 public:
  Mlps(TorchStyle style, int count, int inputs, const std::vector<int>& net_arch, int outputs)
      : style_(style), count_(count) {
    std::vector<int> sizes{inputs};
    sizes.insert(sizes.end(), net_arch.begin(), net_arch.end());
    sizes.push_back(outputs);
    int64_t size = 0;
    for (size_t l = 0; l + 1 < sizes.size(); ++l) size += static_cast<int64_t>(sizes[l] + 1) * sizes[l + 1];
    values_ = torch::empty({count * size});
    gradient_ = torch::zeros({count * size});
    int64_t position = 0;
    for (int i = 0; i < count; ++i) {
      for (size_t l = 0; l + 1 < sizes.size(); ++l) {
        const double bound = 1 / std::sqrt(static_cast<double>(sizes[l]));
        AddParameter({sizes[l + 1], sizes[l]}, bound, &position);
        AddParameter({sizes[l + 1]}, bound, &position);
      }
    }
  }

  void UseAdam(double learning_rate) {
    if (style_ == TorchStyle::kFlat) flat_adam_.emplace(values_);
    if (style_ == TorchStyle::kPlain) {
      adam_ = std::make_unique<torch::optim::Adam>(parameters_, torch::optim::AdamOptions(learning_rate));
    }
  }

  Tensor operator()(int i, Tensor x) const {
    const size_t each = parameters_.size() / count_, first = i * each;
    for (size_t p = first; p < first + each; p += 2) {
      x = torch::addmm(parameters_[p + 1], x, parameters_[p].t());
      if (p + 2 < first + each) x.relu_();
    }
    return x;
  }

  void Step(double learning_rate) {
    if (style_ == TorchStyle::kPlain) {
      adam_->step();
      adam_->zero_grad();
      return;
    }
    torch::NoGradGuard guard;
    flat_adam_->Step(learning_rate, gradient_, &values_);
    gradient_.zero_();
  }

  void Follow(const Mlps& online, double tau) {
    torch::NoGradGuard guard;
    if (style_ == TorchStyle::kFlat) {
      values_.lerp_(online.values_, tau);
      return;
    }
    for (size_t p = 0; p < parameters_.size(); ++p) parameters_[p].lerp_(online.parameters_[p], tau);
  }

  const std::vector<Tensor>& parameters() const { return parameters_; }

 private:
  void AddParameter(std::vector<int64_t> shape, double bound, int64_t* position) {
    int64_t size = 1;
    for (int64_t n : shape) size *= n;
    Tensor values = values_.narrow(0, *position, size).view(shape);
    values.uniform_(-bound, bound);
    const bool flat = style_ == TorchStyle::kFlat;
    Tensor leaf = (flat ? values.detach() : values.clone()).requires_grad_();
    if (flat) leaf.mutable_grad() = gradient_.narrow(0, *position, size).view(shape);
    parameters_.push_back(leaf);
    *position += size;
  }

  TorchStyle style_;
  int count_;
  Tensor values_, gradient_;  // kFlat's
  std::vector<Tensor> parameters_;
  std::optional<FlatAdam> flat_adam_;
  std::unique_ptr<torch::optim::Adam> adam_;
};

struct Samples {
  Tensor input, observation, reward, discount, next_observation;
};

}  // namespace

class TorchUpdate::Method {
 public:
  Method(TorchStyle style, const LearnerConfig& config, const PolicyShape& shape, const ReplayBuffer& replay)
      : config_(config),
        actions_(shape.action_size),
        observations_(shape.observation_size),
        rows_(torch::empty({replay.size(), replay.row_floats()})),
        policy_(style, 1, observations_, config.net_arch, shape.output_size()),
        policy_target_(style, 1, observations_, config.net_arch, shape.output_size()),
        critics_(style, 2, observations_ + actions_, config.net_arch, 1),
        critic_targets_(style, 2, observations_ + actions_, config.net_arch, 1),
        log_alpha_(std::log(config.initial_alpha)) {
    policy_.UseAdam(config.learning_rate);
    critics_.UseAdam(config.learning_rate);
    policy_target_.Follow(policy_, 1);
    critic_targets_.Follow(critics_, 1);
    for (int i = 0; i < replay.size(); ++i) {
      std::copy_n(replay.row(i), replay.row_floats(), rows_.data_ptr<float>() + i * int64_t{replay.row_floats()});
    }
  }

  void Update() {
    const Samples batch = Draw();
    Tensor y;
    {
      torch::InferenceMode guard;
      y = batch.reward + batch.discount * NextValue(batch);
    }
    y = y.clone();  // a plain tensor again
    Tensor loss = torch::mse_loss(critics_(0, batch.input), y) + torch::mse_loss(critics_(1, batch.input), y);
    if (sac()) loss = 0.5 * loss;
    loss.backward();
    critics_.Step(config_.learning_rate);
    critic_loss_ = loss.item<double>();
    if (!sac() && ++num_updates_ % config_.policy_delay != 0) return;

    ActorLoss(batch).backward({}, false, false, policy_.parameters());
    policy_.Step(config_.learning_rate);
    if (sac()) StepAlpha();
    critic_targets_.Follow(critics_, config_.tau);
    if (!sac()) policy_target_.Follow(policy_, config_.tau);
  }

  double critic_loss() const { return critic_loss_; }

 private:
  bool sac() const { return config_.algorithm == LearnerConfig::Algorithm::kSac; }

  Samples Draw() {
    torch::InferenceMode guard;
    const Tensor index = torch::randint(rows_.size(0), {config_.batch_size}, torch::kLong);
    const Tensor rows = rows_.index_select(0, index);
    const int inputs = observations_ + actions_;
    // Contiguous copies: OpenBLAS takes strided rows too, but element-wise kernels and the cat below would not.
    const auto part = [&](int first, int count) { return rows.narrow(1, first, count); };
    Samples samples{part(0, inputs), part(0, observations_), part(inputs, 1), part(inputs + 1, 1),
                    part(inputs + 2, observations_)};
    const c10::InferenceMode plain(false);
    for (Tensor* t :
         {&samples.input, &samples.observation, &samples.reward, &samples.discount, &samples.next_observation}) {
      *t = t->clone(torch::MemoryFormat::Contiguous);
    }
    return samples;
  }

  /// a and log π(a|s) of SAC's squashed Gaussian.
  std::pair<Tensor, Tensor> Sample(const Tensor& observation) const {
    const std::vector<Tensor> heads = policy_(0, observation).chunk(2, 1);
    const Tensor log_std = heads[1].clamp(-20, 2);
    const Tensor noise = torch::randn_like(log_std);
    const Tensor u = heads[0] + log_std.exp() * noise;
    const Tensor action = u.tanh();
    const Tensor terms = noise.square() * -0.5 - log_std - torch::log(1 - action.square() + 1e-6);
    return {action, terms.sum(1, true) - 0.918938533204672742 * actions_};
  }

  Tensor NextValue(const Samples& batch) const {
    Tensor action, entropy;
    if (sac()) {
      std::tie(action, entropy) = Sample(batch.next_observation);
      entropy = entropy.mul_(-std::exp(log_alpha_));
    } else {
      action = policy_target_(0, batch.next_observation).tanh_();
      const Tensor noise = torch::randn_like(action).mul_(config_.target_policy_noise);
      action.add_(noise.clamp_(-config_.target_noise_clip, config_.target_noise_clip)).clamp_(-1, 1);
    }
    const Tensor input = torch::cat({batch.next_observation, action}, 1);
    const Tensor q = torch::min(critic_targets_(0, input), critic_targets_(1, input));
    return sac() ? q + entropy : q;
  }

  Tensor ActorLoss(const Samples& batch) {
    if (!sac()) {
      const Tensor action = policy_(0, batch.observation).tanh();
      return -critics_(0, torch::cat({batch.observation, action}, 1)).mean();
    }
    const auto [action, log_prob] = Sample(batch.observation);
    const Tensor input = torch::cat({batch.observation, action}, 1);
    log_prob_ = log_prob.detach();
    return (std::exp(log_alpha_) * log_prob - torch::min(critics_(0, input), critics_(1, input))).mean();
  }

  void StepAlpha() {
    const double slope = -(log_prob_.mean().item<double>() + config_.target_entropy);
    ++alpha_steps_;
    alpha_first_ = 0.9 * alpha_first_ + 0.1 * slope;
    alpha_second_ = 0.999 * alpha_second_ + 0.001 * slope * slope;
    const double first = alpha_first_ / (1 - std::pow(0.9, alpha_steps_));
    const double second = alpha_second_ / (1 - std::pow(0.999, alpha_steps_));
    log_alpha_ -= config_.learning_rate * first / (std::sqrt(second) + 1e-8);
  }

  LearnerConfig config_;
  int actions_, observations_;
  Tensor rows_;
  Mlps policy_, policy_target_, critics_, critic_targets_;
  Tensor log_prob_;
  double log_alpha_, alpha_first_ = 0, alpha_second_ = 0, critic_loss_ = 0;
  int alpha_steps_ = 0, num_updates_ = 0;
};

TorchUpdate::TorchUpdate(TorchStyle style, const LearnerConfig& config, const PolicyShape& shape,
                         const ReplayBuffer& replay) {
  at::set_num_threads(1);
  at::globalContext().setFlushDenormal(true);
  torch::manual_seed(1);
  method_ = std::make_unique<Method>(style, config, shape, replay);
}

TorchUpdate::~TorchUpdate() = default;

void TorchUpdate::Update(int count) {
  for (int i = 0; i < count; ++i) method_->Update();
}

double TorchUpdate::critic_loss() const { return method_->critic_loss(); }

std::string TorchVersion() {
  Dl_info info{};
  char path[PATH_MAX] = "?";
  if (void* gemm = ::dlsym(RTLD_DEFAULT, "sgemm_"); gemm != nullptr && ::dladdr(gemm, &info) != 0) {
    if (::realpath(info.dli_fname, path) == nullptr) return info.dli_fname;
  }
  return std::string("libtorch " TORCH_VERSION ", ") + path;
}

void UseBestTorchSettings(char** argv) {
  if (std::getenv("OPENBLAS_NUM_THREADS") != nullptr) return;
  ::setenv("OPENBLAS_NUM_THREADS", "1", 1);
  ::setenv("OMP_NUM_THREADS", "1", 1);
  if (__builtin_cpu_supports("avx512f")) ::setenv("OPENBLAS_CORETYPE", "SkylakeX", 0);
  ::execv("/proc/self/exe", argv);
}

}  // namespace cairn::learner
