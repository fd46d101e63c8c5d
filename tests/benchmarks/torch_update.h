#pragma once

#include <memory>
#include <string>

#include "common/config/experiment.h"
#include "common/nn/policy.h"
#include "learner/replay/replay_buffer.h"

namespace cairn::learner {

/// How the parameters are kept. kPlain: a tensor for each weight and bias and torch::optim::Adam, as libtorch has it.
/// kFlat: parameters and gradients of all networks that step together are one flat tensor, so that Adam, targets and
/// zeroing are a few calls, our own code around libtorch's.
enum class TorchStyle { kPlain, kFlat };

/// The updates of SAC and TD3 in libtorch's C++, on one thread: what ours are compared with. In both styles passes
/// without a gradient run in inference mode, the policy's loss computes no derivatives by the critics' parameters, and
/// a batch is one index_select.
class TorchUpdate {
 public:
  TorchUpdate(TorchStyle style, const LearnerConfig& config, const PolicyShape& shape, const ReplayBuffer& replay);
  ~TorchUpdate();

  void Update(int count);

  /// Of the last update.
  double critic_loss() const;

 private:
  class Method;
  std::unique_ptr<Method> method_;
};

/// libtorch's version and the library that its matrix products come from.
std::string TorchVersion();

/// Restarts the program with the best settings of OpenBLAS 0.3.21, which reads them from the environment when it is
/// loaded: one thread and, on a processor with AVX-512, the kernels for it (6 to 20 % faster at 64x64/1024 than what it
/// chooses by itself). Does nothing when OPENBLAS_NUM_THREADS is set.
void UseBestTorchSettings(char** argv);

}  // namespace cairn::learner
