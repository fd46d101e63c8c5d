#include <cerrno>
#include <cstring>
#include <fstream>
#include <sstream>

#include "common/core/check.h"
#include "common/core/files.h"
#include "common/core/hash.h"
#include "common/nn/policy.h"
#include "common/nn/policy.pb.h"

namespace cairn {
namespace {

constexpr uint32_t kPolicyFormatVersion = 1;

std::string ReadAll(const std::string& path) {
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  if (!file) ThrowError("policy file {}: cannot open: {}", path, std::strerror(errno));
  std::ostringstream bytes;
  bytes << file.rdbuf();
  if (file.bad()) ThrowError("policy file {}: cannot read: {}", path, std::strerror(errno));
  return std::move(bytes).str();
}

std::string Serialize(const PolicyFile& policy) {
  proto::PolicyPayload payload;
  payload.set_head(static_cast<proto::PolicyPayload::Head>(policy.shape.head));
  payload.set_observation_size(policy.shape.observation_size);
  payload.set_action_size(policy.shape.action_size);
  payload.mutable_net_arch()->Add(policy.shape.net_arch.begin(), policy.shape.net_arch.end());
  payload.set_layer_norm(policy.shape.layer_norm);
  payload.mutable_parameters()->Add(policy.parameters.begin(), policy.parameters.end());
  payload.set_version(policy.version);
  payload.set_env_steps(policy.env_steps);
  payload.set_experiment_hash(policy.experiment_hash);
  const std::string bytes = payload.SerializeAsString();

  proto::PolicyFile file;
  file.set_format_version(kPolicyFormatVersion);
  file.set_payload_crc32c(Crc32c(bytes.data(), bytes.size()));
  file.set_payload(bytes);
  return file.SerializeAsString();
}

void CheckShape(const PolicyFile& policy, const std::string& path) {
  const PolicyShape& shape = policy.shape;
  bool positive = shape.observation_size > 0 && shape.action_size > 0;
  for (int width : shape.net_arch) positive = positive && width > 0;
  if (!positive) ThrowError("policy file {}: sizes must be positive: {}", path, shape.ToString());
  if (policy.parameters.size() != shape.num_parameters()) {
    ThrowError("policy file {}: {} parameters, but {} has {}", path, policy.parameters.size(), shape.ToString(),
               shape.num_parameters());
  }
}

PolicyFile FromPayload(const proto::PolicyPayload& payload, const std::string& path) {
  if (payload.head() != proto::PolicyPayload::GAUSSIAN && payload.head() != proto::PolicyPayload::DETERMINISTIC) {
    ThrowError("policy file {}: unknown head {}", path, static_cast<int>(payload.head()));
  }
  PolicyFile policy;
  policy.shape.head = static_cast<PolicyShape::Head>(payload.head());
  policy.shape.observation_size = payload.observation_size();
  policy.shape.action_size = payload.action_size();
  policy.shape.net_arch.assign(payload.net_arch().begin(), payload.net_arch().end());
  policy.shape.layer_norm = payload.layer_norm();
  policy.parameters.assign(payload.parameters().begin(), payload.parameters().end());
  policy.version = payload.version();
  policy.env_steps = payload.env_steps();
  policy.experiment_hash = payload.experiment_hash();
  CheckShape(policy, path);
  return policy;
}

}  // namespace

void SavePolicy(const PolicyFile& policy, const std::string& path) {
  CAIRN_CHECK(policy.parameters.size() == policy.shape.num_parameters());
  WriteFileAtomically(path, Serialize(policy));
}

PolicyFile LoadPolicy(const std::string& path) {
  const std::string bytes = ReadAll(path);
  proto::PolicyFile file;
  if (!file.ParseFromString(bytes)) ThrowError("policy file {}: torn or not a policy ({} bytes)", path, bytes.size());
  if (file.format_version() != kPolicyFormatVersion) {
    ThrowError("policy file {}: format version {}, this program reads {}", path, file.format_version(),
               kPolicyFormatVersion);
  }
  const uint32_t crc = Crc32c(file.payload().data(), file.payload().size());
  if (crc != file.payload_crc32c()) {
    ThrowError("policy file {}: damaged: CRC32C {:08x}, stored {:08x}", path, crc, file.payload_crc32c());
  }
  proto::PolicyPayload payload;
  if (!payload.ParseFromString(file.payload())) ThrowError("policy file {}: payload cannot be decoded", path);
  return FromPayload(payload, path);
}

}  // namespace cairn
