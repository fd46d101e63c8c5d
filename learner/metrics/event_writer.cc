#include "learner/metrics/event_writer.h"

#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <cstring>

#include "common/core/clock.h"
#include "common/core/hash.h"
#include "learner/metrics/event.pb.h"

namespace cairn::learner {
namespace {

double WallSeconds() { return static_cast<double>(WallUs()) * 1e-6; }

std::string FileName() {
  std::array<char, 256> host{};
  ::gethostname(host.data(), host.size() - 1);
  return fmt::format("events.out.tfevents.{}.{}.{}", static_cast<int64_t>(WallSeconds()), host.data(), ::getpid());
}

// TFRecord rotates and offsets CRCs, so that a CRC of data that holds CRCs stays sound.
uint32_t MaskedCrc(const void* data, size_t size) {
  const uint32_t crc = Crc32c(data, size);
  return ((crc >> 15) | (crc << 17)) + 0xA282EAD8u;
}

template <typename Integer>
void AppendLittleEndian(Integer value, std::string* to) {
  for (size_t i = 0; i < sizeof(Integer); ++i) to->push_back(static_cast<char>((value >> (8 * i)) & 0xFF));
}

}  // namespace

EventWriter::EventWriter(const std::string& directory) : file_(directory + "/" + FileName()) {
  proto::Event event;
  event.set_wall_time(WallSeconds());
  event.set_file_version("brain.Event:2");
  AppendRecord(event.SerializeAsString());
  Flush();
}

void EventWriter::Scalar(std::string_view tag, double value, int64_t step, double wall_time) {
  proto::Event event;
  event.set_wall_time(wall_time >= 0 ? wall_time : WallSeconds());
  event.set_step(step);
  proto::Summary::Value* scalar = event.mutable_summary()->add_value();
  scalar->set_tag(std::string(tag));
  scalar->set_simple_value(static_cast<float>(value));
  AppendRecord(event.SerializeAsString());
}

// Record: length (8 bytes), masked CRC of the length (4), payload, masked CRC of the payload (4); little-endian.
void EventWriter::AppendRecord(const std::string& payload) {
  std::string length;
  AppendLittleEndian<uint64_t>(payload.size(), &length);
  std::string record = length;
  AppendLittleEndian(MaskedCrc(length.data(), length.size()), &record);
  record += payload;
  AppendLittleEndian(MaskedCrc(payload.data(), payload.size()), &record);
  file_.Append(record);
}

}  // namespace cairn::learner
