#pragma once

#include <string>

#include "common/config/experiment.h"

namespace cairn {

/// Reads `udpm://GROUP:PORT[?ttl=T]`: multicast group, first of the five ports (1024 to 65530) and ttl (0 to 255; left
/// out: 0, as in LCM); or `tcpq://HOST:PORT` of LCM's TCP broker. Throws UsageError naming the URL and the rule for
/// anything else.
TransportConfig ParseLcmUrl(const std::string& url);

/// "HOST:PORT" of a `tcpq://HOST:PORT`: a name or IPv4 address, port 1 to 65535. Throws UsageError "`name` URL: fault"
/// for anything else.
std::string ParseBrokerUrl(const std::string& name, const std::string& url);

/// The URL that ParseLcmUrl reads back.
std::string ToLcmUrl(const TransportConfig& transport);

}  // namespace cairn
