#include "common/core/version.h"

#include "git_revision.h"

namespace cairn {

const char* GitRevision() { return CAIRN_GIT_REVISION; }

const char* ProjectVersion() { return CAIRN_VERSION; }

}  // namespace cairn
