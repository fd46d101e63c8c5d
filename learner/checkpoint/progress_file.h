#pragma once

#include <cstdint>
#include <string>

namespace cairn::learner {

/// How far a run has come and how many learners it has had, outside its checkpoints: survives a killed learner, so that
/// the next one can say how much was rolled back and is known as the newer one. Also the lock that keeps two learners
/// out of one run directory.
class ProgressFile {
 public:
  /// Counts the caller as one learner more. Throws UsageError when another process holds the file, Error when it cannot
  /// be opened or the count cannot be written.
  explicit ProgressFile(const std::string& path);
  ~ProgressFile();
  ProgressFile(const ProgressFile&) = delete;
  ProgressFile& operator=(const ProgressFile&) = delete;

  /// Env steps that were noted last before this learner; 0: none.
  int64_t env_steps_before() const { return env_steps_before_; }
  /// Transitions rolled back by the learners before this one, those between its checkpoint and env_steps_before left
  /// out.
  int64_t rolled_back_before() const { return rolled_back_before_; }
  /// Number of this learner among those of the run, from 1.
  int64_t incarnation() const { return incarnation_; }

  /// Notes where the run stands; a full disk is no reason to stop, so failures are ignored.
  void Write(int64_t env_steps, int64_t rolled_back);

 private:
  bool TryWrite(int64_t env_steps, int64_t rolled_back);

  int fd_;
  int64_t env_steps_before_ = 0;
  int64_t rolled_back_before_ = 0;
  int64_t incarnation_ = 1;
};

}  // namespace cairn::learner
