#include "planner/roadmap_file.h"

#include <bit>
#include <cmath>
#include <cstring>
#include <vector>

#include "common/core/check.h"
#include "common/core/hash.h"

namespace cairn::planner {
namespace {

static_assert(std::endian::native == std::endian::little, "roadmap files are little-endian");

constexpr std::string_view kMagic = "CAIRNRMP";
constexpr uint32_t kFormatVersion = 2;
constexpr size_t kHeaderBytes = kMagic.size() + sizeof(uint32_t) + sizeof(uint64_t);

template <typename T>
void Append(const T* values, size_t count, std::string* bytes) {
  bytes->append(reinterpret_cast<const char*>(values), count * sizeof(T));
}

template <typename T>
void Append(const T& value, std::string* bytes) {
  Append(&value, 1, bytes);
}

template <typename T>
T ReadAt(std::string_view bytes, size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof(T));
  return value;
}

// The body of a file whose frame is sound.
std::string_view OpenFrame(std::string_view bytes, const std::string& file) {
  if (bytes.substr(0, kMagic.size()) != kMagic.substr(0, bytes.size())) {
    ThrowUsageError("{}: not a roadmap; `cairn plan --save` writes one", file);
  }
  const auto torn = [&](uint64_t needed) { ThrowUsageError("{}: torn: {} bytes of {}", file, bytes.size(), needed); };
  if (bytes.size() < kHeaderBytes) torn(kHeaderBytes);
  const auto version = ReadAt<uint32_t>(bytes, kMagic.size());
  if (version != kFormatVersion) {
    ThrowUsageError("{}: roadmap format {}; this build reads {}", file, version, kFormatVersion);
  }
  const auto length = ReadAt<uint64_t>(bytes, kMagic.size() + sizeof(uint32_t));
  const uint64_t needed = kHeaderBytes + length + sizeof(uint32_t);
  if (length > bytes.size() || bytes.size() < needed) torn(needed);
  if (bytes.size() > needed) ThrowUsageError("{}: damaged: {} bytes after its end", file, bytes.size() - needed);
  const std::string_view signed_part = bytes.substr(0, kHeaderBytes + length);
  if (Crc32c(signed_part.data(), signed_part.size()) != ReadAt<uint32_t>(bytes, signed_part.size())) {
    ThrowUsageError("{}: damaged: its checksum does not fit", file);
  }
  return signed_part.substr(kHeaderBytes);
}

// Takes values off a body. What does not fit is damage, though the checksum says otherwise.
class Reader {
 public:
  Reader(std::string_view body, const std::string& file) : body_(body), file_(file) {}

  template <typename T>
  T Take() {
    std::vector<T> one;
    TakeArray(1, &one);
    return one[0];
  }

  template <typename T>
  void TakeArray(uint64_t count, std::vector<T>* values) {
    if (count > body_.size() / sizeof(T)) Throw("shorter than its counts say");
    values->resize(count);
    std::memcpy(values->data(), body_.data(), count * sizeof(T));
    body_.remove_prefix(count * sizeof(T));
  }

  void End() const {
    if (!body_.empty()) Throw("longer than its counts say");
  }

  [[noreturn]] void Throw(const std::string& what) const { ThrowUsageError("{}: damaged: {}", file_, what); }

 private:
  std::string_view body_;
  const std::string& file_;
};

bool FiniteAll(const std::vector<float>& values, float least) {
  for (const float v : values) {
    if (!(std::isfinite(v) && v >= least)) return false;
  }
  return true;
}

// Both ways of each edge, once, in ascending order, of one length.
bool IsGraph(const Roadmap& roadmap) {
  const int32_t vertices = roadmap.num_vertices();
  if (roadmap.offsets.front() != 0 || roadmap.offsets.back() != static_cast<int64_t>(roadmap.neighbors.size())) {
    return false;
  }
  for (size_t v = 0; v + 1 < roadmap.offsets.size(); ++v) {
    if (roadmap.offsets[v] > roadmap.offsets[v + 1]) return false;
  }
  // Vertices in ascending order meet each neighbour's list from its beginning: one pointer a list finds all ways back.
  std::vector<int32_t> next(roadmap.offsets.begin(), roadmap.offsets.end() - 1);
  for (int32_t v = 0; v < vertices; ++v) {
    for (int32_t e = roadmap.offsets[v]; e < roadmap.offsets[v + 1]; ++e) {
      const int32_t u = roadmap.neighbors[e];
      if (u < 0 || u >= vertices || u == v || next[u] >= roadmap.offsets[u + 1]) return false;
      const int32_t back = next[u]++;
      if (roadmap.neighbors[back] != v || roadmap.lengths[back] != roadmap.lengths[e]) return false;
    }
  }
  return true;
}

}  // namespace

uint64_t HashOf(const World& world) {
  std::vector<double> numbers{static_cast<double>(world.dimension)};
  const auto add = [&](const Vector3d& p) { numbers.insert(numbers.end(), p.data(), p.data() + world.dimension); };
  add(world.bounds.min);
  add(world.bounds.max);
  for (const Box& box : world.boxes) {
    add(box.min);
    add(box.max);
  }
  for (const Cylinder& c : world.cylinders) {
    add(c.base);
    numbers.insert(numbers.end(), {c.radius, world.dimension == 3 ? c.height : 0});
  }
  return ContentHash(numbers.data(), numbers.size() * sizeof(double));
}

std::string EncodeRoadmap(const SavedRoadmap& saved) {
  const Roadmap& roadmap = saved.roadmap;
  std::string bytes(kMagic);
  Append(kFormatVersion, &bytes);
  Append(uint64_t{0}, &bytes);  // the body's length, below
  Append(static_cast<int32_t>(saved.kind), &bytes);
  Append(static_cast<int32_t>(roadmap.dimension), &bytes);
  Append(static_cast<int32_t>(roadmap.num_vertices()), &bytes);
  Append(static_cast<int32_t>(roadmap.num_bends), &bytes);
  Append(static_cast<int32_t>(roadmap.taut), &bytes);
  Append(static_cast<int64_t>(roadmap.neighbors.size()), &bytes);
  Append(saved.radius, &bytes);
  Append(saved.world_hash, &bytes);
  Append(saved.samples, &bytes);
  Append(roadmap.positions.data(), roadmap.positions.size(), &bytes);
  Append(roadmap.offsets.data(), roadmap.offsets.size(), &bytes);
  Append(roadmap.neighbors.data(), roadmap.neighbors.size(), &bytes);
  Append(roadmap.lengths.data(), roadmap.lengths.size(), &bytes);
  const uint64_t length = bytes.size() - kHeaderBytes;
  std::memcpy(bytes.data() + kHeaderBytes - sizeof(length), &length, sizeof(length));
  Append(Crc32c(bytes.data(), bytes.size()), &bytes);
  return bytes;
}

SavedRoadmap DecodeRoadmap(std::string_view bytes, const std::string& file) {
  Reader reader(OpenFrame(bytes, file), file);
  SavedRoadmap saved;
  const auto kind = reader.Take<int32_t>();
  const auto dimension = reader.Take<int32_t>(), vertices = reader.Take<int32_t>();
  const auto bends = reader.Take<int32_t>(), taut = reader.Take<int32_t>();
  const auto steps = reader.Take<int64_t>();
  if (kind < 0 || kind > static_cast<int32_t>(PlannerConfig::Kind::kGrid)) reader.Throw("no kind of planner");
  if (dimension < 2 || dimension > 3 || vertices < 1 || steps < 0) reader.Throw("no roadmap's counts");
  if (bends < 0 || bends >= vertices || taut < 0 || taut > 1) reader.Throw("no roadmap's counts");
  saved.kind = static_cast<PlannerConfig::Kind>(kind);
  saved.radius = reader.Take<double>();
  saved.world_hash = reader.Take<uint64_t>();
  saved.samples = reader.Take<int64_t>();
  if (!(saved.radius > 0 && std::isfinite(saved.radius)) || saved.samples < 0) reader.Throw("no roadmap's numbers");
  Roadmap& roadmap = saved.roadmap;
  roadmap.dimension = dimension;
  roadmap.num_bends = bends;
  roadmap.taut = taut == 1;
  reader.TakeArray(static_cast<uint64_t>(vertices) * static_cast<uint64_t>(dimension), &roadmap.positions);
  reader.TakeArray(static_cast<uint64_t>(vertices) + 1, &roadmap.offsets);
  reader.TakeArray(static_cast<uint64_t>(steps), &roadmap.neighbors);
  reader.TakeArray(static_cast<uint64_t>(steps), &roadmap.lengths);
  reader.End();
  if (!FiniteAll(roadmap.positions, -std::numeric_limits<float>::max()) || !FiniteAll(roadmap.lengths, 0)) {
    reader.Throw("a coordinate or length that is none");
  }
  if (!IsGraph(roadmap)) reader.Throw("its edges make no graph");
  return saved;
}

}  // namespace cairn::planner
