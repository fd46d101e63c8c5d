#include "common/nn/gemm.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <tuple>
#include <vector>

#include "common/core/random.h"
#include "common/nn/column_gemm.h"

namespace cairn {
namespace {

template <typename Scalar>
std::vector<Scalar> RandomMatrix(RandomStream* random, int rows, int columns) {
  std::vector<Scalar> x(static_cast<size_t>(rows) * columns);
  for (Scalar& v : x) v = static_cast<Scalar>(random->Normal());
  return x;
}

/// The promised chain: ascending k, one fused multiply-add each.
std::vector<float> Chain(int m, int n, int k, const std::vector<float>& a, const std::vector<float>& b, bool transpose,
                         std::vector<float> c) {
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < m; ++i) {
      float sum = c[i + j * m];
      for (int p = 0; p < k; ++p) sum = std::fmaf(a[i + p * m], transpose ? b[j + p * n] : b[p + j * k], sum);
      c[i + j * m] = sum;
    }
  }
  return c;
}

bool SameBits(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

class GemmBitsTest : public testing::TestWithParam<std::tuple<int, int, bool>> {};

TEST_P(GemmBitsTest, EqualsTheAscendingChainForEveryWidth) {
  const auto [m, k, transpose] = GetParam();
  RandomStream random(1, RandomPurpose::kTest);
  for (int n = 1; n <= 70; ++n) {
    const std::vector<float> a = RandomMatrix<float>(&random, m, k);
    const std::vector<float> b = RandomMatrix<float>(&random, k, n);
    const std::vector<float> start = RandomMatrix<float>(&random, m, n);
    const auto kind = transpose ? Gemm<float>::Transpose::kB : Gemm<float>::Transpose::kNone;
    std::vector<float> c = start;
    Gemm<float>(m, n, k, m, transpose ? n : k, m, kind)(a.data(), b.data(), c.data());
    EXPECT_TRUE(SameBits(c, Chain(m, n, k, a, b, transpose, std::vector<float>(c.size())))) << "n = " << n;
    c = start;
    Gemm<float>(m, n, k, m, transpose ? n : k, m, kind, Accumulate::kAdd)(a.data(), b.data(), c.data());
    EXPECT_TRUE(SameBits(c, Chain(m, n, k, a, b, transpose, start))) << "added, n = " << n;
  }
}

INSTANTIATE_TEST_SUITE_P(Shapes, GemmBitsTest,
                         testing::Combine(testing::Values(1, 2, 4, 6, 13, 16, 17, 33, 64),
                                          testing::Values(1, 3, 27, 64), testing::Bool()));

TEST(GemmTest, RespectsLeadingDimensions) {
  const int m = 5, n = 20, k = 7, lda = 9, ldb = 11, ldc = 6;
  RandomStream random(2, RandomPurpose::kTest);
  const std::vector<double> a = RandomMatrix<double>(&random, lda, k);
  const std::vector<double> b = RandomMatrix<double>(&random, ldb, n);
  std::vector<double> c(static_cast<size_t>(ldc) * n, 7.0);
  Gemm<double>(m, n, k, lda, ldb, ldc)(a.data(), b.data(), c.data());
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < m; ++i) {
      double sum = 0;
      for (int p = 0; p < k; ++p) sum += a[i + p * lda] * b[p + j * ldb];
      EXPECT_NEAR(c[i + j * ldc], sum, 1e-12);
    }
    EXPECT_EQ(c[m + j * ldc], 7.0) << "wrote outside of C";
  }
}

TEST(GemmTest, TargetHasAName) { EXPECT_FALSE(GemmTarget().empty()); }

TEST(ColumnGemmTest, RoundsUpToTheNextWidth) {
  const int m = 4, k = 3;
  RandomStream random(3, RandomPurpose::kTest);
  const std::vector<float> a = RandomMatrix<float>(&random, m, k);
  const std::vector<float> x = RandomMatrix<float>(&random, k, 12);
  const ColumnGemm<float> gemm(m, k, m, k, m, {1, 4, 12});
  for (int n : {0, 1, 2, 4, 5, 12}) {
    std::vector<float> y(m * 12);
    gemm(a.data(), x.data(), n, y.data());
    const std::vector<float> expected = Chain(m, 12, k, a, x, false, std::vector<float>(m * 12));
    EXPECT_EQ(std::memcmp(y.data(), expected.data(), sizeof(float) * m * n), 0) << n;
  }
}

}  // namespace
}  // namespace cairn
