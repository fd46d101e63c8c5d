#pragma once

#include <cstddef>
#include <cstdint>

namespace cairn {

/// CRC32C (Castagnoli) of `size` bytes, continuing from `crc` (0 to start). Hardware instruction where there is one.
uint32_t Crc32c(const void* data, size_t size, uint32_t crc = 0);

/// 64-bit content hash (XXH3), for naming roadmaps, tables and experiments; never 0, so that 0 can mean "none".
uint64_t ContentHash(const void* data, size_t size, uint64_t seed = 0);

/// A random non-zero 63-bit id from the operating system: run ids, session ids, incarnations.
int64_t RandomId();

}  // namespace cairn
