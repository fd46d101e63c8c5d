#include "common/bus/log_recorder.h"

#include <poll.h>
#include <stdio_ext.h>
#include <sys/eventfd.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <lcm/lcm-cpp.hpp>
#include <set>
#include <sstream>
#include <utility>

#include "common/core/check.h"
#include "common/core/log.h"

namespace cairn {
namespace {

constexpr int kEventOverhead = 28;  // bytes of an event besides channel and data
constexpr int kMessagesPerTurn = 4096;

// Datagrams that the kernel could not give to this process's UDP sockets: the last column of /proc/net/udp.
int64_t KernelDrops() {
  std::set<std::string> inodes;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd", error)) {
    const std::string target = std::filesystem::read_symlink(entry.path(), error).string();
    if (target.rfind("socket:[", 0) == 0) inodes.insert(target.substr(8, target.size() - 9));
  }
  std::ifstream table("/proc/net/udp");
  int64_t drops = 0;
  for (std::string line; std::getline(table, line);) {
    std::istringstream words(line);
    std::vector<std::string> columns;
    for (std::string word; words >> word;) columns.push_back(word);
    if (columns.size() > 12 && inodes.contains(columns[9])) drops += std::stoll(columns[12]);
  }
  return drops;
}

int64_t NowUs() {
  using std::chrono::microseconds;
  return std::chrono::duration_cast<microseconds>(std::chrono::system_clock::now().time_since_epoch()).count();
}

}  // namespace

// One plane, as it comes.
struct LogRecorder::Source {
  Source(LogRecorder* r, Plane p) : recorder(r), plane(p) {
    const std::string url = PlaneUrl(r->config_.bus, p);
    if (!r->config_.bus.broker.empty()) {
      broker = std::make_unique<BrokerLink>(url.substr(url.rfind('/') + 1), r->wake_fd_);
      broker->Subscribe(PlaneChannels(p));
      return;
    }
    lcm = std::make_unique<lcm::LCM>(url);
    lcm::Subscription* all = lcm->good() ? lcm->subscribe(".*", &Source::Handle, this) : nullptr;
    if (all == nullptr) ThrowError("LCM {}: cannot join the {} plane; {}", url, PlaneName(p), kMulticastCure);
    all->setQueueCapacity(0);  // no limit: what is slow here is written by a thread of its own
  }

  int fd() const { return broker ? broker->fd() : lcm->getFileno(); }

  void TakeSome() {
    for (int i = 0; i < kMessagesPerTurn; ++i) {
      if (!broker) {
        if (lcm->handleTimeout(0) <= 0) return;
      } else if (std::optional<BrokerLink::Datagram> d = broker->Take()) {
        recorder->Push(plane, {NowUs(), std::move(d->channel), std::move(d->bytes)});
      } else {
        return;
      }
    }
  }

  void Handle(const lcm::ReceiveBuffer* buffer, const std::string& channel) {
    if (buffer->data_size > 64u << 20) return;  // a datagram without NUL in the channel
    const auto* bytes = static_cast<const uint8_t*>(buffer->data);
    recorder->Push(plane, {buffer->recv_utime, channel, Bytes(bytes, bytes + buffer->data_size)});
  }

  LogRecorder* recorder;
  Plane plane;
  std::unique_ptr<lcm::LCM> lcm;
  std::unique_ptr<BrokerLink> broker;
};

// LCM's writer, and where its messages end, so that a full disk leaves whole ones.
struct LogRecorder::File {
  explicit File(const std::string& path) : log(path, "w") {
    if (!log.good()) ThrowError("log {}: {}", path, std::strerror(errno));
    setvbuf(log.getFilePtr(), nullptr, _IOFBF, 1 << 20);
  }

  bool Write(Item* item) {
    lcm::LogEvent event{0, item->message.utime, item->message.channel, static_cast<int32_t>(item->message.bytes.size()),
                        item->message.bytes.data()};
    if (log.writeEvent(&event) != 0) return false;
    end += static_cast<int64_t>(kEventOverhead + item->message.channel.size() + item->message.bytes.size());
    ends.push_back(end);
    return true;
  }

  bool Flush() {
    if (fflush(log.getFilePtr()) != 0) return false;
    ends.assign(1, end);
    return true;
  }

  // After a fault: how many messages since the last flush stand whole in the file.
  int64_t CutTornEnd() {
    FILE* f = log.getFilePtr();
    __fpurge(f);
    struct stat info {};
    if (fstat(fileno(f), &info) != 0 || !S_ISREG(info.st_mode)) return 0;
    const auto torn = std::upper_bound(ends.begin() + 1, ends.end(), static_cast<int64_t>(info.st_size));
    if (ftruncate(fileno(f), *(torn - 1)) != 0) log::Warning("the log's last message is torn");
    return torn - ends.begin() - 1;
  }

  lcm::LogFile log;
  int64_t end = 0;
  std::vector<int64_t> ends{0};  // of messages since the last flush, its own first
};

LogRecorder::LogRecorder(RecordingConfig config)
    : config_(std::move(config)), wake_fd_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  CAIRN_CHECK(wake_fd_ >= 0 && !config_.planes.empty());
  for (const Plane plane : config_.planes) sources_.push_back(std::make_unique<Source>(this, plane));
  file_ = std::make_unique<File>(config_.file);  // once the planes are joined: no empty file is left of a failure
  writer_ = std::thread([this] { Write(); });
  receiver_ = std::jthread([this](const std::stop_token& stop) { Receive(stop); });
}

LogRecorder::~LogRecorder() {
  Finish();
  sources_.clear();
  close(wake_fd_);
}

RecordingStats LogRecorder::stats() const {
  const int64_t kernel = KernelDrops();
  RecordingStats stats;
  {
    const std::lock_guard lock(mutex_);
    stats = stats_;
  }
  stats.dropped_by_kernel = kernel;
  for (const auto& source : sources_) {
    if (!source->broker) continue;
    stats.dropped_by_queue += source->broker->dropped();
    if (!stats.outage) stats.outage = source->broker->outage();
  }
  return stats;
}

RecordingStats LogRecorder::Finish() {
  receiver_.request_stop();
  eventfd_write(wake_fd_, 1);
  if (receiver_.joinable()) receiver_.join();
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
  }
  filled_.notify_all();
  if (writer_.joinable()) writer_.join();
  RecordingStats all = stats();
  file_.reset();
  return all;
}

void LogRecorder::Receive(const std::stop_token& stop) {
  std::vector<pollfd> fds{{wake_fd_, POLLIN, 0}};
  for (const auto& source : sources_) fds.push_back({source->fd(), POLLIN, 0});
  while (!stop.stop_requested()) {
    if (poll(fds.data(), fds.size(), -1) <= 0) continue;
    eventfd_t ignored = 0;
    if ((fds[0].revents & POLLIN) != 0) eventfd_read(wake_fd_, &ignored);
    for (size_t i = 0; i < sources_.size(); ++i) {
      if ((fds[i + 1].revents & POLLIN) != 0) sources_[i]->TakeSome();
    }
  }
  for (const auto& source : sources_) source->TakeSome();  // what had come by then
}

void LogRecorder::Push(Plane plane, LoggedMessage message) {
  const auto bytes = static_cast<int64_t>(message.bytes.size());
  {
    const std::lock_guard lock(mutex_);
    if (!stats_.error.empty()) return;
    if (queued_bytes_ + bytes > config_.queue_bytes) {
      ++stats_.dropped_by_queue;
      return;
    }
    queued_bytes_ += bytes;
    queue_.push_back({plane, std::move(message)});
  }
  filled_.notify_one();
}

void LogRecorder::Write() {
  std::deque<Item> batch;
  while (true) {
    {
      std::unique_lock lock(mutex_);
      filled_.wait(lock, [this] { return ended_ || !queue_.empty(); });
      if (queue_.empty()) return;
      batch.clear();
      batch.swap(queue_);
      queued_bytes_ = 0;
    }
    errno = 0;
    const bool sound =
        std::all_of(batch.begin(), batch.end(), [this](Item& item) { return file_->Write(&item); }) && file_->Flush();
    const std::string fault = sound ? "" : std::strerror(errno);
    const int64_t whole = sound ? static_cast<int64_t>(batch.size()) : file_->CutTornEnd();
    const std::lock_guard lock(mutex_);
    for (int64_t k = 0; k < whole; ++k) {
      const Item& item = batch[static_cast<size_t>(k)];
      ++stats_.messages[static_cast<size_t>(item.plane)];
      stats_.bytes += static_cast<int64_t>(item.message.bytes.size());
    }
    if (sound) continue;
    stats_.error = fmt::format("log {}: {}", config_.file, fault);
    queue_.clear();
    return;
  }
}

}  // namespace cairn
