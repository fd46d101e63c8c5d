#pragma once

#include <string>

namespace cairn::deploy {

/// The kernel's way to an address, as `ip route get` says.
struct Route {
  int error = 0;          ///< errno when there is none
  std::string interface;  ///< by which packets leave
  int mtu = 0;            ///< of the interface [bytes]
  bool up = false;
  bool carrier = false;  ///< a cable, or what stands for one
  bool multicast = false;
  bool loopback = false;
};

Route FindRoute(const std::string& address);

/// The interface alone; `error` when there is none of that name.
Route FindInterface(const std::string& name);

/// Interfaces that are up, have an IPv4 address and lead to other hosts, separated by " or "; "<interface>" for none.
std::string OutwardInterfaces();

/// Whether this IPv4 address [network order] is one of this host's.
bool IsOwnAddress(unsigned address);

}  // namespace cairn::deploy
