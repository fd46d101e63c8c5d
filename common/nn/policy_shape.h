#pragma once

#include "common/config/experiment.h"
#include "common/nn/policy.h"

namespace cairn {

/// Shape of the policy that an experiment trains: head by algorithm, sizes by observation and actions.
PolicyShape MakePolicyShape(const Experiment& experiment);

}  // namespace cairn
