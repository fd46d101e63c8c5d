#pragma once

#include <string>
#include <vector>

namespace cairn::deploy {

/// What was typed after `cairn spy`.
struct SpyOptions {
  std::string run_dir;              ///< empty: the default group and ports on this host
  std::string plane = "telemetry";  ///< telemetry, experience, control or tables
};

/// Becomes lcm-spy (Java) on one plane of a run, inside the run's private network if it has one. Returns only by
/// throwing: UsageError for what was typed, Error when java, a jar or the display is missing.
int Spy(const SpyOptions& options);

}  // namespace cairn::deploy
