#pragma once

#include <string>
#include <string_view>

#include "common/core/clock.h"

namespace cairn::learner {

/// A file that grows by whole records and never loses its tail silently: records are collected for at most a second,
/// and every failed write throws Error naming the path and the system's reason. After a failed write the next one
/// first cuts the file back to its last whole record, so that a disk that was full for a while leaves no torn one.
/// One thread.
class LogFile {
 public:
  /// Creates the file, or goes on at the end of it with `append`. Throws Error.
  explicit LogFile(const std::string& path, bool append = false);
  /// Flushes; a failure there is only logged.
  ~LogFile();
  LogFile(const LogFile&) = delete;
  LogFile& operator=(const LogFile&) = delete;

  void Append(std::string_view record);
  void Flush();

  const std::string& path() const { return path_; }
  /// Bytes in the file, without what is still collected.
  int64_t size() const { return size_; }

 private:
  [[noreturn]] void Fail(const char* what) const;

  std::string path_;
  int fd_;
  std::string pending_;
  int64_t size_ = 0;  // bytes of whole records
  bool torn_ = false;
  TimePoint last_flush_;
};

}  // namespace cairn::learner
