#include "learner/algorithms/saved_values.h"

#include <algorithm>
#include <cstring>
#include <string>

#include "common/core/check.h"
#include "learner/algorithms/batch.h"
#include "learner/algorithms/shapes.h"

namespace cairn::learner {
namespace {

std::vector<float> Numbers(const std::vector<StateArray>& networks, const std::string& name, size_t count) {
  const auto array =
      std::find_if(networks.begin(), networks.end(), [&](const StateArray& a) { return a.name == name; });
  if (array == networks.end()) ThrowError("the saved networks have no {}", name);
  if (array->data.size() != count * sizeof(float)) {
    ThrowError("the saved {} has {} bytes, the policy's shape asks for {}", name, array->data.size(),
               count * sizeof(float));
  }
  std::vector<float> numbers(count);
  std::memcpy(numbers.data(), array->data.data(), array->data.size());
  return numbers;
}

}  // namespace

SavedValues::SavedValues(const PolicyShape& shape, const std::vector<StateArray>& networks)
    : shape_(shape),
      stride_(BatchStride(shape.observation_size, shape.action_size)),
      policy_(shape, kBatch),
      critics_(CriticMlpShape(shape), stride_, {kBatch}, shape.action_size, 0),
      work_(critics_.MakeWork(0)),
      input_(static_cast<size_t>(stride_) * kBatch),
      actions_(static_cast<size_t>(shape.action_size) * kBatch),
      values_(kBatch) {
  policy_.SetParameters(Numbers(networks, "policy", shape.num_parameters()));
  for (int i = 0; i < 2; ++i) {
    auto& weights = critics_.critic(i).weights.values;
    const std::vector<float> numbers = Numbers(networks, i == 0 ? "q1" : "q2", weights.size());
    std::copy(numbers.begin(), numbers.end(), weights.begin());
  }
  critics_.StateChanged();
}

void SavedValues::Evaluate(const float* observations, int n, float* values) {
  for (int first = 0; first < n; first += kBatch) {
    EvaluateBatch(observations + static_cast<size_t>(first) * shape_.observation_size, std::min(kBatch, n - first),
                  values + first);
  }
}

// The critics' passes have kBatch columns; those beyond n keep what they had.
void SavedValues::EvaluateBatch(const float* observations, int n, float* values) {
  policy_.Act(observations, n, actions_.data());
  for (int j = 0; j < n; ++j) {
    float* column = input_.data() + static_cast<size_t>(j) * stride_;
    column =
        std::copy_n(observations + static_cast<size_t>(j) * shape_.observation_size, shape_.observation_size, column);
    std::copy_n(actions_.data() + static_cast<size_t>(j) * shape_.action_size, shape_.action_size, column);
  }
  critics_.MinQ(input_.data(), kBatch, &work_, values_.data());
  std::copy_n(values_.data(), n, values);
}

}  // namespace cairn::learner
