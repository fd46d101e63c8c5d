#pragma once

#include <chrono>
#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/core/clock.h"
#include "deploy/launcher/child.h"

namespace cairn::deploy {

/// What the end of a process means. Whoever refuses its input (exit code 2) would do so again: that is the run's
/// failure.
enum class Role {
  kService,  ///< needed as long as the run lasts, and replaced whenever it ends (planner)
  kMain,     ///< its clean exit is the run's success, an error its failure; replaced when a signal killed it (learner)
  kWorker,   ///< replaced when it dies; done when it exits cleanly (actors)
};

/// A process under supervision.
struct Supervised {
  std::string name;
  Role role = Role::kWorker;
  /// The command of generation 0, 1, …: called again for each replacement.
  std::function<Command(int generation)> command;
};

struct SupervisorConfig {
  Duration kill_after = std::chrono::milliseconds(1500);       ///< from SIGTERM to SIGKILL when stopping
  Duration main_kill_after = std::chrono::milliseconds(1500);  ///< the same for the main process, which comes first
  int max_restarts = 10;                                       ///< of all processes together within `restart_window`
  Duration restart_window = std::chrono::minutes(1);
  std::function<void()> tick;  ///< called about every `tick_period` while running; may be empty
  Duration tick_period = std::chrono::milliseconds(200);
  std::function<void(const std::string&)> note;  ///< gets a line about each restart; may be empty
};

/// How a run ended.
struct RunEnd {
  int exit_code = 0;    ///< 0 success, 2 when a process refused its input as wrong, 128 + signal when stopped, else 1
  std::string failure;  ///< one line that names the process, its end, its last error line and its log
  int restarts = 0;
};

/// Blocks SIGINT, SIGTERM, SIGHUP and SIGCHLD and hands them out as events. Make it while single-threaded, so that all
/// threads inherit the mask. The old mask comes back with destruction.
class SignalEvents {
 public:
  SignalEvents();
  ~SignalEvents();
  SignalEvents(const SignalEvents&) = delete;
  SignalEvents& operator=(const SignalEvents&) = delete;

  /// Waits up to `timeout` for signals; returns a stop signal if one came, else 0.
  int Wait(Duration timeout);

 private:
  int fd_;
};

/// Starts processes, replaces workers that die, and ends all of them with the run, whatever its end. Children end even
/// when this process is killed: by the kernel's parent-death signal and by end of file on an inherited pipe.
/// Use from the main thread only (the parent-death signal belongs to the thread that starts a child).
class Supervisor {
 public:
  Supervisor(SignalEvents* signals, SupervisorConfig config);
  ~Supervisor();
  Supervisor(const Supervisor&) = delete;
  Supervisor& operator=(const Supervisor&) = delete;

  /// For `--parent-fd`.
  int parent_fd() const { return pipe_[0]; }

  void Add(Supervised process);

  /// Starts everything, in the order added, and returns when the run has ended and no process is left. Throws Error
  /// when one cannot be started (the others are stopped).
  RunEnd Run();

 private:
  struct Slot {
    Supervised process;
    int generation = 0;
    std::unique_ptr<Child> child;  // null: not started
    bool finished = false;         // a worker that exited cleanly
  };

  void Start(Slot* slot);
  void Reap();
  void HandleExit(Slot* slot, int status);
  void Replace(Slot* slot, int status);
  bool TooManyRestarts();
  void Fail(const Slot& slot, int status, const std::string& what);
  void Tick();
  void StopAll();
  bool AnyRunning(bool main_only);
  bool WaitForEnd(Duration timeout, bool main_only);

  SignalEvents* signals_;
  SupervisorConfig config_;
  int pipe_[2] = {-1, -1};
  std::deque<Slot> slots_;
  std::deque<TimePoint> restarts_;
  TimePoint next_tick_;
  bool ended_ = false;
  RunEnd end_;
};

}  // namespace cairn::deploy
