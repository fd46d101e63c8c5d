#include "common/process/process.h"

#include <poll.h>
#include <sys/eventfd.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <thread>

#include "common/core/check.h"
#include "common/core/hash.h"
#include "common/core/log.h"

namespace cairn {
namespace {

// Blocks the signals that end a run in this thread and all to come; a file descriptor reports them.
int BlockStopSignals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  std::signal(SIGPIPE, SIG_IGN);
  return signalfd(-1, &signals, SFD_CLOEXEC);
}

// Waits for a stop signal, the end of file of the launcher's pipe, or the end of `body`. Without looking now and then:
// a host may have many of these processes.
void Watch(const std::stop_token& token, int signal_fd, int parent_fd, Process* process) {
  const int ended_fd = eventfd(0, EFD_CLOEXEC);
  const std::stop_callback on_end(token, [ended_fd] { eventfd_write(ended_fd, 1); });
  std::array<pollfd, 3> fds{{{ended_fd, POLLIN, 0}, {signal_fd, POLLIN, 0}, {parent_fd, POLLIN, 0}}};
  while (!token.stop_requested()) {
    if (poll(fds.data(), parent_fd >= 0 ? 3 : 2, -1) <= 0 || (fds[0].revents & POLLIN) != 0) continue;
    process->RequestStop();
    return;
  }
}

log::Level LogLevel(const std::string& name) {
  if (name == "debug") return log::Level::kDebug;
  if (name == "warning") return log::Level::kWarning;
  if (name == "error") return log::Level::kError;
  return log::Level::kInfo;
}

int Fail(ProcessKind kind, const std::exception& error, int status) {
  std::fprintf(stderr, "cairn-%s: error: %s\n", ProcessName(kind), error.what());
  return status;
}

}  // namespace

Process::Process(ProcessKind kind, ProcessOptions options)
    : options_(std::move(options)), loaded_(LoadProcessExperiment(options_)), session_(RandomId()) {
  if (!options_.key.empty()) key_ = ReadKeyFile(options_.key);
  log::Init(kind == ProcessKind::kActor ? fmt::format("actor-{:04}", options_.actor_id) : ProcessName(kind), "",
            LogLevel(options_.log_level));
}

BusConfig Process::MakeBusConfig() const {
  const TransportConfig& transport = loaded_.experiment.transport;
  return {transport.group,  transport.base_port,       transport.ttl, options_.run_id, session_, key_,
          transport.broker, transport.telemetry_broker};
}

void Process::OnStop(std::function<void()> stop) {
  const std::lock_guard lock(mutex_);
  on_stop_ = std::move(stop);
}

void Process::RequestStop() {
  const std::lock_guard lock(mutex_);
  if (!on_stop_) _exit(128 + SIGTERM);  // before the end of the run
  on_stop_();
}

int RunProcess(ProcessKind kind, int argc, char** argv, const std::function<void(Process&)>& body) {
  try {
    const std::optional<ProcessOptions> options = ParseProcessOptions(kind, argc, argv);
    if (!options) return 0;
    const int signal_fd = BlockStopSignals();
    Process process(kind, *options);
    std::jthread watcher([&](const std::stop_token& token) { Watch(token, signal_fd, options->parent_fd, &process); });
    body(process);
    return 0;
  } catch (const UsageError& error) {
    return Fail(kind, error, 2);
  } catch (const std::exception& error) {
    return Fail(kind, error, 1);
  }
}

}  // namespace cairn
