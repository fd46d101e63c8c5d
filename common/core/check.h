#pragma once

#include <fmt/core.h>

#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <string>

namespace cairn {

/// Something from outside is wrong (file, URL, shape, machine). The text is one line that names the thing, its value
/// and the rule it breaks. `main` catches it once, prints it and exits 1.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// What the user typed is wrong (argument, experiment file, `--set`). Like Error, but `main` exits 2.
class UsageError : public Error {
 public:
  using Error::Error;
};

/// Throws Error with a formatted line.
template <typename... Args>
[[noreturn]] void ThrowError(fmt::format_string<Args...> format, Args&&... args) {
  throw Error(fmt::format(format, std::forward<Args>(args)...));
}

/// Throws UsageError with a formatted line.
template <typename... Args>
[[noreturn]] void ThrowUsageError(fmt::format_string<Args...> format, Args&&... args) {
  throw UsageError(fmt::format(format, std::forward<Args>(args)...));
}

namespace internal {
[[noreturn]] inline void CheckFailed(const char* file, int line, const char* condition, const std::string& note) {
  std::fprintf(stderr, "%s:%d: broken invariant: %s %s\n", file, line, condition, note.c_str());
  std::abort();
}
}  // namespace internal
}  // namespace cairn

/// Our own invariant: always on, aborts with file, line and condition; further arguments are a fmt format and its
/// values.
#define CAIRN_CHECK(condition, ...)                                                                  \
  do {                                                                                               \
    if (!(condition)) [[unlikely]]                                                                   \
      ::cairn::internal::CheckFailed(__FILE__, __LINE__, #condition, ::fmt::format("" __VA_ARGS__)); \
  } while (false)

/// CAIRN_CHECK for inner loops: compiled away in release builds.
#ifdef NDEBUG
#define CAIRN_DCHECK(condition, ...) \
  do {                               \
  } while (false)
#else
#define CAIRN_DCHECK CAIRN_CHECK
#endif
