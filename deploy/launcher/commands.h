#pragma once

#include <cstdint>

namespace cairn::deploy {

/// Parses `cairn …` and runs the command; returns the exit code. `launch_utime_us` is MonotonicUs() at the start of
/// main. Throws UsageError or Error.
int RunCommandLine(int argc, char** argv, int64_t launch_utime_us);

}  // namespace cairn::deploy
