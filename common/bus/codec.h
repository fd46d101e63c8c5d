#pragma once

#include <optional>

#include "common/bus/messages.h"
#include "common/core/bytes.h"

namespace cairn {

// Encode gives standard LCM encoding (fingerprint first), so that lcm-spy and lcm-logplayer decode it. Wall-clock
// `utime` fields that the structs lack are stamped here. Decode refuses (nullopt) whatever is not exactly as long as
// its own counts promise or holds values outside their enums; sizes are checked before any generated decode, which
// would allocate first and look later. Nothing here throws on bad bytes.

Bytes Encode(const Echo& message);
Bytes Encode(const Hello& message);
Bytes Encode(const Welcome& message);
Bytes Encode(const AssignedState& message);
Bytes Encode(const ActorStatus& message);
Bytes Encode(const Experience& message);
Bytes Encode(const Control& message);
Bytes Encode(const PolicyChunk& message);
Bytes Encode(const TableRequest& message);
Bytes Encode(const TableInfo& message);
Bytes Encode(const TableChunk& message);
Bytes Encode(const LearnerTelemetry& message);
Bytes Encode(const ActorTelemetry& message);
Bytes Encode(const PlannerTelemetry& message);
Bytes Encode(const RobotState& message);
Bytes Encode(const RobotCommand& message);

/// Specialised for every message above.
template <typename Message>
std::optional<Message> Decode(ByteSpan bytes);

}  // namespace cairn
