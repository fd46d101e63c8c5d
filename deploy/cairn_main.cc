#include <unistd.h>

#include <cctype>
#include <cstdio>
#include <exception>
#include <string>

#include "common/core/check.h"
#include "common/core/clock.h"
#include "common/core/version.h"
#include "deploy/launcher/commands.h"

namespace {

int Fail(const std::exception& error, int status) {
  std::string line = error.what();
  for (char& c : line) {
    if (std::iscntrl(static_cast<unsigned char>(c)) != 0) c = '?';  // an error is one line
  }
  std::fprintf(stderr, "cairn: error: %s\n", line.c_str());
  return status;
}

}  // namespace

// The `cairn` command. Exit codes: 0 success, 2 what was typed is wrong, 1 anything else, 128 + n stopped by signal n.
int main(int argc, char** argv) {
  const int64_t launch_utime_us = cairn::MonotonicUs();
  try {
    const int status = cairn::deploy::RunCommandLine(argc, argv, launch_utime_us);
    // What could not be written (a full disk, a reader that went away) was not done.
    if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) cairn::ThrowError("cannot write to standard output");
    return status;
  } catch (const cairn::UsageError& error) {
    return Fail(error, 2);
  } catch (const std::exception& error) {
    return Fail(error, 1);
  }
}
