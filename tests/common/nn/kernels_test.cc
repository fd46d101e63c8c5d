#include "common/nn/kernels.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "common/core/random.h"

namespace cairn::kernels {
namespace {

std::vector<float> Normals(int count, uint32_t index) {
  RandomStream random(13, RandomPurpose::kTest, index);
  std::vector<float> x(count);
  for (float& v : x) v = static_cast<float>(random.Normal());
  return x;
}

/// All results of one table for one shape, one after the other.
std::vector<float> Results(const Table& table, int rows, int columns, int outs) {
  const int size = rows * columns;
  const std::vector<float> bias = Normals(rows, 1), w = Normals(rows * outs, 2), offsets = Normals(outs, 3);
  const std::vector<float> e = Normals(columns, 4), h = Normals(size, 5);
  std::vector<int> samples;
  for (int j = columns - 1; j >= 0; j -= 2) samples.push_back(j);
  const int chosen = static_cast<int>(samples.size());

  std::vector<float> all;
  const auto keep = [&all](const std::vector<float>& values) { all.insert(all.end(), values.begin(), values.end()); };
  std::vector<float> z = Normals(size, 6), d = Normals(size, 7), sums = Normals(rows, 8), slope = sums;
  table.bias_relu(bias.data(), rows, columns, z.data());
  keep(z);
  std::vector<float> products(outs * columns);
  for (bool keeps : {true, false}) {
    z = Normals(size, 6);
    table.bias_relu_product(bias.data(), w.data(), offsets.data(), rows, outs, columns, keeps, z.data(),
                            products.data());
    if (keeps) keep(z);
    keep(products);
  }
  table.narrow_product(w.data(), offsets.data(), h.data(), rows, outs, columns, products.data());
  keep(products);
  table.narrow_product(w.data(), nullptr, h.data(), rows, outs, columns, products.data());
  keep(products);
  table.relu_backward(h.data(), rows, columns, d.data(), sums.data());
  keep(d);
  keep(sums);
  table.dot_backward(w.data(), e.data(), h.data(), rows, columns, d.data(), sums.data(), slope.data());
  keep(d);
  keep(sums);
  keep(slope);
  d = Normals(size, 7);
  table.mask_samples(h.data(), samples.data(), rows, chosen, d.data());
  keep(d);
  table.mask_vector(w.data(), h.data(), samples.data(), rows, chosen, d.data());
  keep(d);
  table.transpose(h.data(), rows, columns, d.data());
  keep(d);
  return all;
}

TEST(KernelsTest, SameBitsForEveryInstructionSet) {
  for (int rows : {1, 7, 15, 16, 17, 32, 48, 64, 70, 130, 256}) {
    for (int columns : {1, 2, 3, 4, 5, 8, 31, 64}) {
      for (int outs : {1, 2, 3, 6, 8}) {
        const std::vector<float> base = Results(Base(), rows, columns, outs),
                                 best = Results(Best(), rows, columns, outs);
        ASSERT_EQ(std::memcmp(base.data(), best.data(), base.size() * sizeof(float)), 0)
            << rows << " " << columns << " " << outs;
      }
    }
  }
}

class KernelsReferenceTest : public testing::TestWithParam<std::tuple<int, int>> {
 protected:
  const int rows_ = std::get<0>(GetParam()), columns_ = std::get<1>(GetParam());
  const std::vector<float> bias_ = Normals(rows_, 1), w_ = Normals(rows_ * 3, 2), h_ = Normals(rows_ * columns_, 5);
};

TEST_P(KernelsReferenceTest, ForwardPasses) {
  for (int outs : {1, 3}) {
    std::vector<float> z = Normals(rows_ * columns_, 6), y(outs * columns_), products(outs * columns_);
    const std::vector<float> before = z;
    Best().bias_relu_product(bias_.data(), w_.data(), bias_.data(), rows_, outs, columns_, true, z.data(), y.data());
    Best().narrow_product(w_.data(), bias_.data(), h_.data(), rows_, outs, columns_, products.data());
    for (int j = 0; j < columns_; ++j) {
      for (int i = 0; i < rows_; ++i) {
        ASSERT_EQ(z[j * rows_ + i], std::max(0.0f, before[j * rows_ + i] + bias_[i]));
      }
      for (int o = 0; o < outs; ++o) {
        double activated = bias_[o], product = bias_[o];
        for (int i = 0; i < rows_; ++i) {
          activated += static_cast<double>(w_[o * rows_ + i]) * z[j * rows_ + i];
          product += static_cast<double>(w_[o * rows_ + i]) * h_[j * rows_ + i];
        }
        EXPECT_NEAR(y[j * outs + o], activated, 1e-5 * rows_);
        EXPECT_NEAR(products[j * outs + o], product, 1e-5 * rows_);
      }
    }
  }
}

TEST_P(KernelsReferenceTest, BackwardPasses) {
  const std::vector<float> e = Normals(columns_, 4), before = Normals(rows_ * columns_, 7);
  std::vector<float> relu = before, dot(relu.size()), relu_sums(rows_, 1.0f), dot_sums(rows_, 2.0f), slope(rows_, 3.0f);
  Best().relu_backward(h_.data(), rows_, columns_, relu.data(), relu_sums.data());
  Best().dot_backward(w_.data(), e.data(), h_.data(), rows_, columns_, dot.data(), dot_sums.data(), slope.data());
  for (int i = 0; i < rows_; ++i) {
    float relu_sum = 1.0f, dot_sum = 2.0f, w_slope = 3.0f;
    for (int j = 0; j < columns_; ++j) {
      const int at = j * rows_ + i;
      ASSERT_EQ(relu[at], h_[at] > 0 ? before[at] : 0.0f);
      ASSERT_EQ(dot[at], h_[at] > 0 ? w_[i] * e[j] : 0.0f);
      relu_sum += relu[at];
      dot_sum += dot[at];
      w_slope = std::fmaf(e[j], h_[at], w_slope);
    }
    EXPECT_EQ(relu_sums[i], relu_sum);
    EXPECT_EQ(dot_sums[i], dot_sum);
    EXPECT_EQ(slope[i], w_slope);
  }
}

TEST_P(KernelsReferenceTest, SampleMasksAndTranspose) {
  const std::vector<int> samples{columns_ - 1, 0};
  std::vector<float> d = Normals(2 * rows_, 7), transposed(rows_ * columns_);
  const std::vector<float> before = d;
  Best().mask_samples(h_.data(), samples.data(), rows_, 2, d.data());
  for (int p = 0; p < 2; ++p) {
    for (int i = 0; i < rows_; ++i) {
      ASSERT_EQ(d[p * rows_ + i], h_[samples[p] * rows_ + i] > 0 ? before[p * rows_ + i] : 0.0f);
    }
  }
  Best().mask_vector(w_.data(), h_.data(), samples.data(), rows_, 2, d.data());
  for (int p = 0; p < 2; ++p) {
    for (int i = 0; i < rows_; ++i) {
      ASSERT_EQ(d[p * rows_ + i], h_[samples[p] * rows_ + i] > 0 ? w_[i] : 0.0f);
    }
  }
  Best().transpose(h_.data(), rows_, columns_, transposed.data());
  for (int j = 0; j < columns_; ++j) {
    for (int i = 0; i < rows_; ++i) ASSERT_EQ(transposed[i * columns_ + j], h_[j * rows_ + i]);
  }
}

INSTANTIATE_TEST_SUITE_P(Shapes, KernelsReferenceTest,
                         testing::Combine(testing::Values(3, 16, 29, 64, 100), testing::Values(1, 6, 33)));

TEST(KernelsTest, NonFiniteActivationsStayVisible) {
  for (const Table* table : {&Base(), &Best()}) {
    std::vector<float> z(20, std::numeric_limits<float>::quiet_NaN());
    const std::vector<float> bias(20);
    table->bias_relu(bias.data(), 20, 1, z.data());
    for (float v : z) EXPECT_TRUE(std::isnan(v)) << table->name;
  }
}

}  // namespace
}  // namespace cairn::kernels
