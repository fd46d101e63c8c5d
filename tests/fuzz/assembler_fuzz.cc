// Chunks of tables, states and policies in any order and with any sizes, as decoded messages may have them.
#include <fuzzer/FuzzedDataProvider.h>

#include <cstdint>
#include <cstdlib>

#include "actors/policy_store.h"
#include "common/bus/blob_assembler.h"
#include "common/bus/state_assembler.h"

namespace {

using cairn::Bytes;

cairn::TableChunk MakeTableChunk(FuzzedDataProvider* input, uint64_t hash) {
  cairn::TableChunk chunk;
  chunk.hash = hash;
  chunk.total_bytes = input->ConsumeIntegralInRange<int32_t>(-1, 300);
  chunk.chunk_bytes = input->ConsumeIntegralInRange<int32_t>(1, 100);
  chunk.chunk = input->ConsumeIntegralInRange<int32_t>(0, 20);
  chunk.data = input->ConsumeBytes<uint8_t>(input->ConsumeIntegralInRange<size_t>(0, 100));
  return chunk;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  FuzzedDataProvider input(data, size);
  const Bytes blob(64, 5);
  const uint64_t hash = cairn::ContentHash(blob.data(), blob.size());
  cairn::BlobAssembler blobs(hash);
  cairn::StateAssembler states;
  cairn::actors::PolicyStore policies(16);
  policies.SetIncarnation(1);
  while (input.remaining_bytes() > 0) {
    switch (input.ConsumeIntegralInRange<int>(0, 3)) {
      case 0:
        blobs.Add(MakeTableChunk(&input, hash));
        if (blobs.complete() && blobs.bytes() != blob) std::abort();
        break;
      case 1: {
        cairn::VehicleStatePiece piece;
        piece.vehicle = input.ConsumeIntegralInRange<int32_t>(-1, 3);
        piece.steps = input.ConsumeIntegralInRange<int64_t>(0, 2);
        piece.total = input.ConsumeIntegralInRange<int32_t>(-1, 40);
        piece.offset = input.ConsumeIntegralInRange<int32_t>(-1, 40);
        piece.data = input.ConsumeBytes<uint8_t>(input.ConsumeIntegralInRange<size_t>(0, 40));
        states.Add(piece);
        states.Find(piece.vehicle, piece.steps);
        break;
      }
      case 2: {
        cairn::PolicyChunk chunk;
        chunk.incarnation = input.ConsumeIntegralInRange<int64_t>(0, 2);
        chunk.version = input.ConsumeIntegralInRange<int64_t>(0, 9);
        chunk.total = input.ConsumeIntegralInRange<int32_t>(15, 17);
        chunk.parameters.assign(input.ConsumeIntegralInRange<size_t>(0, 16), 0.5f);
        // The codec has made sure of this much.
        chunk.offset = input.ConsumeIntegralInRange<int32_t>(0, 16 - static_cast<int32_t>(chunk.parameters.size()));
        chunk.parameters_crc = input.ConsumeIntegral<uint32_t>();
        policies.Add(chunk);
        policies.Find(chunk.version);
        break;
      }
      default:
        policies.SetIncarnation(input.ConsumeIntegralInRange<int64_t>(1, 2));
    }
  }
  return 0;
}
