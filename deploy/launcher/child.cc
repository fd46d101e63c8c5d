#include "deploy/launcher/child.h"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <fstream>

#include "common/core/check.h"

namespace cairn::deploy {
namespace {

// What the child needs, made before fork: between fork and exec only async-signal-safe calls are allowed.
struct Prepared {
  const char* program;
  std::vector<char*> argv;
  int log_fd;
  int null_fd;
  int parent_fd;
  int error_fd;  // closed by a successful exec, else gets errno
  pid_t parent;
};

void Exec(const Prepared& p) {
  setpgid(0, 0);
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != p.parent) _exit(1);  // the launcher died before prctl
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  signal(SIGPIPE, SIG_DFL);
  dup2(p.null_fd, STDIN_FILENO);
  dup2(p.log_fd, STDOUT_FILENO);
  dup2(p.log_fd, STDERR_FILENO);
  // Libraries leave descriptors without close-on-exec; a peer that keeps a socket open would fill its buffer.
  close_range(3, ~0U, CLOSE_RANGE_CLOEXEC);
  if (p.parent_fd >= 0) fcntl(p.parent_fd, F_SETFD, 0);
  execv(p.program, p.argv.data());
}

[[noreturn]] void ExecOrReport(const Prepared& p) {
  Exec(p);
  const int error = errno;
  [[maybe_unused]] const ssize_t written = write(p.error_fd, &error, sizeof(error));
  _exit(127);
}

int OpenOrThrow(const std::string& path, int flags) {
  const int fd = open(path.c_str(), flags | O_CLOEXEC, 0644);
  if (fd < 0) ThrowError("cannot open {}: {}", path, std::strerror(errno));
  return fd;
}

// The errno that exec left in the pipe, 0 when it succeeded.
int ReadExecError(int fd) {
  int error = 0;
  ssize_t got = 0;
  while ((got = read(fd, &error, sizeof(error))) < 0 && errno == EINTR) {
  }
  return got == sizeof(error) ? error : 0;
}

pid_t Fork(const Command& command, Prepared* p) {
  int error_pipe[2];
  if (pipe2(error_pipe, O_CLOEXEC) != 0) ThrowError("cannot make a pipe: {}", std::strerror(errno));
  p->error_fd = error_pipe[1];
  p->parent = getpid();
  const pid_t pid = fork();
  if (pid == 0) ExecOrReport(*p);
  int error = pid < 0 ? errno : 0;
  close(error_pipe[1]);
  if (pid > 0) error = ReadExecError(error_pipe[0]);
  close(error_pipe[0]);
  if (pid > 0 && error != 0) waitpid(pid, nullptr, 0);
  if (error != 0) ThrowError("cannot start {} ({}): {}", command.name, command.program, std::strerror(error));
  setpgid(pid, pid);  // both sides, so that it holds whoever comes first
  return pid;
}

std::string SignalName(int signal) {
  const char* name = sigabbrev_np(signal);
  return name == nullptr ? fmt::format("signal {}", signal) : fmt::format("SIG{}", name);
}

bool TellsOfError(const std::string& line) {
  for (const char* mark : {"error:", "[error]", "broken invariant", "terminate called", "what():", "Sanitizer",
                           "Assertion", "ODE INTERNAL ERROR"}) {
    if (line.find(mark) != std::string::npos) return true;
  }
  return false;
}

}  // namespace

Child::Child(Command command, int parent_fd) : command_(std::move(command)) {
  Prepared prepared{command_.program.c_str(), {}, -1, -1, parent_fd, -1, -1};
  std::vector<std::string> words{command_.program};
  words.insert(words.end(), command_.arguments.begin(), command_.arguments.end());
  for (std::string& word : words) prepared.argv.push_back(word.data());
  prepared.argv.push_back(nullptr);
  prepared.log_fd = OpenOrThrow(command_.log_file, O_WRONLY | O_CREAT | O_APPEND);
  prepared.null_fd = open("/dev/null", O_RDONLY | O_CLOEXEC);
  try {
    pid_ = Fork(command_, &prepared);
  } catch (const Error&) {
    close(prepared.log_fd);
    close(prepared.null_fd);
    throw;
  }
  close(prepared.log_fd);
  close(prepared.null_fd);
}

std::optional<int> Child::Poll() {
  int status = 0;
  if (!status_ && waitpid(pid_, &status, WNOHANG) == pid_) status_ = status;
  return status_;
}

void Child::Signal(int signal) {
  if (running()) kill(-pid_, signal);
}

std::string DescribeStatus(int wait_status) {
  if (WIFEXITED(wait_status)) return fmt::format("exit code {}", WEXITSTATUS(wait_status));
  if (!WIFSIGNALED(wait_status)) return fmt::format("wait status {}", wait_status);
  const int signal = WTERMSIG(wait_status);
  const bool crash = signal == SIGSEGV || signal == SIGABRT || signal == SIGBUS || signal == SIGILL || signal == SIGFPE;
  return fmt::format("{} {}", crash ? "crashed with" : "killed by", SignalName(signal));
}

std::string LastErrorLine(const std::string& log_file) {
  constexpr std::streamoff kTail = 65536;
  std::ifstream file(log_file, std::ios::binary | std::ios::ate);
  if (!file) return "";
  file.seekg(std::max<std::streamoff>(0, static_cast<std::streamoff>(file.tellg()) - kTail));
  std::string last, error;
  for (std::string line; std::getline(file, line);) {
    if (!line.empty()) last = line;
    if (TellsOfError(line)) error = line;
  }
  if (last.find(" info: ") != std::string::npos) last.clear();  // no cause of anything
  return error.empty() ? last : error;
}

}  // namespace cairn::deploy
