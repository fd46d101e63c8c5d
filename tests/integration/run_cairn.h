#pragma once

#include <sys/types.h>

#include <filesystem>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/core/clock.h"

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

/// A program of the build under test (or any, by its absolute path), running in the background.
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
  /// The same, at most so long; nullopt while it runs.
  std::optional<int> WaitFor(Duration time);
  pid_t pid() const { return pid_; }

 private:
  pid_t pid_ = -1;
  int status_ = -1;
};

/// Runs `cairn …` to its end; returns its exit status. Its output is in `log`.
int RunCairn(const std::vector<std::string>& arguments, const std::filesystem::path& log,
             const std::map<std::string, std::string>& environment = {});

/// Arguments of a fast small run of `cairn`: the plane car, few starts.
std::vector<std::string> SmallRun(const std::filesystem::path& run_dir, int64_t steps,
                                  const std::vector<std::string>& more = {});

/// Waits until `reached`, at most `limit`; false when it is not, or when the program ends before.
bool WaitUntil(const Program& program, const std::function<bool()>& reached, Duration limit = std::chrono::seconds(60));

std::string ReadFile(const std::filesystem::path& path);
nlohmann::json ReadJson(const std::filesystem::path& path);

/// Process ids of the running descendants of `pid` whose command line contains `text`.
std::vector<pid_t> Descendants(pid_t pid, const std::string& text);

/// "vehicle episode step hash" of every transition that the processes' audit files with this prefix hold.
std::vector<std::string> AuditLines(const std::filesystem::path& directory, const std::string& prefix);

/// Nothing lost, nothing twice, nothing changed on the way: what replay holds is a part of what the actors made, and,
/// when none of them died, all of it.
void ExpectReplayMatchesActors(const std::filesystem::path& audit, size_t env_steps, bool actor_died);

}  // namespace cairn::testing
