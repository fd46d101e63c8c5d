#pragma once

#include <array>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "common/bus/bus.h"
#include "common/bus/log_file.h"

namespace cairn {

struct RecordingConfig {
  BusConfig bus;                           ///< where; its run and key play no part: frames are recorded as they are
  std::vector<Plane> planes;               ///< at least one
  std::string file;                        ///< made anew
  int64_t queue_bytes = int64_t{1} << 30;  ///< that may wait for the disk
};

struct RecordingStats {
  std::array<int64_t, kNumPlanes> messages{};  ///< recorded, by plane
  int64_t bytes = 0;                           ///< of them
  int64_t dropped_by_kernel = 0;               ///< receive buffers were full
  int64_t dropped_by_queue = 0;                ///< the disk was too slow for too long
  std::string error;                           ///< why no more can be written; empty: nothing
  std::optional<Outage> outage;                ///< of the broker

  int64_t dropped() const { return dropped_by_kernel + dropped_by_queue; }
};

/// Records planes to LCM's log format, as lcm-logger does but without its silent losses: LCM's queue has no limit here,
/// a thread takes from it at once, another one writes, and what the kernel or the queue between them had to drop is
/// counted. Not the processes' frame checks: what comes is recorded.
class LogRecorder {
 public:
  /// Starts recording. Throws Error when the file cannot be made or a plane cannot be joined.
  explicit LogRecorder(RecordingConfig config);
  ~LogRecorder();
  LogRecorder(const LogRecorder&) = delete;
  LogRecorder& operator=(const LogRecorder&) = delete;

  RecordingStats stats() const;

  /// Stops, writes what has come, and closes the file. What stands in it when the disk is full are whole messages.
  RecordingStats Finish();

 private:
  struct Source;
  struct File;
  struct Item {
    Plane plane;
    LoggedMessage message;
  };
  void Receive(const std::stop_token& stop);
  void Write();
  void Push(Plane plane, LoggedMessage message);

  const RecordingConfig config_;
  const int wake_fd_;
  std::vector<std::unique_ptr<Source>> sources_;
  std::unique_ptr<File> file_;

  mutable std::mutex mutex_;  // guards everything down to the threads
  std::condition_variable filled_;
  std::deque<Item> queue_;
  int64_t queued_bytes_ = 0;
  bool ended_ = false;
  RecordingStats stats_;

  std::thread writer_;
  std::jthread receiver_;
};

}  // namespace cairn
