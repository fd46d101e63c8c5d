#pragma once

#include <string>

#include "common/config/experiment.h"

namespace cairn {

/// Reads `udpm://GROUP:PORT[?ttl=T]`: multicast group, first of the five ports (1024 to 65530) and ttl (0 to 255; left
/// out: 0, as in LCM). Throws UsageError naming the URL and the rule for anything else.
TransportConfig ParseLcmUrl(const std::string& url);

/// The URL that ParseLcmUrl reads back.
std::string ToLcmUrl(const TransportConfig& transport);

}  // namespace cairn
