#include "actors/controllers/policy_controller.h"

#include "common/core/check.h"

namespace cairn::actors {

PolicyController::PolicyController(Policy& policy, int max_batch)
    : policy_(policy),
      observations_(static_cast<size_t>(max_batch) * static_cast<size_t>(policy.shape().observation_size)) {}

void PolicyController::Act(std::span<const Environment* const> environments, float* actions) {
  const auto size = static_cast<size_t>(policy_.shape().observation_size);
  CAIRN_CHECK(environments.size() * size <= observations_.size());
  float* row = observations_.data();
  for (const Environment* environment : environments) {
    CAIRN_DCHECK(policy_.shape().observation_size == ObservationSize(environment->scene().experiment()));
    environment->Observe(row);
    row += size;
  }
  policy_.Act(observations_.data(), static_cast<int>(environments.size()), actions);
}

}  // namespace cairn::actors
