#include "common/nn/policy_shape.h"

namespace cairn {

PolicyShape MakePolicyShape(const Experiment& experiment) {
  PolicyShape shape;
  shape.head = experiment.learner.algorithm == LearnerConfig::Algorithm::kSac ? PolicyShape::Head::kGaussian
                                                                              : PolicyShape::Head::kDeterministic;
  shape.observation_size = ObservationSize(experiment);
  shape.action_size = experiment.vehicle.action_size();
  shape.net_arch = experiment.learner.net_arch;
  shape.layer_norm = experiment.learner.layer_norm;
  return shape;
}

}  // namespace cairn
