#include "learner/algorithms/algorithm.h"

#include <algorithm>
#include <string_view>
#include <vector>

#include "common/core/check.h"
#include "common/core/hash.h"
#include "learner/algorithms/batch.h"
#include "learner/algorithms/batch_random.h"
#include "learner/algorithms/sac.h"
#include "learner/algorithms/td3.h"
#include "learner/optim/adam.h"

namespace cairn::learner {
namespace {

/// Sums of UpdateInfo; actor and temperature have a number of updates of their own.
class InfoSums {
 public:
  void Add(const UpdateInfo& info) {
    ++updates_;
    actor_updates_ += info.num_actor_updates;
    sum_.critic_loss += info.critic_loss;
    sum_.actor_loss += info.actor_loss;
    sum_.alpha += info.alpha;
    sum_.alpha_loss += info.alpha_loss;
    sum_.mean_q += info.mean_q;
    sum_.mean_log_prob += info.mean_log_prob;
  }

  UpdateInfo Take() {
    const double critic = 1.0 / static_cast<double>(std::max<int64_t>(updates_, 1));
    const double actor = 1.0 / static_cast<double>(std::max<int64_t>(actor_updates_, 1));
    UpdateInfo mean;
    mean.critic_loss = sum_.critic_loss * critic;
    mean.mean_q = sum_.mean_q * critic;
    mean.actor_loss = sum_.actor_loss * actor;
    mean.alpha = sum_.alpha * actor;
    mean.alpha_loss = sum_.alpha_loss * actor;
    mean.mean_log_prob = sum_.mean_log_prob * actor;
    mean.num_actor_updates = actor_updates_;
    *this = InfoSums();
    return mean;
  }

 private:
  int64_t updates_ = 0;
  int64_t actor_updates_ = 0;
  UpdateInfo sum_;
};

/// Batches from replay for Method = Sac<float> or Td3<float>. The rows of an update are drawn while the update before
/// it computes, and fetched into the cache piece by piece.
template <typename Method>
class OffPolicy final : public Algorithm {
 public:
  OffPolicy(const LearnerConfig& config, const PolicyShape& shape, uint64_t seed)
      : config_(config),
        method_(config, shape, seed),
        random_(seed),
        batch_(config.batch_size, shape.observation_size, shape.action_size),
        rows_(config.batch_size),
        next_rows_(config.batch_size) {}

  void Update(const ReplayBuffer& replay, int count, double progress) override {
    CAIRN_CHECK(replay.size() > 0);
    const double learning_rate = LinearDecay(config_.learning_rate, config_.final_learning_rate_fraction, progress);
    DrawRows(replay, &next_rows_);
    for (int i = 0; i < count; ++i) {
      rows_.swap(next_rows_);
      FillBatch(replay);
      ++num_updates_;
      const bool more = i + 1 < count;
      if (more) DrawRows(replay, &next_rows_);
      prefetched_ = more ? 0 : config_.batch_size;
      sums_.Add(method_.Update(&batch_, learning_rate, [&] { PrefetchSome(replay); }));
    }
  }

  std::span<const float> policy_parameters() const override { return method_.policy().parameters(); }

  UpdateInfo TakeInfo() override {
    UpdateInfo info = sums_.Take();
    info.num_updates = num_updates_;
    return info;
  }

  uint32_t WeightsCrc32c() const override {
    uint32_t crc = 0;
    method_.VisitWeights([&crc](std::string_view, std::span<const float> values) {
      crc = Crc32c(values.data(), values.size_bytes(), crc);
    });
    return crc;
  }

 private:
  void DrawRows(const ReplayBuffer& replay, std::vector<uint32_t>* rows) const {
    random_.Below(BatchRandom::Purpose::kReplayRows, num_updates_, static_cast<uint32_t>(replay.size()),
                  config_.batch_size, rows->data());
  }

  void FillBatch(const ReplayBuffer& replay) {
    const int numbers = batch_.size() * batch_.action_size();
    random_.Normals(BatchRandom::Purpose::kNextNoise, num_updates_, numbers, batch_.next_noise());
    random_.Normals(BatchRandom::Purpose::kNoise, num_updates_, numbers, batch_.noise());
    batch_.Gather(replay, rows_);
  }

  // An equal share of the next rows at each pause of the method.
  void PrefetchSome(const ReplayBuffer& replay) {
    const int share = (config_.batch_size + method_.num_pauses() - 1) / method_.num_pauses();
    const int end = std::min(config_.batch_size, prefetched_ + share);
    for (; prefetched_ < end; ++prefetched_) replay.Prefetch(static_cast<int>(next_rows_[prefetched_]));
  }

  LearnerConfig config_;
  Method method_;
  BatchRandom random_;
  Batch<float> batch_;
  std::vector<uint32_t> rows_, next_rows_;
  int prefetched_ = 0;
  int64_t num_updates_ = 0;
  InfoSums sums_;
};

}  // namespace

std::unique_ptr<Algorithm> MakeAlgorithm(const LearnerConfig& config, const PolicyShape& shape, uint64_t seed) {
  if (config.algorithm == LearnerConfig::Algorithm::kSac) {
    return std::make_unique<OffPolicy<Sac<float>>>(config, shape, seed);
  }
  return std::make_unique<OffPolicy<Td3<float>>>(config, shape, seed);
}

}  // namespace cairn::learner
