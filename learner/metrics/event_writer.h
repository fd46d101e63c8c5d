#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "learner/metrics/log_file.h"

namespace cairn::learner {

/// TensorBoard's event file (`tensorboard --logdir DIRECTORY`): one scalar a record, TFRecord framing with masked
/// CRC32C. One thread.
class EventWriter {
 public:
  /// Creates `directory`/events.out.tfevents.<time>.<host>.<process>. Throws Error naming the path.
  explicit EventWriter(const std::string& directory);

  /// Adds one point of the curve `tag`. `wall_time` in seconds since 1970; negative: now. Written at the latest with
  /// the next Flush. Throws Error naming the path and the system's reason (disk full, …).
  void Scalar(std::string_view tag, double value, int64_t step, double wall_time = -1.0);

  /// Hands everything to the system. Throws as Scalar.
  void Flush() { file_.Flush(); }

  const std::string& path() const { return file_.path(); }

 private:
  void AppendRecord(const std::string& payload);

  LogFile file_;
};

}  // namespace cairn::learner
