#include "common/roadmap/roadmap_blob.h"

#include <bit>
#include <cmath>
#include <cstring>

namespace cairn {
namespace {

static_assert(std::endian::native == std::endian::little, "blobs are little-endian");

template <typename T>
void Put(const T* values, size_t count, Bytes* blob) {
  const size_t at = blob->size();
  blob->resize(at + count * sizeof(T));
  if (count > 0) std::memcpy(blob->data() + at, values, count * sizeof(T));
}

class Reader {
 public:
  explicit Reader(ByteSpan blob) : blob_(blob) {}
  template <typename T>
  bool Get(T* values, size_t count) {
    if (count > (blob_.size() - at_) / sizeof(T)) return false;
    if (count > 0) std::memcpy(values, blob_.data() + at_, count * sizeof(T));
    at_ += count * sizeof(T);
    return true;
  }
  size_t left() const { return blob_.size() - at_; }

 private:
  ByteSpan blob_;
  size_t at_ = 0;
};

}  // namespace

Bytes PackPositions(const Roadmap& roadmap) {
  Bytes blob;
  const int32_t header[3] = {roadmap.dimension, roadmap.num_vertices(), roadmap.num_bends};
  Put(header, 3, &blob);
  Put(roadmap.positions.data(), roadmap.positions.size(), &blob);
  return blob;
}

std::optional<Roadmap> UnpackPositions(ByteSpan blob) {
  Reader reader(blob);
  int32_t header[3];
  if (!reader.Get(header, 3) || header[0] < 2 || header[0] > 3 || header[1] < 1) return std::nullopt;
  if (header[2] < 0 || header[2] >= header[1]) return std::nullopt;
  Roadmap roadmap;
  roadmap.dimension = header[0];
  roadmap.num_bends = header[2];
  const size_t count = static_cast<size_t>(header[0]) * static_cast<size_t>(header[1]);
  if (reader.left() != count * sizeof(float)) return std::nullopt;
  roadmap.positions.resize(count);
  reader.Get(roadmap.positions.data(), count);
  for (const float p : roadmap.positions) {
    if (!std::isfinite(p)) return std::nullopt;
  }
  return roadmap;
}

Bytes PackTable(const CostTable& table) {
  Bytes blob;
  Put(&table.roadmap_hash, 1, &blob);
  Put(table.goal.min.data(), 3, &blob);
  Put(table.goal.max.data(), 3, &blob);
  const auto vertices = static_cast<int32_t>(table.cost.size());
  Put(&vertices, 1, &blob);
  Put(table.cost.data(), table.cost.size(), &blob);
  Put(table.next_vertex.data(), table.next_vertex.size(), &blob);
  const auto marks = static_cast<int32_t>(table.marks.size() / 3);
  Put(&table.mark_reach, 1, &blob);
  Put(&marks, 1, &blob);
  Put(table.marks.data(), table.marks.size(), &blob);
  return blob;
}

std::optional<CostTable> UnpackTable(ByteSpan blob) {
  Reader reader(blob);
  CostTable table;
  int32_t vertices = 0;
  if (!reader.Get(&table.roadmap_hash, 1) || !reader.Get(table.goal.min.data(), 3) ||
      !reader.Get(table.goal.max.data(), 3) || !reader.Get(&vertices, 1) || vertices < 1) {
    return std::nullopt;
  }
  const auto count = static_cast<size_t>(vertices);
  if (reader.left() < count * (sizeof(float) + sizeof(int32_t)) + 8) return std::nullopt;
  table.cost.resize(count);
  table.next_vertex.resize(count);
  reader.Get(table.cost.data(), count);
  reader.Get(table.next_vertex.data(), count);
  int32_t marks = 0;
  if (!reader.Get(&table.mark_reach, 1) || !reader.Get(&marks, 1) || marks < 0) return std::nullopt;
  if (!(table.mark_reach >= 0 && std::isfinite(table.mark_reach))) return std::nullopt;
  if (reader.left() != static_cast<size_t>(marks) * 3 * sizeof(float)) return std::nullopt;
  table.marks.resize(static_cast<size_t>(marks) * 3);
  reader.Get(table.marks.data(), table.marks.size());
  for (const float p : table.marks) {
    if (!std::isfinite(p)) return std::nullopt;
  }
  for (size_t v = 0; v < count; ++v) {
    if (!(table.cost[v] >= 0) || table.next_vertex[v] < -1 || table.next_vertex[v] >= vertices) return std::nullopt;
  }
  return table;
}

}  // namespace cairn
