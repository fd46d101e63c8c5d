#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "common/core/bytes.h"

namespace cairn {

/// One message of an LCM log: whole frame as it travelled, trailer included.
struct LoggedMessage {
  int64_t utime = 0;  ///< when it came, wall clock, microseconds since 1970
  std::string channel;
  Bytes bytes;
};

/// Reads LCM's log format (lcm-logger, `cairn log`). LCM's own reader takes the end of a file for its first fault and
/// crashes at a crafted length; this one goes on behind a fault and counts it. The file must not shrink meanwhile.
class LogReader {
 public:
  /// Throws UsageError naming the file when it cannot be read.
  explicit LogReader(const std::string& file);
  ~LogReader();
  LogReader(const LogReader&) = delete;
  LogReader& operator=(const LogReader&) = delete;

  /// The next whole message; nullopt at the end.
  std::optional<LoggedMessage> Next();

  /// Places where bytes were not a whole message: garbage, or a torn end.
  int64_t faults() const { return faults_; }

 private:
  bool AtMessage(size_t at) const;

  const uint8_t* data_ = nullptr;
  size_t size_ = 0;
  size_t at_ = 0;
  int64_t faults_ = 0;
};

}  // namespace cairn
