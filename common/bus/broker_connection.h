#pragma once

#include <chrono>
#include <memory>
#include <string>

namespace lcm {
class LCM;
}

namespace cairn {

/// One connection to an LCM broker (`tcpq://`), for one direction and one thread. LCM 1.3.1 makes an object that looks
/// sound without a broker, aborts the process in handleTimeout once the socket is gone, takes a name for this host's
/// address, and waits without end for a broker that has stopped. So LCM meets a broker only after a probe of our own
/// has heard it answer, its socket is looked at before each use, and an object whose socket failed is never used again.
class BrokerConnection {
 public:
  /// `broker` is "HOST:PORT"; HOST is resolved anew at each Open.
  explicit BrokerConnection(std::string broker);
  ~BrokerConnection();
  BrokerConnection(const BrokerConnection&) = delete;
  BrokerConnection& operator=(const BrokerConnection&) = delete;

  /// Connects; at most some four seconds. What went wrong; empty: nothing, and lcm() may be used.
  std::string Open();
  /// For a connection that failed.
  void Close();

  bool is_open() const { return lcm_ != nullptr; }
  lcm::LCM& lcm() { return *lcm_; }
  /// Its socket, for poll and options; −1 while closed.
  int fd() const;

 private:
  std::string broker_;
  std::unique_ptr<lcm::LCM> lcm_;
};

/// What answers at "HOST:PORT": empty when it is an LCM broker, else what is wrong ("connection refused", …). Takes two
/// seconds at most, name resolution left out.
std::string ProbeBroker(const std::string& broker);

/// The command that starts LCM's broker on a port, for errors.
std::string BrokerCommand(const std::string& broker);

}  // namespace cairn
