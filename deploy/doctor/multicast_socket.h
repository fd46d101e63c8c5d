#pragma once

#include <optional>
#include <set>
#include <string>

#include "common/core/bytes.h"
#include "common/core/clock.h"

namespace cairn::deploy {

/// A datagram as it came in.
struct Datagram {
  Bytes payload;         ///< behind LCM's header and channel
  unsigned address = 0;  ///< of its sender [network order]
};

/// A socket that joins a multicast group as LCM does, without LCM, so that each step can fail by itself and be named.
/// Datagrams look like LCM's short messages on a channel that nobody listens to: firewalls that let Cairn's traffic
/// pass let these pass, and processes of a run do not mind them.
class MulticastSocket {
 public:
  MulticastSocket(const std::string& group, int port, int ttl);
  ~MulticastSocket();
  MulticastSocket(MulticastSocket&& other) noexcept;
  MulticastSocket& operator=(MulticastSocket&&) = delete;

  /// What could not be done ("bind", "join the group"), with `error`; empty when the socket is usable.
  const std::string& failed_step() const { return failed_step_; }
  int error() const { return error_; }

  /// 0 or errno.
  int Send(const Bytes& payload);
  /// The same to one address of this host instead of the group.
  int SendTo(const std::string& address, const Bytes& payload);

  /// The next datagram of ours that has come in; waits up to `timeout` for one. Others' are passed over.
  std::optional<Datagram> Receive(Duration timeout);

  int fd() const { return fd_; }
  /// Datagrams that did not fit the receive buffer, since the start.
  uint32_t dropped() const { return dropped_; }
  /// Who has sent anything to this port, not only to us [network order].
  const std::set<unsigned>& senders() const { return senders_; }

 private:
  void Fail(const char* step);
  std::optional<Datagram> ReceiveOne(bool* more);

  std::string group_;
  int port_;
  int fd_ = -1;
  std::string failed_step_;
  int error_ = 0;
  uint32_t dropped_ = 0;
  uint32_t sequence_ = 0;
  std::set<unsigned> senders_;
};

}  // namespace cairn::deploy
