#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "common/nn/aligned_buffer.h"
#include "common/nn/column_gemm.h"
#include "common/nn/gemm.h"

namespace cairn::learner {

/// Fully connected network: hidden layers with ReLU (LayerNorm before it if asked), linear output.
struct MlpShape {
  int num_inputs = 0;
  std::vector<int> net_arch;
  int num_outputs = 0;
  bool layer_norm = false;

  /// In PolicyShape's order: per layer W column-major [out × in], b [out], in hidden layers with LayerNorm gain and
  /// offset [out].
  size_t num_parameters() const;
  int widest_layer() const;
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

/// What a forward pass of up to max_columns samples leaves for its backward pass. One a thread.
template <typename Scalar>
struct MlpTape {
  MlpTape(const MlpShape& shape, int max_columns);

  std::vector<AlignedBuffer<Scalar>> activations;  ///< per hidden layer: h = ReLU(…), [out × columns]
  std::vector<AlignedBuffer<Scalar>> normalized;   ///< per hidden layer with LayerNorm: (z − mean) / std
  std::vector<AlignedBuffer<Scalar>> inverse_std;  ///< per hidden layer with LayerNorm: 1 / std, [columns]
  AlignedBuffer<Scalar> output;                    ///< [num_outputs × columns]
  AlignedBuffer<Scalar> delta[2];                  ///< gradients on their way down, [widest × columns]
};

/// The arithmetic of one shape of network, for any weights: matrices are column-major, one sample per column.
/// Immutable, so threads and networks of one shape share it.
template <typename Scalar>
class Mlp {
 public:
  /// `input_stride` is the distance between two samples of the input. `columns` are the numbers of samples that passes
  /// will have, ascending. Arrays of samples that come in from outside (d_output) must hold a multiple of 4.
  Mlp(const MlpShape& shape, int input_stride, const std::vector<int>& columns);

  const MlpShape& shape() const { return shape_; }
  const std::vector<MlpLayer>& layers() const { return layers_; }
  int max_columns() const { return columns_.back(); }

  /// f(x) for n samples, [num_outputs × n], which stands in `tape`.
  const Scalar* Forward(const MlpWeights<Scalar>& weights, const Scalar* x, int n, MlpTape<Scalar>* tape) const {
    return Forward(weights, x, n, Keep::kActivations, tape);
  }

  /// The same bits; no Backward or InputGradient may follow.
  const Scalar* Value(const MlpWeights<Scalar>& weights, const Scalar* x, int n, MlpTape<Scalar>* tape) const {
    return Forward(weights, x, n, Keep::kOutput, tape);
  }

  /// Adds to `gradient` (of MakeGradientBuffer) the derivatives of a loss by the parameters; with kOverwrite, for the
  /// first samples of a batch, it starts anew. `d_output` [num_outputs × n] are the derivatives by the outputs of the
  /// last Forward with the same x, n and tape.
  void Backward(const MlpWeights<Scalar>& weights, const Scalar* x, const Scalar* d_output, int n,
                Accumulate accumulate, MlpTape<Scalar>* tape, AlignedBuffer<Scalar>* gradient) const;

  /// Derivatives of the (single) output by inputs [first, first + count) for those samples of the last Forward that
  /// `samples` lists: `d_input` [count × samples.size()].
  void InputGradient(const MlpWeights<Scalar>& weights, std::span<const int> samples, int first, int count,
                     MlpTape<Scalar>* tape, Scalar* d_input) const;

  /// Room for Backward's sums: the gradient in the order of the parameters, then the W of narrow layers transposed.
  AlignedBuffer<Scalar> MakeGradientBuffer() const { return AlignedBuffer<Scalar>(gradient_buffer_size_); }

  /// Completes the gradient after the last Backward of a batch; it is the buffer's first num_parameters() entries.
  void FinishGradient(AlignedBuffer<Scalar>* gradient) const;

  /// Recomputes the transposed copies; call after `weights.values` changed.
  void RefreshTransposed(MlpWeights<Scalar>* weights) const;

  /// The part of RefreshTransposed that Forward needs (a narrow head), for networks without a Backward.
  void RefreshHead(MlpWeights<Scalar>* weights) const;

 private:
  struct Kernels {
    ColumnGemm<Scalar> forward;   // z = W x
    ColumnGemm<Scalar> backward;  // dx = Wᵀ dz
    // dW = dz xᵀ (narrow: dWᵀ = x dzᵀ), one a number of columns; and the same added to dW.
    std::vector<Gemm<Scalar>> weight_gradient, weight_gradient_sum;
  };

  enum class Keep { kActivations, kOutput };

  /// Few outputs without LayerNorm below them: their products share the passes of the last activation.
  bool fused_head() const { return layers_.back().narrow() && !shape_.layer_norm; }
  bool fused_single_head() const { return fused_head() && layers_.back().out == 1; }

  const Scalar* Forward(const MlpWeights<Scalar>& weights, const Scalar* x, int n, Keep keep,
                        MlpTape<Scalar>* tape) const;
  void AddLayer(const MlpLayer& layer, int x_stride);
  // These treat `columns` samples from the chunk's `first` on.
  void Activate(const MlpWeights<Scalar>& weights, int l, int first, int columns, MlpTape<Scalar>* tape) const;
  void Head(const MlpWeights<Scalar>& weights, int first, int columns, Keep keep, MlpTape<Scalar>* tape) const;
  void BackwardActivation(const MlpWeights<Scalar>& weights, int l, int first, int columns, MlpTape<Scalar>* tape,
                          Scalar* delta, Scalar* gradient) const;

  void SampleNormGradient(const MlpWeights<Scalar>& weights, int l, std::span<const int> samples,
                          const MlpTape<Scalar>& tape, Scalar* delta) const;
  void ZeroVectors(Scalar* gradient) const;
  void WeightGradient(int l, const Scalar* delta, const Scalar* x, int n, Accumulate accumulate,
                      Scalar* gradient) const;

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
