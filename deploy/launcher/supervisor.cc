#include "deploy/launcher/supervisor.h"

#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <sys/signalfd.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>

#include "common/core/check.h"

namespace cairn::deploy {
namespace {

constexpr int kUsageExitCode = 2;
constexpr auto kLastWait = std::chrono::milliseconds(100);  // for the others, when the main process hangs

// But for a signal that was ignored when this process began, as nohup ignores SIGHUP: once blocked it would come all
// the same.
sigset_t SupervisedSignals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGCHLD);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction action {};
    if (sigaction(signal, nullptr, &action) == 0 && action.sa_handler == SIG_IGN) continue;
    sigaddset(&signals, signal);
  }
  return signals;
}

// A log's line without what precedes the error itself: date, process, level.
std::string WithoutPrefix(const std::string& line) {
  const size_t at = line.find("error: ");
  return at == std::string::npos ? line : line.substr(at + 7);
}

int Milliseconds(Duration duration) {
  const auto ms = std::chrono::ceil<std::chrono::milliseconds>(duration).count();
  return static_cast<int>(std::clamp<int64_t>(ms, 0, 60000));
}

}  // namespace

SignalEvents::SignalEvents() {
  const sigset_t signals = SupervisedSignals();
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  fd_ = signalfd(-1, &signals, SFD_CLOEXEC | SFD_NONBLOCK);
  if (fd_ < 0) ThrowError("signalfd: {}", std::strerror(errno));
}

SignalEvents::~SignalEvents() {
  close(fd_);
  const sigset_t signals = SupervisedSignals();
  pthread_sigmask(SIG_UNBLOCK, &signals, nullptr);
}

int SignalEvents::Wait(Duration timeout) {
  pollfd event{fd_, POLLIN, 0};
  poll(&event, 1, Milliseconds(timeout));
  int stop = 0;
  signalfd_siginfo info;
  while (read(fd_, &info, sizeof(info)) == sizeof(info)) {
    if (info.ssi_signo != SIGCHLD) stop = static_cast<int>(info.ssi_signo);
  }
  return stop;
}

Supervisor::Supervisor(SignalEvents* signals, SupervisorConfig config) : signals_(signals), config_(std::move(config)) {
  if (pipe2(pipe_, O_CLOEXEC) != 0) ThrowError("cannot make a pipe: {}", std::strerror(errno));
}

Supervisor::~Supervisor() {
  StopAll();
  close(pipe_[0]);
  close(pipe_[1]);
}

void Supervisor::Add(Supervised process) {
  slots_.emplace_back();
  slots_.back().process = std::move(process);
}

RunEnd Supervisor::Run() {
  for (Slot& slot : slots_) Start(&slot);
  next_tick_ = Clock::now();
  while (!ended_) {
    Tick();
    const int stop = signals_->Wait(next_tick_ - Clock::now());
    if (stop != 0) {
      ended_ = true;
      end_.exit_code = 128 + stop;
    }
    Reap();
  }
  StopAll();
  return end_;
}

void Supervisor::Start(Slot* slot) {
  slot->child = std::make_unique<Child>(slot->process.command(slot->generation), pipe_[0]);
}

void Supervisor::Reap() {
  for (Slot& slot : slots_) {
    if (ended_ || slot.child == nullptr || slot.finished) continue;
    if (const auto status = slot.child->Poll()) HandleExit(&slot, *status);
  }
}

void Supervisor::HandleExit(Slot* slot, int status) {
  const bool clean = WIFEXITED(status) && WEXITSTATUS(status) == 0;
  const bool refused = WIFEXITED(status) && WEXITSTATUS(status) == kUsageExitCode;
  if (refused) return Fail(*slot, status, "refused its input");  // a new process would do the same
  switch (slot->process.role) {
    case Role::kMain:
      if (WIFSIGNALED(status)) return Replace(slot, status);
      ended_ = true;
      if (!clean) Fail(*slot, status, "failed");
      return;
    case Role::kService:
      return Replace(slot, status);
    case Role::kWorker:
      if (!clean) return Replace(slot, status);
      slot->finished = true;
      return;
  }
}

void Supervisor::Replace(Slot* slot, int status) {
  if (TooManyRestarts()) {
    const std::string what = config_.max_restarts == 0
                                 ? "failed"
                                 : fmt::format("failed after {} restarts within a minute", config_.max_restarts);
    return Fail(*slot, status, what);
  }
  restarts_.push_back(Clock::now());
  ++end_.restarts;
  ++slot->generation;
  if (config_.note) {
    config_.note(fmt::format("{} ended ({}); starting it again, generation {}", slot->process.name,
                             DescribeStatus(status), slot->generation));
  }
  Start(slot);
}

bool Supervisor::TooManyRestarts() {
  while (!restarts_.empty() && Clock::now() - restarts_.front() > config_.restart_window) restarts_.pop_front();
  return static_cast<int>(restarts_.size()) >= config_.max_restarts;
}

void Supervisor::Fail(const Slot& slot, int status, const std::string& what) {
  ended_ = true;
  const std::string& log_file = slot.child->command().log_file;
  const std::string line = WithoutPrefix(LastErrorLine(log_file));
  end_.exit_code = WIFEXITED(status) && WEXITSTATUS(status) == kUsageExitCode ? kUsageExitCode : 1;
  end_.failure = fmt::format("{} {} ({}){}{}; see {}", slot.process.name, what, DescribeStatus(status),
                             line.empty() ? "" : ": ", line, log_file);
}

void Supervisor::Tick() {
  const TimePoint now = Clock::now();
  if (now < next_tick_) return;
  next_tick_ = now + config_.tick_period;
  if (config_.tick) config_.tick();
}

// The main process first: with the others still there it can bring what it is about to an end.
void Supervisor::StopAll() {
  const auto signal = [this](bool main) {
    for (Slot& slot : slots_) {
      if (slot.child != nullptr && (slot.process.role == Role::kMain) == main) slot.child->Signal(SIGTERM);
    }
  };
  signal(true);
  if (AnyRunning(true)) WaitForEnd(config_.main_kill_after, true);
  signal(false);
  if (WaitForEnd(AnyRunning(true) ? kLastWait : config_.kill_after, false)) return;
  for (Slot& slot : slots_) {
    if (slot.child != nullptr) slot.child->Signal(SIGKILL);
  }
  WaitForEnd(std::chrono::seconds(10), false);  // a process in uninterruptible sleep cannot be waited for any longer
}

bool Supervisor::AnyRunning(bool main_only) {
  return std::any_of(slots_.begin(), slots_.end(), [main_only](Slot& slot) {
    return (!main_only || slot.process.role == Role::kMain) && slot.child != nullptr && !slot.child->Poll().has_value();
  });
}

// A second stop signal while waiting means: now.
bool Supervisor::WaitForEnd(Duration timeout, bool main_only) {
  const TimePoint deadline = Clock::now() + timeout;
  while (AnyRunning(main_only)) {
    const Duration left = deadline - Clock::now();
    if (left <= Duration::zero() || signals_->Wait(left) != 0) return !AnyRunning(main_only);
  }
  return true;
}

}  // namespace cairn::deploy
