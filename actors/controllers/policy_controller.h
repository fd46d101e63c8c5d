#pragma once

#include <vector>

#include "actors/controllers/controller.h"
#include "common/nn/policy.h"

namespace cairn::actors {

/// A policy network, deterministic, batched.
class PolicyController final : public Controller {
 public:
  /// `policy` must outlive the controller and take observations of the environments' size; at most `max_batch`
  /// environments at a time (the policy's own limit).
  PolicyController(Policy& policy, int max_batch);

  void Act(std::span<const Environment* const> environments, float* actions) override;

 private:
  Policy& policy_;
  std::vector<float> observations_;
};

}  // namespace cairn::actors
