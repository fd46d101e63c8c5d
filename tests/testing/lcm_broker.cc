#include "tests/testing/lcm_broker.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <thread>

#include "common/bus/broker_connection.h"
#include "common/core/check.h"
#include "common/core/clock.h"

namespace cairn::testing {
namespace {
constexpr const char* kJar = "/usr/share/java/lcm.jar";
}

std::string LcmBroker::Missing() {
  if (!std::filesystem::exists("/usr/bin/java")) return "no java (default-jre)";
  if (!std::filesystem::exists(kJar)) return "no lcm.jar (liblcm-java)";
  return "";
}

LcmBroker::LcmBroker(int port) : port_(port) { Start(); }

LcmBroker::~LcmBroker() { Kill(); }

std::string LcmBroker::address() const { return "127.0.0.1:" + std::to_string(port_); }

void LcmBroker::Kill() {
  if (pid_ < 0) return;
  kill(pid_, SIGKILL);
  waitpid(pid_, nullptr, 0);
  pid_ = -1;
}

void LcmBroker::Start() {
  CAIRN_CHECK(pid_ < 0);
  const std::string port = std::to_string(port_);
  pid_ = fork();
  CAIRN_CHECK(pid_ >= 0);
  if (pid_ == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    const int null = open("/dev/null", O_WRONLY);
    dup2(null, STDOUT_FILENO);
    execl("/usr/bin/java", "java", "-cp", kJar, "lcm.lcm.TCPService", port.c_str(), nullptr);
    _exit(127);
  }
  const TimePoint deadline = Clock::now() + std::chrono::seconds(30);
  std::string fault;
  while (!(fault = ProbeBroker(address())).empty()) {
    if (Clock::now() > deadline) ThrowError("LCM's broker on port {} does not answer: {}", port_, fault);
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
}

}  // namespace cairn::testing
