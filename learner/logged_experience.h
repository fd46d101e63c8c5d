#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>

#include "common/bus/frame.h"
#include "common/bus/log_file.h"
#include "common/bus/messages.h"
#include "common/bus/reliable_stream.h"
#include "learner/harvest.h"

namespace cairn::learner {

/// What was found in a log.
struct LogCounters {
  int64_t messages = 0;                ///< of the experience streams, taken
  int64_t transitions = 0;             ///< handed out
  int64_t transitions_duplicate = 0;   ///< seen before, or before what was seen
  int64_t transitions_not_finite = 0;  ///< left out
  int64_t messages_missing = 0;        ///< of streams, between what the log holds
  int64_t frames_refused = 0;          ///< of another run, forged, torn, undecodable, or of another shape
  int64_t faults = 0;                  ///< places in the file that are no message

  /// For the log and people: what is not as it should be; empty: nothing.
  std::string Trouble() const;
};

/// Experience that was recorded (`cairn log`, lcm-logger), as an actor's stream would bring it: frames and messages
/// pass the checks of the bus, each stream is put in order, what was sent again counts once, and each vehicle's
/// trajectory only goes forward. Holes are counted, not refused: a segment is whole in itself. Of one run, the first in
/// the log.
class LoggedExperience {
 public:
  /// What the learner's experiment asks for; a log with other sizes is refused.
  struct Shape {
    int observation_size = 0;
    int action_size = 0;
    uint64_t experiment_hash = 0;
  };

  /// Throws UsageError naming the file when it cannot be read or holds no experience, when it is sealed with another
  /// key than `key` or with one while there is none, and when its sizes are others, with both.
  LoggedExperience(const std::string& file, const std::optional<RunKey>& key, const Shape& shape);

  /// Segments and finished training episodes of the next message; nullopt at the end.
  std::optional<Harvest> Next();

  const LogCounters& counters() const { return counters_; }

 private:
  struct Trajectory {
    int32_t episode = -1;
    int32_t next_step = 0;
  };
  void CheckBeginning(const std::string& file, const std::optional<RunKey>& key, const Shape& shape);
  std::optional<Experience> NextExperience();
  std::optional<Experience> ReadExperience();
  void Accept(Experience experience);
  Harvest Judge(Experience experience);

  LogReader reader_;
  Shape shape_;
  std::optional<FrameSeal> seal_;
  PeerContexts peers_;
  std::map<int64_t, ReliableReceiver<Experience>> streams_;  // by session
  std::deque<Experience> ready_;                             // in order
  std::map<int32_t, Trajectory> vehicles_;
  bool ended_ = false;
  LogCounters counters_;
};

}  // namespace cairn::learner
