#include <unistd.h>

#include <cstdio>

#include "common/config/command_line.h"
#include "common/core/check.h"
#include "common/core/clock.h"
#include "common/core/version.h"
#include "deploy/launcher/commands.h"

// The `cairn` command. Exit codes: 0 success, 2 what was typed is wrong, 1 anything else, 128 + n stopped by signal n.
int main(int argc, char** argv) {
  const int64_t launch_utime_us = cairn::MonotonicUs();
  try {
    return cairn::deploy::RunCommandLine(argc, argv, launch_utime_us);
  } catch (const cairn::UsageError& error) {
    std::fprintf(stderr, "cairn: error: %s\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "cairn: error: %s\n", error.what());
    return 1;
  }
}
