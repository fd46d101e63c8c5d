#include "common/config/lcm_url.h"

#include <arpa/inet.h>
#include <fmt/core.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <optional>
#include <string_view>

#include "common/core/check.h"

namespace cairn {
namespace {

// A whole number in [min, max], digits only.
std::optional<int> ParseNumber(std::string_view text, int min, int max) {
  int number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size() || number < min || number > max) return std::nullopt;
  return number;
}

bool IsMulticastGroup(const std::string& group) {
  in_addr address{};
  return inet_pton(AF_INET, group.c_str(), &address) == 1 && (ntohl(address.s_addr) >> 28) == 0xE;
}

[[noreturn]] void Refuse(const std::string& url, const std::string& wrong) {
  ThrowUsageError(
      "--lcm-url {}: {}; it must be udpm://GROUP:PORT?ttl=T with an IPv4 multicast group, the first of five ports from "
      "1024 to 65530, and ttl from 0 to 255, or tcpq://HOST:PORT of an LCM broker",
      url, wrong);
}

int ParseTtl(const std::string& url, std::string_view query) {
  constexpr std::string_view kTtl = "ttl=";
  if (query.substr(0, kTtl.size()) != kTtl) Refuse(url, fmt::format("'{}' is not ttl=T", query));
  const std::optional<int> ttl = ParseNumber(query.substr(kTtl.size()), 0, 255);
  if (!ttl) Refuse(url, fmt::format("'{}' is no ttl", query.substr(kTtl.size())));
  return *ttl;
}

bool IsHostName(std::string_view name) {
  if (name.empty() || name.size() > 253 || name.front() == '-') return false;
  return std::all_of(name.begin(), name.end(),
                     [](unsigned char c) { return std::isalnum(c) != 0 || c == '.' || c == '-' || c == '_'; });
}

constexpr std::string_view kTcp = "tcpq://";

// What is wrong with it; empty: nothing, and `broker` is HOST:PORT.
std::string BrokerFault(std::string_view url, std::string* broker) {
  if (url.substr(0, kTcp.size()) != kTcp) return "it does not begin with tcpq://";
  *broker = url.substr(kTcp.size());
  const size_t colon = broker->find(':');
  if (colon == std::string::npos) return "the port is missing";
  if (!IsHostName(broker->substr(0, colon))) {
    return fmt::format("'{}' is neither a host name nor an IPv4 address", broker->substr(0, colon));
  }
  if (!ParseNumber(broker->substr(colon + 1), 1, 65535)) {
    return fmt::format("'{}' is no port from 1 to 65535", broker->substr(colon + 1));
  }
  return "";
}

}  // namespace

std::string ParseBrokerUrl(const std::string& name, const std::string& url) {
  std::string broker;
  const std::string fault = BrokerFault(url, &broker);
  if (fault.empty()) return broker;
  ThrowUsageError("{} \"{}\": {}; it must be tcpq://HOST:PORT of an LCM broker", name, url, fault);
}

TransportConfig ParseLcmUrl(const std::string& url) {
  constexpr std::string_view kScheme = "udpm://";
  std::string_view rest = url;
  TransportConfig transport;
  if (rest.substr(0, kTcp.size()) == kTcp) {
    const std::string fault = BrokerFault(url, &transport.broker);
    if (!fault.empty()) Refuse(url, fault);
    return transport;
  }
  if (rest.substr(0, kScheme.size()) != kScheme) Refuse(url, "it begins with neither udpm:// nor tcpq://");
  rest.remove_prefix(kScheme.size());
  const size_t question = rest.find('?');
  transport.ttl = question == std::string_view::npos ? 0 : ParseTtl(url, rest.substr(question + 1));
  const std::string_view address = rest.substr(0, question);
  const size_t colon = address.find(':');
  if (colon == std::string_view::npos) Refuse(url, "the port is missing");
  transport.group = address.substr(0, colon);
  if (!IsMulticastGroup(transport.group)) Refuse(url, fmt::format("'{}' is no multicast group", transport.group));
  const std::optional<int> port = ParseNumber(address.substr(colon + 1), 1024, 65530);
  if (!port) Refuse(url, fmt::format("'{}' is no such port", address.substr(colon + 1)));
  transport.base_port = *port;
  return transport;
}

std::string ToLcmUrl(const TransportConfig& transport) {
  if (!transport.broker.empty()) return std::string(kTcp) + transport.broker;
  return fmt::format("udpm://{}:{}?ttl={}", transport.group, transport.base_port, transport.ttl);
}

}  // namespace cairn
