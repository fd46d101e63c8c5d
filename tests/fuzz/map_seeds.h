#pragma once

#include <string>
#include <utility>
#include <vector>

namespace cairn {

/// A sound file of each map format, with the fuzzer that reads it.
std::vector<std::pair<std::string, std::string>> MapSeeds();

}  // namespace cairn
