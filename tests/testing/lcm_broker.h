#pragma once

#include <sys/types.h>

#include <string>

namespace cairn::testing {

/// LCM's own broker (lcm.jar's TCPService) on a port of this host, for as long as it is not killed.
class LcmBroker {
 public:
  /// Empty when it can be had here; else what is missing, for GTEST_SKIP.
  static std::string Missing();

  /// Starts one and waits until it answers, at most 30 s.
  explicit LcmBroker(int port);
  ~LcmBroker();
  LcmBroker(const LcmBroker&) = delete;
  LcmBroker& operator=(const LcmBroker&) = delete;

  /// SIGKILL; its connections break.
  void Kill();
  /// On the same port as before.
  void Start();

  pid_t pid() const { return pid_; }
  /// "127.0.0.1:PORT".
  std::string address() const;
  std::string url() const { return "tcpq://" + address(); }

 private:
  int port_;
  pid_t pid_ = -1;
};

}  // namespace cairn::testing
