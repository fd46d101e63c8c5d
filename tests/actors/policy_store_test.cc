#include "actors/policy_store.h"

#include <gtest/gtest.h>

#include "common/core/hash.h"

namespace cairn::actors {
namespace {

constexpr int64_t kIncarnation = 9;

std::vector<float> Parameters(int64_t version) {
  std::vector<float> parameters(10);
  for (size_t i = 0; i < parameters.size(); ++i) parameters[i] = static_cast<float>(version) + 0.1f * i;
  return parameters;
}

PolicyChunk Chunk(int64_t version, int first, int end) {
  const std::vector<float> all = Parameters(version);
  PolicyChunk chunk;
  chunk.incarnation = kIncarnation;
  chunk.version = version;
  chunk.parameters_crc = Crc32c(all.data(), all.size() * sizeof(float));
  chunk.total = 10;
  chunk.offset = first;
  chunk.parameters.assign(all.begin() + first, all.begin() + end);
  return chunk;
}

PolicyStore MakeStore() {
  PolicyStore store(10);
  store.SetIncarnation(kIncarnation);
  return store;
}

TEST(PolicyStoreTest, IsCompleteWhenEveryChunkCameInAnyOrderAndTwice) {
  PolicyStore store = MakeStore();
  EXPECT_FALSE(store.Add(Chunk(3, 6, 10)));
  EXPECT_FALSE(store.Add(Chunk(3, 6, 10)));
  EXPECT_FALSE(store.Add(Chunk(3, 0, 4)));
  EXPECT_EQ(store.Find(3), nullptr);
  EXPECT_EQ(store.newest(), -1);
  EXPECT_TRUE(store.Add(Chunk(3, 3, 7))) << "overlapping";
  ASSERT_NE(store.Find(3), nullptr);
  EXPECT_EQ(*store.Find(3), Parameters(3));
  EXPECT_EQ(store.newest(), 3);
  EXPECT_FALSE(store.Add(Chunk(3, 0, 10))) << "known";
}

TEST(PolicyStoreTest, RefusesForeignOnesWrongSizesAndWrongSums) {
  PolicyStore store = MakeStore();
  PolicyChunk chunk = Chunk(3, 0, 10);
  chunk.incarnation = 8;
  EXPECT_FALSE(store.Add(chunk));
  chunk = Chunk(3, 0, 10);
  chunk.total = 11;
  EXPECT_FALSE(store.Add(chunk));
  chunk = Chunk(3, 0, 10);
  chunk.parameters[2] += 1;
  EXPECT_FALSE(store.Add(chunk));
  EXPECT_EQ(store.Find(3), nullptr);
  EXPECT_TRUE(store.Add(Chunk(3, 0, 10))) << "a damaged one leaves nothing behind";
}

TEST(PolicyStoreTest, ANewIncarnationForgetsEverything) {
  PolicyStore store = MakeStore();
  store.Add(Chunk(3, 0, 10));
  store.SetIncarnation(kIncarnation);
  EXPECT_NE(store.Find(3), nullptr);
  store.SetIncarnation(kIncarnation + 1);
  EXPECT_EQ(store.Find(3), nullptr);
}

TEST(PolicyStoreTest, StaysSmallAndKeepsThePinnedVersion) {
  PolicyStore store = MakeStore();
  store.Pin(1);
  for (int64_t version = 0; version < 50; ++version) store.Add(Chunk(version, 0, 10));
  int kept = 0;
  for (int64_t version = 0; version < 50; ++version) kept += store.Find(version) != nullptr;
  EXPECT_EQ(kept, 6);
  EXPECT_NE(store.Find(1), nullptr);
  EXPECT_NE(store.Find(49), nullptr);
  EXPECT_NE(store.Find(48), nullptr);
  EXPECT_EQ(store.Find(0), nullptr);
}

}  // namespace
}  // namespace cairn::actors
