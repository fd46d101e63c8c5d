#pragma once

#include <string>

namespace cairn::deploy {

/// A block of five UDP ports (common/bus/bus.h: four planes and this guard) that no other run on this host has. Held
/// by a bound socket until destruction, whatever way the process ends.
class PortBlock {
 public:
  /// Takes the block at `base_port` or the next free one after it. Throws Error when none is free up to 65535.
  static PortBlock Claim(int base_port);

  PortBlock(PortBlock&& other) noexcept;
  PortBlock& operator=(PortBlock&&) = delete;
  ~PortBlock();

  int base_port() const { return base_port_; }
  /// Why `Claim` went past the port asked for; empty when it did not.
  const std::string& note() const { return note_; }

 private:
  PortBlock(int fd, int base_port, std::string note);

  int fd_;
  int base_port_;
  std::string note_;
};

}  // namespace cairn::deploy
