#pragma once

#include <cstdint>
#include <string>

namespace cairn {

/// What the processor can do at most: fused multiply-adds on registers alone, in enough independent chains to hide
/// their latency.
class FmaPeak {
 public:
  /// `target`: libxsmm's name of the instruction set that its kernels use (GemmTarget). The loop uses the same width.
  explicit FmaPeak(const std::string& target);

  /// Runs for about `flops` floating-point operations and returns how many they were exactly.
  double Run(double flops);

  /// Bits of a vector: 512, 256 or 32.
  int width() const { return width_; }

 private:
  int width_;
  float sink_ = 0;
};

}  // namespace cairn
