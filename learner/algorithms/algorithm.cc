#include "learner/algorithms/algorithm.h"

#include <algorithm>
#include <cstring>
#include <span>
#include <string_view>
#include <vector>

#include "common/core/check.h"
#include "common/core/hash.h"
#include "common/core/log.h"
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
    mean.num_means = updates_;
    mean.num_actor_updates = actor_updates_;
    *this = InfoSums();
    return mean;
  }

 private:
  int64_t updates_ = 0;
  int64_t actor_updates_ = 0;
  UpdateInfo sum_;
};

/// Brings replay rows and noise into a batch just before they are needed.
class ReplayFeeder final : public BatchFeeder {
 public:
  /// `uses_noise`: Batch::noise() too, not next_noise() alone.
  ReplayFeeder(const BatchRandom& random, bool uses_noise, Batch<float>* batch)
      : random_(random), uses_noise_(uses_noise), batch_(batch), rows_(batch->size()) {}

  /// Before each update.
  void StartUpdate(const ReplayBuffer& replay, int64_t update) {
    replay_ = &replay;
    update_ = update;
    random_.Below(BatchRandom::Purpose::kReplayRows, update, static_cast<uint32_t>(replay.size()),
                  static_cast<int>(rows_.size()), rows_.data());
  }

  void Need(int first, int count) override {
    batch_->Gather(*replay_, rows_, first, count);
    for (int a = 0; a < batch_->action_size(); ++a) {
      const int start = a * batch_->size() + first;
      random_.Normals(BatchRandom::Purpose::kNextNoise, update_, start, count, batch_->next_noise() + start);
      if (!uses_noise_) continue;
      random_.Normals(BatchRandom::Purpose::kNoise, update_, start, count, batch_->noise() + start);
    }
  }

 private:
  const BatchRandom& random_;
  bool uses_noise_;
  Batch<float>* batch_;
  const ReplayBuffer* replay_ = nullptr;
  int64_t update_ = 0;
  std::vector<uint32_t> rows_;
};

/// Batches from replay and random numbers for Method = Sac<float> or Td3<float>.
template <typename Method>
class OffPolicy final : public Algorithm {
 public:
  OffPolicy(const LearnerConfig& config, const PolicyShape& shape, uint64_t seed)
      : config_(config),
        method_(config, shape, seed),
        random_(seed),
        batch_(config.batch_size, shape.observation_size, shape.action_size),
        feeder_(random_, Method::kUsesNoise, &batch_) {}

  void Update(const ReplayBuffer& replay, int count, double progress) override {
    CAIRN_CHECK(replay.size() > 0 && replay.observation_size() == batch_.observation_size() &&
                replay.action_size() == batch_.action_size());
    const double learning_rate = LinearDecay(config_.learning_rate, config_.final_learning_rate_fraction, progress);
    for (int i = 0; i < count; ++i, ++num_updates_) {
      feeder_.StartUpdate(replay, num_updates_);
      UpdateOnce(learning_rate);
    }
  }

  std::span<const float> policy_parameters() const override { return method_.policy().parameters(); }

  UpdateInfo TakeInfo() override {
    UpdateInfo info = sums_.Take();
    info.num_updates = num_updates_;
    info.bad_updates = bad_updates_;
    return info;
  }

  std::vector<StateArray> Save() override {
    std::vector<StateArray> state;
    VisitState([&state](const std::string& name, bool, std::span<std::byte> numbers) {
      const auto* bytes = reinterpret_cast<const uint8_t*>(numbers.data());
      state.push_back({name, Bytes(bytes, bytes + numbers.size())});
    });
    return state;
  }

  void Load(const std::vector<StateArray>& state) override { LoadArrays(state, false); }
  void LoadNetworks(const std::vector<StateArray>& state) override {
    LoadArrays(state, true);
    method_.ResetOptimizers();
  }

  uint32_t WeightsCrc32c() const override {
    uint32_t crc = 0;
    method_.VisitWeights([&crc](std::string_view, std::span<const float> values) {
      crc = Crc32c(values.data(), values.size_bytes(), crc);
    });
    return crc;
  }

 private:
  void UpdateOnce(double learning_rate) {
    try {
      sums_.Add(method_.Update(&batch_, learning_rate, &feeder_));
      bad_in_a_row_ = 0;
    } catch (const NonFiniteError& error) {
      ++bad_updates_;
      log::Warning("update {} broken off: {}", num_updates_, error.what());
      if (++bad_in_a_row_ < config_.max_bad_updates) return;
      ThrowError("{} updates in a row were not finite (learner.max_bad_updates); the last, number {}: {}",
                 bad_in_a_row_, num_updates_, error.what());
    }
  }

  void VisitState(const StateVisitor& visit) {
    method_.VisitState(visit);
    VisitNumbers(visit, "num_updates", false, &num_updates_, 1);
    VisitNumbers(visit, "bad_updates", false, &bad_updates_, 1);
  }

  // All sizes are checked before the first number changes.
  void LoadArrays(const std::vector<StateArray>& state, bool networks_only) {
    const auto find = [&](const std::string& name) {
      return std::find_if(state.begin(), state.end(), [&](const StateArray& a) { return a.name == name; });
    };
    VisitState([&](const std::string& name, bool network, std::span<std::byte> numbers) {
      if (networks_only && !network) return;
      const auto array = find(name);
      if (array == state.end()) ThrowError("the saved state has no {}", name);
      if (array->data.size() != numbers.size()) {
        ThrowError("the saved {} has {} bytes, this experiment's has {}", name, array->data.size(), numbers.size());
      }
    });
    VisitState([&](const std::string& name, bool network, std::span<std::byte> numbers) {
      if (networks_only && !network) return;
      std::memcpy(numbers.data(), find(name)->data.data(), numbers.size());
    });
    method_.StateChanged();
  }

  LearnerConfig config_;
  Method method_;
  BatchRandom random_;
  Batch<float> batch_;
  ReplayFeeder feeder_;
  int64_t num_updates_ = 0;
  int64_t bad_updates_ = 0;
  int bad_in_a_row_ = 0;
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
