#pragma once

#include <string>

namespace cairn::deploy {

/// What was typed after `cairn log`.
struct RecordOptions {
  std::string run_dir;  ///< of a living run; empty: `lcm_url`
  std::string lcm_url;  ///< empty: the run's, or the transport's defaults
  std::string planes = "experience,control,tables,telemetry";
  std::string out;        ///< file to make
  double duration_s = 0;  ///< 0: until the run ends or a signal
};

/// Records planes to an LCM log until the run of `run_dir` ends, the time is over, or SIGINT, SIGTERM or SIGHUP.
/// Returns 0 when all is in the file, 1 when something was dropped, which it says. Throws UsageError for what was
/// typed, Error when the file cannot be written.
int Record(const RecordOptions& options);

}  // namespace cairn::deploy
