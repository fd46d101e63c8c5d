#include "learner/algorithms/twin_critic.h"

#include <algorithm>
#include <numeric>
#include <span>

#include "common/nn/layers.h"

namespace cairn::learner {
namespace {

using cairn::layers::LaneSum;

double Square(double x) { return x * x; }

size_t Padded(int samples) { return static_cast<size_t>((samples + 15) / 16 * 16); }

}  // namespace

template <typename Scalar>
TwinCritic<Scalar>::Work::Work(const Mlp<Scalar>& mlp, int action_size, bool own_gradient)
    : tape{MlpTape<Scalar>(mlp.shape(), mlp.max_columns()), MlpTape<Scalar>(mlp.shape(), mlp.max_columns())},
      d_input(Padded(mlp.max_columns()) * action_size) {
  for (auto& samples : chosen) samples = AlignedBuffer<int>(Padded(mlp.max_columns()));
  if (!own_gradient) return;
  for (auto& g : gradient) g = mlp.MakeGradientBuffer();
}

template <typename Scalar>
TwinCritic<Scalar>::TwinCritic(const MlpShape& shape, int input_stride, const std::vector<int>& columns,
                               int action_size, uint64_t seed)
    : mlp_(shape, input_stride, columns),
      action_size_(action_size),
      critics_{TrainedMlp<Scalar>(mlp_, seed, 1), TrainedMlp<Scalar>(mlp_, seed, 2)},
      targets_{CopyWeights(mlp_, critics_[0].weights), CopyWeights(mlp_, critics_[1].weights)} {}

template <typename Scalar>
void TwinCritic<Scalar>::MinTargetQ(const Scalar* input, int n, Work* work, Scalar* q) const {
  std::copy_n(mlp_.Value(targets_[0], input, n, &work->tape[0]), n, q);
  const Scalar* q2 = mlp_.Value(targets_[1], input, n, &work->tape[0]);
  for (int j = 0; j < n; ++j) q[j] = q2[j] < q[j] ? q2[j] : q[j];
}

template <typename Scalar>
void TwinCritic<Scalar>::Regress(const Scalar* input, const Scalar* target_q, int n, Scalar weight,
                                 Accumulate accumulate, Work* work) {
  if (accumulate == Accumulate::kOverwrite) work->squared_error = work->q = 0;
  MlpTape<Scalar>* tape = &work->tape[0];
  for (int i = 0; i < 2; ++i) {
    mlp_.LossGradient(critics_[i].weights, input, n, accumulate, tape, GradientOf(&critics_[i], &work->gradient[i]),
                      [=](int first, int count, const Scalar* q, Scalar* d_q) {
                        for (int j = 0; j < count; ++j) d_q[j] = weight * (q[j] - target_q[first + j]);
                      });
    const Scalar* q = tape->output.data();
    work->squared_error += LaneSum<double>(n, [=](int j) { return Square(static_cast<double>(q[j] - target_q[j])); });
    work->q += LaneSum<double>(n, [=](int j) { return static_cast<double>(q[j]); });
  }
}

template <typename Scalar>
void TwinCritic<Scalar>::AddRegression(const Work& part, Work* sum) {
  for (int i = 0; i < 2; ++i) AddGradient(part.gradient[i], &critics_[i].gradient);
  sum->squared_error += part.squared_error;
  sum->q += part.q;
}

template <typename Scalar>
void TwinCritic<Scalar>::Step(double learning_rate, double max_grad_norm) {
  TrainedMlp<Scalar>* const both[] = {&critics_[0], &critics_[1]};
  ApplyGradients<Scalar>(mlp_, both, learning_rate, max_grad_norm, "critics");
}

template <typename Scalar>
void TwinCritic<Scalar>::FirstQ(const Scalar* input, int n, Work* work, Scalar* q) const {
  std::copy_n(mlp_.Forward(critics_[0].weights, input, n, &work->tape[0]), n, q);
  std::iota(work->chosen[0].begin(), work->chosen[0].begin() + n, 0);
}

template <typename Scalar>
void TwinCritic<Scalar>::MinQ(const Scalar* input, int n, Work* work, Scalar* q) const {
  const Scalar* q1 = mlp_.Forward(critics_[0].weights, input, n, &work->tape[0]);
  const Scalar* q2 = mlp_.Forward(critics_[1].weights, input, n, &work->tape[1]);
  int num_first = 0, num_second = 0;
  for (int j = 0; j < n; ++j) {  // without a branch: which one it is cannot be predicted
    const bool second = q2[j] < q1[j];
    q[j] = second ? q2[j] : q1[j];
    work->chosen[0][num_first] = j;
    work->chosen[1][num_second] = j;
    num_first += second ? 0 : 1;
    num_second += second ? 1 : 0;
  }
  work->num_chosen = {num_first, num_second};
}

template <typename Scalar>
void TwinCritic<Scalar>::ActionGradient(Work* work, Scalar* d_action, int stride) const {
  const int first_action = mlp_.shape().num_inputs - action_size_;
  for (int i = 0; i < 2; ++i) {
    const std::span<const int> samples(work->chosen[i].data(), work->num_chosen[i]);
    if (samples.empty()) continue;
    mlp_.InputGradient(critics_[i].weights, samples, first_action, action_size_, &work->tape[i], work->d_input.data());
    for (size_t p = 0; p < samples.size(); ++p) {
      for (int a = 0; a < action_size_; ++a) {
        d_action[static_cast<size_t>(a) * stride + samples[p]] = work->d_input[p * action_size_ + a];
      }
    }
  }
}

template <typename Scalar>
const Scalar* TwinCritic<Scalar>::FirstActionGradient(int n, Work* work) const {
  const std::span<const int> samples(work->chosen[0].data(), n);
  mlp_.InputGradient(critics_[0].weights, samples, mlp_.shape().num_inputs - action_size_, action_size_, &work->tape[0],
                     work->d_input.data());
  return work->d_input.data();
}

template <typename Scalar>
void TwinCritic<Scalar>::UpdateTargets(double tau) {
  for (int i = 0; i < 2; ++i) {
    Polyak<Scalar>(tau, critics_[i].parameters(), {targets_[i].values.data(), targets_[i].values.size()});
  }
}

template class TwinCritic<float>;
template class TwinCritic<double>;

}  // namespace cairn::learner
