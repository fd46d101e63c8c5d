#include "learner/algorithms/batch_random.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

namespace cairn::learner {
namespace {

using Purpose = BatchRandom::Purpose;

// Philox4x32-10 one block at a time, as Salmon et al. publish it; their known answers check this reference.
std::array<uint32_t, 4> Philox(std::array<uint32_t, 4> c, std::array<uint32_t, 2> k) {
  for (int round = 0; round < 10; ++round) {
    const uint64_t p0 = uint64_t{0xD2511F53u} * c[0], p1 = uint64_t{0xCD9E8D57u} * c[2];
    c = {static_cast<uint32_t>(p1 >> 32) ^ c[1] ^ k[0], static_cast<uint32_t>(p1),
         static_cast<uint32_t>(p0 >> 32) ^ c[3] ^ k[1], static_cast<uint32_t>(p0)};
    k[0] += 0x9E3779B9u;
    k[1] += 0xBB67AE85u;
  }
  return c;
}

TEST(BatchRandomTest, IsPhilox) {
  const std::array<uint32_t, 4> known{0x6627E8D5, 0xE169C58D, 0xBC57AC4C, 0x9B00DBD8};
  ASSERT_EQ(Philox({0, 0, 0, 0}, {0, 0}), known);
  const std::array<uint32_t, 2> key{0x12345678, 0x9ABCDEF0};
  const int64_t draw = 0x500000007;
  std::vector<uint32_t> bits(200);
  BatchRandom(key).Bits(Purpose::kNoise, draw, 200, bits.data());
  for (uint32_t i = 0; i < 200; ++i) {
    const uint32_t counter = i / 64 * 16 + i % 16;  // 16 counters side by side, their first words first
    EXPECT_EQ(bits[i], Philox({counter, 2, 7, 5}, key)[i / 16 % 4]) << i;
  }
}

TEST(BatchRandomTest, DoesNotDependOnWhichAreDrawn) {
  const BatchRandom random(uint64_t{5});
  std::vector<float> all(1000);
  random.Normals(Purpose::kNoise, 3, 0, 1000, all.data());
  for (int first : {0, 1, 63, 64, 129}) {
    for (int n : {1, 15, 63, 64, 65, 777}) {
      std::vector<float> part(n);
      random.Normals(Purpose::kNoise, 3, first, n, part.data());
      EXPECT_EQ(std::memcmp(part.data(), all.data() + first, n * sizeof(float)), 0) << first << ", " << n;
    }
  }
}

TEST(BatchRandomTest, SeedsPurposesAndDrawsDiffer) {
  const auto first = [](uint64_t seed, Purpose purpose, int64_t draw) {
    uint32_t bits;
    BatchRandom(seed).Bits(purpose, draw, 1, &bits);
    return bits;
  };
  const uint32_t base = first(1, Purpose::kNoise, 0);
  EXPECT_EQ(first(1, Purpose::kNoise, 0), base);
  EXPECT_NE(first(2, Purpose::kNoise, 0), base);
  EXPECT_NE(first(1, Purpose::kNextNoise, 0), base);
  EXPECT_NE(first(1, Purpose::kNoise, 1), base);
  EXPECT_NE(first(1, Purpose::kNoise, int64_t{1} << 32), base);
}

TEST(BatchRandomTest, NormalsHaveTheNormalsMomentsAndTails) {
  const int n = 1 << 20;
  std::vector<float> x(n);
  BatchRandom(uint64_t{9}).Normals(Purpose::kNoise, 0, 0, n, x.data());
  double sum = 0, squares = 0, fourth = 0, neighbours = 0;
  int beyond_two = 0;
  for (int i = 0; i < n; ++i) {
    sum += x[i];
    squares += x[i] * x[i];
    fourth += std::pow(x[i], 4);
    neighbours += x[i] * x[(i + 16) % n];  // cosine and sine of the same pair stand 16 apart
    beyond_two += std::fabs(x[i]) > 2 ? 1 : 0;
  }
  EXPECT_NEAR(sum / n, 0.0, 0.004);
  EXPECT_NEAR(squares / n, 1.0, 0.006);
  EXPECT_NEAR(fourth / n, 3.0, 0.05);
  EXPECT_NEAR(neighbours / n, 0.0, 0.004);
  EXPECT_NEAR(static_cast<double>(beyond_two) / n, 0.0455, 0.001);
  EXPECT_GT(*std::max_element(x.begin(), x.end()), 4.0f);
}

TEST(BatchRandomTest, BelowIsUniform) {
  const int n = 100000;
  std::vector<uint32_t> x(n);
  BatchRandom(uint64_t{9}).Below(Purpose::kReplayRows, 0, 10, n, x.data());
  std::vector<int> count(10);
  for (uint32_t v : x) ++count.at(v);
  for (int c : count) EXPECT_NEAR(c, n / 10, 400);
}

}  // namespace
}  // namespace cairn::learner
