#pragma once

#include <span>

#include "actors/environment.h"

namespace cairn::actors {

/// Chooses actions for a batch of running environments. One thread.
class Controller {
 public:
  virtual ~Controller() = default;

  /// Writes `actions` [n × action_size], one row per environment, in [−1, 1]. A row may depend on its own environment
  /// only, so that results do not depend on how episodes are batched.
  virtual void Act(std::span<const Environment* const> environments, float* actions) = 0;
};

}  // namespace cairn::actors
