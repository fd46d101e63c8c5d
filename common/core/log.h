#pragma once

#include <fmt/core.h>

#include <string>
#include <string_view>

namespace cairn::log {

enum class Level { kDebug, kInfo, kWarning, kError };

/// Sets the process's name in each line and, when `file` is not empty, writes lines there (appended, flushed per line)
/// as well as warnings and errors to stderr. Without a call everything from `kInfo` on goes to stderr.
/// Throws Error when the file cannot be opened.
void Init(std::string_view process, const std::string& file = "", Level level = Level::kInfo);

void Write(Level level, std::string_view line);

template <typename... Args>
void Debug(fmt::format_string<Args...> format, Args&&... args) {
  Write(Level::kDebug, fmt::format(format, std::forward<Args>(args)...));
}
template <typename... Args>
void Info(fmt::format_string<Args...> format, Args&&... args) {
  Write(Level::kInfo, fmt::format(format, std::forward<Args>(args)...));
}
template <typename... Args>
void Warning(fmt::format_string<Args...> format, Args&&... args) {
  Write(Level::kWarning, fmt::format(format, std::forward<Args>(args)...));
}
template <typename... Args>
void Error(fmt::format_string<Args...> format, Args&&... args) {
  Write(Level::kError, fmt::format(format, std::forward<Args>(args)...));
}

}  // namespace cairn::log
