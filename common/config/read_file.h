#pragma once

#include <string>

namespace cairn::config {

/// The file's bytes. Throws UsageError "<what> <path>: <reason>" when it cannot be read.
std::string ReadFileToText(const char* what, const std::string& path);

}  // namespace cairn::config
