#include "learner/checkpoint/checkpointer.h"

#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <utility>

#include "common/core/check.h"
#include "common/core/files.h"
#include "common/core/log.h"
#include "learner/checkpoint/checkpoint_file.h"

namespace cairn::learner {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> FilesOf(const ReplayIndex& index) {
  std::vector<std::string> files;
  for (const ReplayChunk& chunk : index.chunks) files.push_back(chunk.file);
  return files;
}

bool EndsWith(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

bool IsOurs(const std::string& name) { return name.starts_with("replay-") || name.starts_with("checkpoint-"); }

std::vector<std::string> FileNames(const std::string& directory) {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(directory, error)) names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace

std::vector<std::string> ListCheckpoints(const std::string& directory) {
  std::vector<std::string> names = FileNames(directory);
  std::erase_if(names, [](const std::string& n) { return !n.starts_with("checkpoint-") || !EndsWith(n, ".ckpt"); });
  return names;
}

Checkpointer::Checkpointer(std::string directory, int kept) : directory_(std::move(directory)), kept_(kept) {
  for (const std::string& name : ListCheckpoints(directory_)) {
    const std::string path = directory_ + "/" + name;
    try {
      const RunState state = DecodeCheckpoint(ReadFile(path), path);
      files_[name] = FilesOf(state.replay);
      chunks_.emplace(directory_, state.replay);
      status_.env_steps = state.env_steps;
    } catch (const Error& error) {
      log::Warning("{}", error.what());
    }
  }
  if (!chunks_) chunks_.emplace(directory_, ReplayIndex{});
  RemoveUnused();
  thread_ = std::jthread([this](const std::stop_token& stop) { Run(stop); });
}

Checkpointer::~Checkpointer() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
}

bool Checkpointer::busy() const {
  const std::lock_guard lock(mutex_);
  return busy_;
}

void Checkpointer::Write(RunState state, ReplayBuffer* replay) {
  state.replay.num_inserted = replay->num_inserted();
  replay->Protect(std::max<int64_t>(0, replay->num_inserted() - replay->size()));
  {
    const std::lock_guard lock(mutex_);
    CAIRN_CHECK(!busy_);
    next_ = std::move(state);
    replay_ = replay;
    busy_ = true;
  }
  changed_.notify_all();
}

void Checkpointer::Wait() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return !busy_; });
}

CheckpointStatus Checkpointer::status() const {
  const std::lock_guard lock(mutex_);
  return status_;
}

void Checkpointer::Run(const std::stop_token&) {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return stop_ || next_.has_value(); });
    if (!next_) return;
    RunState state = std::move(*next_);
    next_.reset();
    ReplayBuffer* replay = replay_;
    lock.unlock();
    const TimePoint start = Clock::now();
    std::string error;
    try {
      WriteNow(&state, replay);
    } catch (const Error& e) {
      error = e.what();
    }
    replay->Unprotect();
    lock.lock();
    if (error.empty()) {
      ++status_.written;
      status_.env_steps = state.env_steps;
      log::Info("checkpoint at {} env steps: {:.0f} ms", state.env_steps, 1e3 * SecondsSince(start));
    } else {
      log::Error("checkpoint at {} env steps failed, the older ones stay: {}", state.env_steps, error);
    }
    status_.error = error;
    busy_ = false;
    changed_.notify_all();
  }
}

void Checkpointer::WriteNow(RunState* state, ReplayBuffer* replay) {
  state->replay = chunks_->Save(*replay, state->replay.num_inserted);
  replay->Unprotect();
  const std::string name = fmt::format("checkpoint-{:012}.ckpt", state->env_steps);
  WriteFileAtomically(directory_ + "/" + name, EncodeCheckpoint(*state));
  files_[name] = FilesOf(state->replay);
  for (const auto& [file, policy] : state->policies) SavePolicy(policy, directory_ + "/" + file);
  RemoveUnused();
}

// What cannot be removed now is removed the next time.
void Checkpointer::RemoveUnused() {
  while (static_cast<int>(files_.size()) > kept_) {
    std::error_code error;
    fs::remove(directory_ + "/" + files_.begin()->first, error);
    if (error) return;
    files_.erase(files_.begin());
  }
  std::set<std::string> needed;
  for (const auto& [name, files] : files_) needed.insert(files.begin(), files.end());
  for (const std::string& name : FileNames(directory_)) {
    const bool rows = EndsWith(name, ".rows") && !needed.contains(name);
    std::error_code error;
    if (IsOurs(name) && (rows || EndsWith(name, ".tmp"))) fs::remove(directory_ + "/" + name, error);
  }
}

namespace {

[[noreturn]] void ThrowNoCheckpoint(const std::string& directory) {
  ThrowUsageError("{}: it holds no checkpoint to go on from", directory);
}

}  // namespace

// Fields before rows: what the experiment's options have made unreadable is not damaged.
RunState LoadNewestCheckpoint(const std::string& directory, const RunFields& fields, ReplayBuffer* replay) {
  std::vector<std::string> names = ListCheckpoints(directory);
  if (names.empty()) ThrowNoCheckpoint(directory);
  std::string last_error;
  for (auto name = names.rbegin(); name != names.rend(); ++name) {
    const std::string path = directory + "/" + *name;
    try {
      replay->Clear();
      RunState state = DecodeCheckpoint(ReadFile(path), path);
      CheckFields(fields, state.fields, directory);
      LoadReplay(directory, state.replay, replay);
      return state;
    } catch (const UsageError&) {
      throw;
    } catch (const Error& error) {
      last_error = error.what();
      log::Error("{}; trying the one before it", error.what());
      std::error_code ignored;
      fs::rename(path, path + ".damaged", ignored);
    }
  }
  ThrowError("no checkpoint in {} is whole; the last try: {}", directory, last_error);
}

RunState ReadNewestCheckpoint(const std::string& directory) {
  std::vector<std::string> names = ListCheckpoints(directory);
  if (names.empty()) ThrowNoCheckpoint(directory);
  for (auto name = names.rbegin();; ++name) {
    const std::string path = directory + "/" + *name;
    try {
      return DecodeCheckpoint(ReadFile(path), path);
    } catch (const Error& error) {
      if (std::next(name) == names.rend()) throw;
      log::Error("{}; trying the one before it", error.what());
    }
  }
}

}  // namespace cairn::learner
