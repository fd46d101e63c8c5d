#pragma once

#include "common/nn/policy.h"
#include "learner/algorithms/mlp.h"

namespace cairn::learner {

/// The policy's network; its parameters are in PolicyShape's order.
inline MlpShape PolicyMlpShape(const PolicyShape& shape) {
  return {shape.observation_size, shape.net_arch, shape.output_size(), shape.layer_norm};
}

/// A critic's network Q(s, a): the policy's hidden layers, input observation | action.
inline MlpShape CriticMlpShape(const PolicyShape& shape) {
  return {shape.observation_size + shape.action_size, shape.net_arch, 1, shape.layer_norm};
}

}  // namespace cairn::learner
