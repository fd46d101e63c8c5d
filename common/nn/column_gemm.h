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
    for (int width : widths) kernels_.resize(static_cast<size_t>(width) + 1, Gemm<Scalar>(m, width, k, lda, ldb, ldc));
  }

  void operator()(const Scalar* a, const Scalar* x, int columns, Scalar* y) const {
    CAIRN_DCHECK(columns >= 0 && columns < static_cast<int>(kernels_.size()));
    if (columns > 0) kernels_[columns](a, x, y);
  }

 private:
  std::vector<Gemm<Scalar>> kernels_;  // by number of columns
};

}  // namespace cairn
