#include "tests/integration/run_cairn.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <set>
#include <sstream>

#include "common/core/check.h"
#include "common/core/clock.h"

namespace cairn::testing {

TemporaryDirectory::TemporaryDirectory() {
  std::string name = (std::filesystem::temp_directory_path() / "cairn-test-XXXXXX").string();
  CAIRN_CHECK(mkdtemp(name.data()) != nullptr);
  path_ = name;
}

TemporaryDirectory::~TemporaryDirectory() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

Program::Program(const std::string& name, const std::vector<std::string>& arguments, const std::filesystem::path& log,
                 const std::map<std::string, std::string>& environment) {
  const std::string path = std::string(CAIRN_BIN_DIR) + "/" + name;
  std::vector<std::string> words{path};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  pid_ = fork();
  CAIRN_CHECK(pid_ >= 0);
  if (pid_ > 0) return;
  const int fd = open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0644);
  dup2(fd, STDOUT_FILENO);
  dup2(fd, STDERR_FILENO);
  for (const auto& [key, value] : environment) setenv(key.c_str(), value.c_str(), 1);
  execv(path.c_str(), argv.data());
  _exit(127);
}

Program::~Program() {
  if (pid_ > 0 && status_ < 0) {
    kill(pid_, SIGKILL);
    Wait();
  }
}

int Program::Wait() {
  if (status_ >= 0) return status_;
  int status = 0;
  waitpid(pid_, &status, 0);
  status_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return status_;
}

bool WaitUntil(const Program& program, const std::function<bool()>& reached) {
  const int pidfd = static_cast<int>(syscall(SYS_pidfd_open, program.pid(), 0));
  bool done = false;
  const TimePoint deadline = Clock::now() + std::chrono::seconds(60);
  while (!done && Clock::now() < deadline) {
    pollfd ended{pidfd, POLLIN, 0};
    if (poll(&ended, 1, 10) > 0) break;
    done = reached();
  }
  close(pidfd);
  return done;
}

int RunCairn(const std::vector<std::string>& arguments, const std::filesystem::path& log,
             const std::map<std::string, std::string>& environment) {
  return Program("cairn", arguments, log, environment).Wait();
}

std::string ReadFile(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

nlohmann::json ReadJson(const std::filesystem::path& path) { return nlohmann::json::parse(ReadFile(path)); }

std::vector<pid_t> Descendants(pid_t pid, const std::string& text) {
  std::map<pid_t, pid_t> parents;
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    const std::string name = entry.path().filename().string();
    if (name.find_first_not_of("0123456789") != std::string::npos) continue;
    const std::string stat = ReadFile(entry.path() / "stat");
    const size_t end = stat.rfind(')');
    if (end == std::string::npos) continue;
    char state = 0;
    pid_t parent = 0;
    std::istringstream(stat.substr(end + 1)) >> state >> parent;
    if (state != 'Z') parents[std::stoi(name)] = parent;
  }
  std::vector<pid_t> found;
  for (const auto& [child, parent] : parents) {
    pid_t ancestor = parent;
    while (ancestor > 1 && ancestor != pid && parents.contains(ancestor)) ancestor = parents[ancestor];
    const std::string command = ReadFile("/proc/" + std::to_string(child) + "/cmdline");
    if (ancestor == pid && command.find(text) != std::string::npos) found.push_back(child);
  }
  return found;
}

std::vector<std::string> AuditLines(const std::filesystem::path& directory, const std::string& prefix) {
  std::vector<std::string> lines;
  for (const auto& entry : std::filesystem::directory_iterator(directory)) {
    if (entry.path().filename().string().rfind(prefix, 0) != 0) continue;
    std::ifstream file(entry.path());
    for (std::string line; std::getline(file, line);) lines.push_back(line);
  }
  return lines;
}

}  // namespace cairn::testing
