#pragma once

#include <vector>

#include "common/core/check.h"
#include "common/nn/gemm.h"

namespace cairn {

/// Y = A X for a varying number of columns: one Gemm a width in `widths` (ascending, the last one is the most). A
/// number in between is rounded up to the next width, so X and Y must then hold that many columns; what the additional
/// columns of Y get is of no meaning.
template <typename Scalar>
class ColumnGemm {
 public:
  ColumnGemm(int m, int k, int lda, int ldb, int ldc, const std::vector<int>& widths) {
    CAIRN_CHECK(!widths.empty());
    index_.resize(static_cast<size_t>(widths.back()) + 1);
    for (int n = 0, w = 0; n <= widths.back(); ++n) {
      if (n > widths[w]) ++w;
      index_[n] = w;
    }
    for (int width : widths) kernels_.emplace_back(m, width, k, lda, ldb, ldc);
  }

  void operator()(const Scalar* a, const Scalar* x, int columns, Scalar* y) const {
    CAIRN_DCHECK(columns >= 0 && columns < static_cast<int>(index_.size()));
    if (columns > 0) kernels_[index_[columns]](a, x, y);
  }

 private:
  std::vector<Gemm<Scalar>> kernels_;
  std::vector<int> index_;  // number of columns → kernel
};

}  // namespace cairn
