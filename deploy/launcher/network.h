#pragma once

#include <sys/types.h>

#include <cstdint>
#include <string>

namespace cairn::deploy {

/// True when the kernel knows a way to this IPv4 multicast group; LCM needs one, even to reach its own host.
bool HasMulticastRoute(const std::string& group);

/// The network a run lives in.
struct NetworkInfo {
  bool is_private = false;      ///< a network namespace of its own, with nothing but loopback
  bool user_namespace = false;  ///< entered with a user namespace of its own as well (without root)
  uint64_t inode = 0;           ///< of the network namespace
};

/// Returns at once when there is a route to `group`. Else, with ttl 0, moves this process into a private network
/// namespace with loopback up and a multicast route; children inherit it. Call while single-threaded.
/// Throws Error with the cure when there is no route and no such way (ttl ≥ 1, or the kernel refuses).
NetworkInfo PrepareNetwork(const std::string& group, int ttl);

/// The namespace part alone: always enters one. Throws Error when the kernel refuses.
NetworkInfo EnterPrivateNetwork(const std::string& group);

/// Moves this process into the network (and user) namespace of `pid`. Throws Error naming what is missing.
void JoinNetworkOf(pid_t pid);

/// Inode of a process's network namespace; 0 when it cannot be read (the process is gone).
uint64_t NetworkInode(pid_t pid);

/// The command that starts a shell in the network of `pid`.
std::string LookInsideCommand(pid_t pid, const NetworkInfo& network);

}  // namespace cairn::deploy
