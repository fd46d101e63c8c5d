#pragma once

#include <cstdint>
#include <string>

namespace cairn::learner {

/// How far a run has come, outside its checkpoints: survives a killed learner, so that the next one can say how much
/// was rolled back. Also the lock that keeps two learners out of one run directory.
class ProgressFile {
 public:
  /// Throws UsageError when another process holds the file, Error when it cannot be opened.
  explicit ProgressFile(const std::string& path);
  ~ProgressFile();
  ProgressFile(const ProgressFile&) = delete;
  ProgressFile& operator=(const ProgressFile&) = delete;

  /// Env steps that were noted last; 0: none.
  int64_t Read() const;

  /// Notes the env steps; a full disk is no reason to stop, so failures are ignored.
  void Write(int64_t env_steps);

 private:
  int fd_;
};

}  // namespace cairn::learner
