#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <vector>

namespace cairn::deploy {

/// A program to start.
struct Command {
  std::string name;     ///< for people: "learner", "actor 3"
  std::string program;  ///< path
  std::vector<std::string> arguments;
  std::string log_file;  ///< stdout and stderr are appended to it
};

/// One running process. It leads a process group of its own (Ctrl-C on the terminal reaches the launcher alone), reads
/// nothing from stdin, and is killed by the kernel when the thread that started it ends.
class Child {
 public:
  /// Starts it; of this process's descriptors it inherits `parent_fd` alone (-1: none). Throws Error when log file or
  /// program cannot be opened.
  Child(Command command, int parent_fd);

  /// Its wait status once it has ended.
  std::optional<int> Poll();

  /// Sends a signal to its whole group; nothing once it has ended.
  void Signal(int signal);

  bool running() const { return !status_.has_value(); }
  pid_t pid() const { return pid_; }
  const Command& command() const { return command_; }

 private:
  Command command_;
  pid_t pid_ = -1;
  std::optional<int> status_;
};

/// A wait status in words: "exit code 3", "killed by SIGKILL", "crashed with SIGSEGV".
std::string DescribeStatus(int wait_status);

/// The last line of a log that tells of an error, else its last line unless that is an info of ours; empty for an empty
/// or missing log.
std::string LastErrorLine(const std::string& log_file);

}  // namespace cairn::deploy
