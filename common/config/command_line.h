#pragma once

#include <CLI/CLI.hpp>

namespace cairn {

/// Parses the command line into the variables bound to `app`. False when the help or version that was asked for has
/// been printed and the program should end with 0. Throws UsageError, one line, for anything that is wrong; an unknown
/// option or command comes with the nearest known one.
bool ParseCommandLine(CLI::App* app, int argc, const char* const* argv);

}  // namespace cairn
