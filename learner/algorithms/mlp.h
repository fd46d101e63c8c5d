#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "common/nn/aligned_buffer.h"
#include "common/nn/column_gemm.h"
#include "common/nn/gemm.h"

namespace cairn::learner {

/// Products take a multiple of so many columns, so arrays of samples have room for one.
inline constexpr int kColumnStep = 4;

/// Fully connected network: hidden layers with ReLU (LayerNorm before it if asked), linear output.
struct MlpShape {
  int num_inputs = 0;
  std::vector<int> net_arch;
  int num_outputs = 0;
  bool layer_norm = false;

  /// In PolicyShape's order: per layer W column-major [out × in], b [out], in hidden layers with LayerNorm gain and
  /// offset [out].
  size_t num_parameters() const;
};

/// One layer of a network and where its parameters stand in the flat vector.
struct MlpLayer {
  int in = 0;
  int out = 0;
  bool hidden = false;
  size_t weights = 0;
  size_t bias = 0;
  size_t gain = 0;
  size_t offset = 0;
  size_t transposed = 0;   ///< of Wᵀ [in × out] in MlpWeights::transposed
  size_t narrow_sums = 0;  ///< of the sums for Wᵀ [in × out] in a gradient buffer, if narrow

  /// Too few outputs for a product that is vectorised over them: Wᵀ is used instead of W.
  bool narrow() const { return out < 16; }
};

/// The parameters of one network and, for back-propagation, a transposed copy of each W.
template <typename Scalar>
struct MlpWeights {
  explicit MlpWeights(const MlpShape& shape);

  AlignedBuffer<Scalar> values;
  AlignedBuffer<Scalar> transposed;
};

/// What the passes of up to max_columns samples leave for each other. One a thread.
template <typename Scalar>
struct MlpTape {
  MlpTape(const MlpShape& shape, int max_columns);

  std::vector<AlignedBuffer<Scalar>> activations;  ///< per hidden layer: h = ReLU(…), [out × columns]
  std::vector<AlignedBuffer<Scalar>> normalized;   ///< per hidden layer with LayerNorm: (z − mean) / std
  std::vector<AlignedBuffer<Scalar>> inverse_std;  ///< per hidden layer with LayerNorm: 1 / std, [columns]
  AlignedBuffer<Scalar> output;                    ///< [num_outputs × columns]
  std::vector<AlignedBuffer<Scalar>> deltas;  ///< per layer: derivatives of the loss by z = W x + b, [out × columns]
};

/// The arithmetic of one shape of network, for any weights: matrices are column-major, one sample per column.
/// Immutable, so threads and networks of one shape share it.
template <typename Scalar>
class Mlp {
 public:
  /// `input_stride` is the distance between two samples of the input. `columns` are the numbers of samples that passes
  /// will have, ascending.
  Mlp(const MlpShape& shape, int input_stride, const std::vector<int>& columns);

  const MlpShape& shape() const { return shape_; }
  const std::vector<MlpLayer>& layers() const { return layers_; }
  int max_columns() const { return columns_.back(); }

  /// f(x) for n samples, [num_outputs × n], which stands in `tape`; InputGradient may follow.
  const Scalar* Forward(const MlpWeights<Scalar>& weights, const Scalar* x, int n, MlpTape<Scalar>* tape) const;

  /// The same bits; no InputGradient may follow.
  const Scalar* Value(const MlpWeights<Scalar>& weights, const Scalar* x, int n, MlpTape<Scalar>* tape) const;

  /// Adds to `gradient` (of MakeGradientBuffer) the derivatives by the parameters of a loss over n samples; with
  /// kOverwrite, for the first samples of a batch, it starts anew. Goes forward and back with one block of samples
  /// after the other; for each, differentiate(first, count, y, d_y) gets the outputs y [num_outputs × count] of the
  /// samples from `first` on and writes the loss's derivatives by them to d_y, laid out like y. Afterwards tape->output
  /// holds all outputs.
  template <typename Differentiate>
  void LossGradient(const MlpWeights<Scalar>& weights, const Scalar* x, int n, Accumulate accumulate,
                    MlpTape<Scalar>* tape, AlignedBuffer<Scalar>* gradient, Differentiate differentiate) const {
    StartGradient(accumulate, gradient);
    ForBlocks(n, [&](int first, int count) {
      ForwardBlock(weights, x, first, count, Keep::kActivations, tape);
      const ptrdiff_t start = static_cast<ptrdiff_t>(first) * shape_.num_outputs;
      differentiate(first, count, tape->output.data() + start, tape->deltas.back().data() + start);
      BackwardBlock(weights, first, count, tape, gradient);
    });
    AddWeightGradients(x, n, accumulate, *tape, gradient);
  }

  /// Derivatives of the (single) output by inputs [first, first + count) for those samples of the last Forward that
  /// `samples` lists: `d_input` [count × samples.size()].
  void InputGradient(const MlpWeights<Scalar>& weights, std::span<const int> samples, int first, int count,
                     MlpTape<Scalar>* tape, Scalar* d_input) const;

  /// Room for LossGradient's sums: the gradient in the order of the parameters, then the W of narrow layers transposed.
  AlignedBuffer<Scalar> MakeGradientBuffer() const { return AlignedBuffer<Scalar>(gradient_buffer_size_); }

  /// Completes the gradient after the last LossGradient of a batch; it is the buffer's first num_parameters() entries.
  void FinishGradient(AlignedBuffer<Scalar>* gradient) const;

  /// Recomputes the transposed copies; call after `weights.values` changed.
  void RefreshTransposed(MlpWeights<Scalar>* weights) const;

  /// The part of RefreshTransposed that Forward needs (a narrow head), for networks without a gradient.
  void RefreshHead(MlpWeights<Scalar>* weights) const;

 private:
  struct Kernels {
    ColumnGemm<Scalar> forward;   // z = W x
    ColumnGemm<Scalar> backward;  // dx = Wᵀ dz
    // dW = dz xᵀ (narrow: dWᵀ = x dzᵀ), one a number of columns; and the same added to dW.
    std::vector<Gemm<Scalar>> weight_gradient, weight_gradient_sum;
  };

  enum class Keep { kActivations, kOutput };

  // All passes go by blocks of columns, so that each finds in the first-level cache what the one before it has left
  // there. Only the products for weights, which sum over samples, take all columns at once. On Zen 5 blocks of 64 are 1
  // to 2 % faster than those of 32 at width 64.
  static constexpr int kBlock = 64;

  /// Calls f(first, how many) for the blocks of n columns, nearly equal ones of about kBlock: a few columns left over
  /// would cost nearly as much as a whole block.
  template <typename F>
  static void ForBlocks(int n, F f) {
    const int count = std::max(1, (n + kBlock / 2) / kBlock);
    const int size = (n + count * kColumnStep - 1) / (count * kColumnStep) * kColumnStep;
    for (int first = 0; first < n; first += size) f(first, std::min(size, n - first));
  }
  static std::vector<int> BlockSizes(const std::vector<int>& columns);

  /// Few outputs without LayerNorm below them: their products share the passes of the last activation.
  bool fused_head() const { return layers_.back().narrow() && !shape_.layer_norm; }
  bool fused_single_head() const { return fused_head() && layers_.back().out == 1; }

  void AddLayer(const MlpLayer& layer, int x_stride);
  // These treat `count` columns of the tape from `first` on; x is the input of the tape's first column.
  void ForwardBlock(const MlpWeights<Scalar>& weights, const Scalar* x, int first, int count, Keep keep,
                    MlpTape<Scalar>* tape) const;
  void Activate(const MlpWeights<Scalar>& weights, int l, int first, int count, MlpTape<Scalar>* tape) const;
  void Head(const MlpWeights<Scalar>& weights, int first, int count, Keep keep, MlpTape<Scalar>* tape, Scalar* y) const;
  void BackwardBlock(const MlpWeights<Scalar>& weights, int first, int count, MlpTape<Scalar>* tape,
                     AlignedBuffer<Scalar>* gradient) const;
  void BackwardActivation(const MlpWeights<Scalar>& weights, int l, int first, int count, MlpTape<Scalar>* tape,
                          Scalar* gradient) const;

  void SampleNormGradient(const MlpWeights<Scalar>& weights, int l, std::span<const int> samples,
                          const MlpTape<Scalar>& tape, Scalar* delta) const;
  void StartGradient(Accumulate accumulate, AlignedBuffer<Scalar>* gradient) const;
  void AddHeadBiasGradient(int n, const MlpTape<Scalar>& tape, AlignedBuffer<Scalar>* gradient) const;
  void AddWeightGradients(const Scalar* x, int n, Accumulate accumulate, const MlpTape<Scalar>& tape,
                          AlignedBuffer<Scalar>* gradient) const;

  void RefreshLayer(const MlpLayer& layer, MlpWeights<Scalar>* weights) const;

  MlpShape shape_;
  int input_stride_;
  std::vector<int> columns_;
  std::vector<MlpLayer> layers_;
  std::vector<Kernels> kernels_;
  size_t gradient_buffer_size_;
};

extern template struct MlpWeights<float>;
extern template struct MlpWeights<double>;
extern template struct MlpTape<float>;
extern template struct MlpTape<double>;
extern template class Mlp<float>;
extern template class Mlp<double>;

}  // namespace cairn::learner
