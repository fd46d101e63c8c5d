#pragma once

#include <sys/types.h>

#include <filesystem>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace cairn::testing {

/// A temporary directory that goes with its owner.
class TemporaryDirectory {
 public:
  TemporaryDirectory();
  ~TemporaryDirectory();
  TemporaryDirectory(const TemporaryDirectory&) = delete;
  TemporaryDirectory& operator=(const TemporaryDirectory&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// A program of the build under test, running in the background.
class Program {
 public:
  /// `arguments` without the program's name; `environment` is added to the caller's. Output goes to `log`.
  Program(const std::string& name, const std::vector<std::string>& arguments, const std::filesystem::path& log,
          const std::map<std::string, std::string>& environment = {});
  ~Program();
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  /// Waits for the end; the exit status, or 128 + signal.
  int Wait();
  pid_t pid() const { return pid_; }

 private:
  pid_t pid_ = -1;
  int status_ = -1;
};

/// Waits until `reached` or the program's end, a minute at most; false when it did not come to that. No sleep: a
/// bounded wait on the program.
bool WaitUntil(const Program& program, const std::function<bool()>& reached);

/// Runs `cairn …` to its end; returns its exit status. Its output is in `log`.
int RunCairn(const std::vector<std::string>& arguments, const std::filesystem::path& log,
             const std::map<std::string, std::string>& environment = {});

std::string ReadFile(const std::filesystem::path& path);
nlohmann::json ReadJson(const std::filesystem::path& path);

/// Process ids of the running descendants of `pid` whose command line contains `text`.
std::vector<pid_t> Descendants(pid_t pid, const std::string& text);

/// "vehicle episode step hash" of every transition that the processes' audit files with this prefix hold.
std::vector<std::string> AuditLines(const std::filesystem::path& directory, const std::string& prefix);

}  // namespace cairn::testing
