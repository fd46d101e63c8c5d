#pragma once

#include <cstdio>
#include <memory>
#include <string>

#include "common/rl/segment.h"

namespace cairn {

/// Records what a process made (actor) or took into replay (learner), one line per transition: vehicle, episode, step
/// and a hash of the bits of observation, action, reward and next observation. Comparing the files of all processes of
/// a run shows whether a transition was lost, doubled or changed on the way. Off unless CAIRN_AUDIT_DIR is set.
class AuditLog {
 public:
  /// Opens $CAIRN_AUDIT_DIR/<name>.audit; without the variable every call is a no-op. Throws Error when it cannot.
  explicit AuditLog(const std::string& name);

  void Add(const Segment& segment, int observation_size, int action_size);

  /// Pushes everything to the operating system, so that a kill loses nothing that was added.
  void Flush();

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::unique_ptr<std::FILE, Close> file_;
};

}  // namespace cairn
