#pragma once

#include "common/config/experiment.h"
#include "common/config/experiment.pb.h"

namespace cairn::config {

/// The plain struct of a resolved message, field by field. A test sets every field of the message by reflection and
/// checks that the struct follows, so that no option is forgotten here.
Experiment FromProto(const proto::Experiment& message);

}  // namespace cairn::config
