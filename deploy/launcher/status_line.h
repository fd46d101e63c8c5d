#pragma once

#include <cstdint>
#include <cstdio>
#include <string>

#include "common/core/clock.h"

namespace cairn::deploy {

/// What is shown of a run while it goes on.
struct RunStatus {
  int64_t env_steps = 0;
  int64_t total_env_steps = 0;
  double env_steps_per_s = 0;
  double updates_per_s = 0;
  double success_rate = -1;            ///< of the last evaluation, −1 before the first
  int64_t consumption_env_steps = -1;  ///< −1: not yet solved
  std::string phase;                   ///< "starting", "training", "testing", …
  std::string warning;                 ///< what does not work at the moment; empty: nothing
};

/// One line: "training  123,456 / 250,000  49 %  12,300 steps/s  1,230 updates/s  success 98.5 %  consumption 40,000
/// ETA 0:10".
std::string FormatStatus(const RunStatus& status);

/// Shows the status: one line that is rewritten in place on a terminal, whole lines every few seconds elsewhere.
class StatusLine {
 public:
  enum class Mode { kTerminal, kPlain, kQuiet };

  /// kTerminal when `out` is one, else kPlain.
  static Mode ModeFor(FILE* out, bool quiet);

  StatusLine(FILE* out, Mode mode, Duration plain_period = std::chrono::seconds(5));
  ~StatusLine();
  StatusLine(const StatusLine&) = delete;
  StatusLine& operator=(const StatusLine&) = delete;

  void Update(const RunStatus& status);

  /// A lasting line of its own.
  void Note(const std::string& line);

  /// Shows the last status whole, for good.
  void Finish();

 private:
  void Print(const std::string& text);
  void Rewrite(const std::string& line);
  void Clear();

  FILE* out_;
  Mode mode_;
  Duration plain_period_;
  TimePoint next_plain_;
  std::string last_;      // newest line
  bool shown_ = false;    // the terminal's last row is ours
  bool pending_ = false;  // kPlain: `last_` has not been written
};

}  // namespace cairn::deploy
