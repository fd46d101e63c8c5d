#pragma once

#include <cstdint>
#include <vector>

#include "common/config/experiment.h"
#include "common/core/random.h"
#include "common/nn/policy.h"
#include "learner/algorithms/batch.h"

namespace cairn::learner {

/// The batches of the tests are complete.
inline BatchFeeder* Complete() {
  static BatchFeeder feeder;
  return &feeder;
}

/// Sizes that leave nothing even: two chunks of different size, a narrow layer, three actions.
inline LearnerConfig SmallConfig() {
  LearnerConfig config;
  config.net_arch = {18, 10};
  config.batch_size = 151;
  config.target_entropy = -3.0;
  config.initial_alpha = 0.2;
  return config;
}

inline PolicyShape SmallShape(const LearnerConfig& config, PolicyShape::Head head) {
  PolicyShape shape;
  shape.head = head;
  shape.observation_size = 4;
  shape.action_size = 3;
  shape.net_arch = config.net_arch;
  shape.layer_norm = config.layer_norm;
  return shape;
}

/// Random transitions and noise, the same values in float and double.
template <typename Scalar>
void FillBatch(uint32_t index, Batch<Scalar>* batch) {
  RandomStream random(11, RandomPurpose::kTest, index);
  const auto normal = [&] { return static_cast<Scalar>(static_cast<float>(random.Normal())); };
  for (int j = 0; j < batch->size(); ++j) {
    for (int i = 0; i < batch->observation_size(); ++i) batch->input(j)[i] = normal();
    for (int i = 0; i < batch->observation_size(); ++i) batch->next_input(j)[i] = normal();
    for (int i = 0; i < batch->action_size(); ++i) {
      batch->action(j)[i] = static_cast<Scalar>(static_cast<float>(random.Uniform(-1.0, 1.0)));
    }
    batch->reward(j) = normal();
    batch->discount(j) = j % 5 == 0 ? Scalar{0} : static_cast<Scalar>(0.96875f);
  }
  for (int i = 0; i < batch->size() * batch->action_size(); ++i) {
    batch->noise()[i] = normal();
    batch->next_noise()[i] = normal();
  }
}

template <typename Scalar>
Batch<Scalar> MakeBatch(const LearnerConfig& config, const PolicyShape& shape, uint32_t index = 0) {
  Batch<Scalar> batch(config.batch_size, shape.observation_size, shape.action_size);
  FillBatch(index, &batch);
  return batch;
}

/// Largest ‖a − b‖ / ‖b‖ is what the tests bound.
template <typename A, typename B>
double RelativeDistance(const A& a, const B& b) {
  double difference = 0, norm = 0;
  for (size_t i = 0; i < b.size(); ++i) {
    difference += (a[i] - b[i]) * (a[i] - b[i]);
    norm += static_cast<double>(b[i]) * b[i];
  }
  return std::sqrt(difference / norm);
}

}  // namespace cairn::learner
