#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace cairn::deploy {

/// A directory of its own, removed at the end.
class TemporaryDirectory {
 public:
  TemporaryDirectory();
  ~TemporaryDirectory();
  TemporaryDirectory(const TemporaryDirectory&) = delete;
  TemporaryDirectory& operator=(const TemporaryDirectory&) = delete;

  std::string path() const { return path_.string(); }
  std::string operator/(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

std::string ReadText(const std::string& file);
void WriteText(const std::string& file, const std::string& text);

/// Makes the FIFO on which a helper in mode "hold" or "parent" says that it holds the lock of `file`.
void MakeReadyFifo(const std::string& file);

/// Blocks until it says so; returns its process id.
int WaitUntilHeld(const std::string& file);

/// Blocks until the process that holds the lock of `file` is dead.
void WaitUntilReleased(const std::string& file);

struct ProgramResult {
  int exit_code = -1;  ///< 128 + signal when killed by one
  std::string out;
  std::string err;
};

/// Runs a program to its end. `environment` holds "NAME=value" to set and "NAME" to unset.
ProgramResult RunProgram(const std::vector<std::string>& arguments, const std::vector<std::string>& environment = {});

/// Starts a program with its output in files `out` and `err`; returns its process id.
int StartProgram(const std::vector<std::string>& arguments, const std::string& out, const std::string& err,
                 const std::vector<std::string>& environment = {});

/// Waits for its end; exit code as in ProgramResult.
int WaitForProgram(int pid);

/// Runs `body` in a forked process, so that it may enter namespaces; returns what it returned, or 128 + signal. An
/// exception is printed and returned as 99.
int InChildProcess(const std::function<int()>& body);

/// What `body` returns in InChildProcess to say that the machine does not allow what the test needs.
constexpr int kNotAllowed = 77;

}  // namespace cairn::deploy
