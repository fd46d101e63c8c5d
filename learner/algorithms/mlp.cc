#include "learner/algorithms/mlp.h"

#include <algorithm>
#include <set>

#include "common/core/check.h"
#include "common/nn/layers.h"
#include "learner/algorithms/layer_gradients.h"

namespace cairn::learner {
namespace {

constexpr int kColumnStep = 4;  // InputGradient rounds its number of samples up to a multiple

// Products that follow the samples, and the pass over what they yield, go by blocks of columns: that pass then finds it
// in the first-level cache. The products for weights, which sum over samples, take all columns at once. On Zen 5 blocks
// of 64 are 1 to 2 % faster than those of 32 at width 64; wider layers have chunks of 32 anyway.
constexpr int kBlock = 64;
constexpr int kMaxBlock = kBlock * 3 / 2;

int RoundUp(int n, int step) { return (n + step - 1) / step * step; }

std::vector<int> MultiplesUpTo(int n, int step) {
  std::vector<int> multiples;
  for (int i = step; i <= RoundUp(n, step); i += step) multiples.push_back(i);
  return multiples;
}

/// Calls f(first, how many) for the blocks of n columns, nearly equal ones of about kBlock: a few columns left over
/// would cost nearly as much as a whole block.
template <typename F>
void ForBlocks(int n, F f) {
  const int count = std::max(1, (n + kBlock / 2) / kBlock);
  const int size = RoundUp((n + count - 1) / count, kColumnStep);
  for (int first = 0; first < n; first += size) f(first, std::min(size, n - first));
}

/// The sizes of the blocks of such numbers of columns, ascending.
std::vector<int> BlockSizes(const std::vector<int>& columns) {
  std::set<int> sizes;
  for (int n : columns) ForBlocks(n, [&](int /*first*/, int size) { sizes.insert(size); });
  return {sizes.begin(), sizes.end()};
}

std::vector<MlpLayer> MakeLayers(const MlpShape& shape) {
  std::vector<int> sizes = shape.net_arch;
  sizes.push_back(shape.num_outputs);
  std::vector<MlpLayer> layers;
  size_t position = 0, transposed = 0, narrow_sums = shape.num_parameters();
  int in = shape.num_inputs;
  for (size_t l = 0; l < sizes.size(); ++l) {
    MlpLayer layer;
    layer.in = in;
    layer.out = sizes[l];
    layer.hidden = l + 1 < sizes.size();
    const size_t size = static_cast<size_t>(layer.in) * layer.out;
    const size_t norm = layer.hidden && shape.layer_norm ? layer.out : 0;
    layer.weights = position;
    layer.bias = layer.weights + size;
    layer.gain = layer.bias + layer.out;
    layer.offset = layer.gain + norm;
    position = layer.offset + norm;
    layer.transposed = transposed;
    transposed += size;
    layer.narrow_sums = narrow_sums;
    narrow_sums += layer.narrow() ? size : 0;
    if (layer.out == 1) layer.narrow_sums = layer.weights;
    in = layer.out;
    layers.push_back(layer);
  }
  return layers;
}

}  // namespace

size_t MlpShape::num_parameters() const {
  size_t count = 0;
  size_t in = num_inputs;
  for (int width : net_arch) {
    const auto out = static_cast<size_t>(width);
    count += out * in + out * (layer_norm ? 3 : 1);
    in = out;
  }
  return count + (in + 1) * static_cast<size_t>(num_outputs);
}

int MlpShape::widest_layer() const {
  int widest = num_outputs;
  for (int width : net_arch) widest = std::max(widest, width);
  return widest;
}

template <typename Scalar>
MlpWeights<Scalar>::MlpWeights(const MlpShape& shape) : values(shape.num_parameters()) {
  size_t size = 0;
  for (const MlpLayer& layer : MakeLayers(shape)) size += static_cast<size_t>(layer.in) * layer.out;
  transposed = AlignedBuffer<Scalar>(size);
  for (const MlpLayer& layer : MakeLayers(shape)) {
    if (layer.hidden && shape.layer_norm) std::fill_n(values.data() + layer.gain, layer.out, Scalar{1});
  }
}

template <typename Scalar>
MlpTape<Scalar>::MlpTape(const MlpShape& shape, int max_columns) {
  const int columns = RoundUp(max_columns, kColumnStep);
  for (int width : shape.net_arch) {
    activations.emplace_back(static_cast<size_t>(width) * columns);
    if (shape.layer_norm) normalized.emplace_back(static_cast<size_t>(width) * columns);
    if (shape.layer_norm) inverse_std.emplace_back(static_cast<size_t>(columns));
  }
  output = AlignedBuffer<Scalar>(static_cast<size_t>(shape.num_outputs) * columns);
  for (auto& d : delta) d = AlignedBuffer<Scalar>(static_cast<size_t>(shape.widest_layer()) * columns);
}

template <typename Scalar>
Mlp<Scalar>::Mlp(const MlpShape& shape, int input_stride, const std::vector<int>& columns)
    : shape_(shape),
      input_stride_(input_stride),
      columns_(columns),
      layers_(MakeLayers(shape)),
      gradient_buffer_size_(shape.num_parameters()) {
  CAIRN_CHECK(!shape.net_arch.empty() && shape.num_inputs > 0 && shape.num_outputs > 0);
  CAIRN_CHECK(!columns.empty() && std::is_sorted(columns.begin(), columns.end()));
  for (const MlpLayer& layer : layers_) {
    AddLayer(layer, &layer == &layers_.front() ? input_stride : layer.in);
    if (layer.narrow()) gradient_buffer_size_ += static_cast<size_t>(layer.in) * layer.out;
  }
}

template <typename Scalar>
void Mlp<Scalar>::AddLayer(const MlpLayer& layer, int x_stride) {
  using Transposition = typename Gemm<Scalar>::Transpose;
  const int in = layer.in, out = layer.out;
  Kernels kernels{
      ColumnGemm<Scalar>(out, in, out, x_stride, out, BlockSizes(columns_)),
      ColumnGemm<Scalar>(in, out, in, out, in, MultiplesUpTo(std::min(columns_.back(), kMaxBlock), kColumnStep)),
      {},
      {}};
  const auto weight_gradient = [&](int n, Accumulate accumulate) {
    return layer.narrow() ? Gemm<Scalar>(in, out, n, x_stride, out, in, Transposition::kB, accumulate)
                          : Gemm<Scalar>(out, in, n, out, x_stride, out, Transposition::kB, accumulate);
  };
  for (int n : columns_) {
    kernels.weight_gradient.push_back(weight_gradient(n, Accumulate::kOverwrite));
    kernels.weight_gradient_sum.push_back(weight_gradient(n, Accumulate::kAdd));
  }
  kernels_.push_back(std::move(kernels));
}

template <typename Scalar>
const Scalar* Mlp<Scalar>::Forward(const MlpWeights<Scalar>& weights, const Scalar* x, int n, Keep keep,
                                   MlpTape<Scalar>* tape) const {
  const int last = static_cast<int>(layers_.size()) - 2;
  for (int l = 0; l <= last; ++l) {
    const MlpLayer& layer = layers_[l];
    const int stride = l == 0 ? input_stride_ : layer.in;
    Scalar* h = tape->activations[l].data();
    ForBlocks(n, [&](int first, int columns) {
      kernels_[l].forward(weights.values.data() + layer.weights, x + static_cast<ptrdiff_t>(first) * stride, columns,
                          h + static_cast<ptrdiff_t>(first) * layer.out);
      if (l < last || !fused_head()) Activate(weights, l, first, columns, tape);
      if (l == last) Head(weights, first, columns, keep, tape);
    });
    x = h;
  }
  return tape->output.data();
}

template <typename Scalar>
void Mlp<Scalar>::Activate(const MlpWeights<Scalar>& weights, int l, int first, int columns,
                           MlpTape<Scalar>* tape) const {
  const MlpLayer& layer = layers_[l];
  const Scalar* p = weights.values.data();
  const ptrdiff_t start = static_cast<ptrdiff_t>(first) * layer.out;
  Scalar* h = tape->activations[l].data() + start;
  if (!shape_.layer_norm) {
    cairn::layers::BiasRelu(p + layer.bias, layer.out, columns, h);
    return;
  }
  Scalar* x = tape->normalized[l].data() + start;
  cairn::layers::Normalize(p + layer.bias, layer.out, columns, h, tape->inverse_std[l].data() + first);
  std::copy_n(h, static_cast<size_t>(layer.out) * columns, x);
  cairn::layers::GainRelu(p + layer.gain, p + layer.offset, layer.out, columns, x, h);
}

// The output from the last activations; a fused head computes those too.
template <typename Scalar>
void Mlp<Scalar>::Head(const MlpWeights<Scalar>& weights, int first, int columns, Keep keep,
                       MlpTape<Scalar>* tape) const {
  const MlpLayer& head = layers_.back();
  const Scalar* p = weights.values.data();
  Scalar* x = tape->activations.back().data() + static_cast<ptrdiff_t>(first) * head.in;
  Scalar* y = tape->output.data() + static_cast<ptrdiff_t>(first) * head.out;
  const Scalar* transposed = head.out == 1 ? p + head.weights : weights.transposed.data() + head.transposed;
  if (fused_head()) {
    const Scalar* bias = p + layers_[layers_.size() - 2].bias;
    layers::BiasReluProduct(bias, transposed, p + head.bias, head.in, head.out, columns, keep == Keep::kActivations, x,
                            y);
  } else if (head.narrow()) {
    const Scalar* input = x;
    cairn::layers::NarrowProduct(transposed, p + head.bias, input, head.in, head.out, columns, y);
  } else {
    kernels_.back().forward(p + head.weights, x, columns, y);
    cairn::layers::AddBias(p + head.bias, head.out, columns, y);
  }
}

template <typename Scalar>
void Mlp<Scalar>::Backward(const MlpWeights<Scalar>& weights, const Scalar* x, const Scalar* d_output, int n,
                           Accumulate accumulate, MlpTape<Scalar>* tape, AlignedBuffer<Scalar>* gradient) const {
  CAIRN_DCHECK(gradient->size() == gradient_buffer_size_);
  Scalar* sums = gradient->data();
  if (accumulate == Accumulate::kOverwrite) ZeroVectors(sums);
  const int top = static_cast<int>(layers_.size()) - 1;
  const MlpLayer& head = layers_[top];
  layers::AddColumns(d_output, head.out, n, sums + head.bias);
  const Scalar* delta = d_output;
  for (int l = top; l > 0; --l) {
    Scalar* below = tape->delta[l % 2].data();
    if (l == top && fused_single_head()) {
      layers::DotBackward(weights.values.data() + head.weights, d_output, tape->activations[l - 1].data(), head.in, n,
                          below, sums + layers_[l - 1].bias, sums + head.weights);
    } else {
      WeightGradient(l, delta, tape->activations[l - 1].data(), n, accumulate, sums);
      ForBlocks(n, [&](int first, int columns) {
        kernels_[l].backward(weights.transposed.data() + layers_[l].transposed,
                             delta + static_cast<ptrdiff_t>(first) * layers_[l].out, columns,
                             below + static_cast<ptrdiff_t>(first) * layers_[l].in);
        BackwardActivation(weights, l - 1, first, columns, tape, below, sums);
      });
    }
    delta = below;
  }
  WeightGradient(0, delta, x, n, accumulate, sums);
}

// The parts of the gradient that are only ever added to.
template <typename Scalar>
void Mlp<Scalar>::ZeroVectors(Scalar* gradient) const {
  for (const MlpLayer& layer : layers_) {
    const size_t norm = layer.hidden && shape_.layer_norm ? 2 * layer.out : 0;
    std::fill_n(gradient + layer.bias, layer.out + norm, Scalar{0});
  }
  if (fused_single_head()) std::fill_n(gradient + layers_.back().weights, layers_.back().in, Scalar{0});
}

// delta: derivatives by the layer's activations → by its z = W x + b.
template <typename Scalar>
void Mlp<Scalar>::BackwardActivation(const MlpWeights<Scalar>& weights, int l, int first, int columns,
                                     MlpTape<Scalar>* tape, Scalar* delta, Scalar* gradient) const {
  const MlpLayer& layer = layers_[l];
  const ptrdiff_t start = static_cast<ptrdiff_t>(first) * layer.out;
  const Scalar* h = tape->activations[l].data() + start;
  delta += start;
  if (!shape_.layer_norm) {
    layers::ReluBackward(h, layer.out, columns, delta, gradient + layer.bias);
    return;
  }
  const Scalar* x = tape->normalized[l].data() + start;
  layers::GainReluBackward(weights.values.data() + layer.gain, x, h, layer.out, columns, delta, gradient + layer.gain,
                           gradient + layer.offset);
  for (int j = 0; j < columns; ++j) {
    const ptrdiff_t column = static_cast<ptrdiff_t>(j) * layer.out;
    layers::NormalizeBackward(x + column, tape->inverse_std[l][first + j], layer.out, delta + column);
  }
  layers::AddColumns(delta, layer.out, columns, gradient + layer.bias);
}

template <typename Scalar>
void Mlp<Scalar>::WeightGradient(int l, const Scalar* delta, const Scalar* x, int n, Accumulate accumulate,
                                 Scalar* gradient) const {
  const auto which = std::lower_bound(columns_.begin(), columns_.end(), n) - columns_.begin();
  CAIRN_DCHECK(columns_[which] == n);
  const Kernels& kernels = kernels_[l];
  const auto& products = accumulate == Accumulate::kAdd ? kernels.weight_gradient_sum : kernels.weight_gradient;
  if (layers_[l].narrow()) {
    products[which](x, delta, gradient + layers_[l].narrow_sums);
  } else {
    products[which](delta, x, gradient + layers_[l].weights);
  }
}

template <typename Scalar>
void Mlp<Scalar>::InputGradient(const MlpWeights<Scalar>& weights, std::span<const int> samples, int first, int count,
                                MlpTape<Scalar>* tape, Scalar* d_input) const {
  const int n = static_cast<int>(samples.size());
  const MlpLayer& head = layers_.back();
  const MlpLayer& bottom = layers_.front();
  CAIRN_DCHECK(head.out == 1);
  Scalar* delta = tape->delta[0].data();
  const int top = static_cast<int>(layers_.size()) - 2;
  layers::MaskVector(weights.values.data() + head.weights, tape->activations[top].data(), samples, head.in, delta);
  if (shape_.layer_norm) SampleNormGradient(weights, top, samples, *tape, delta);
  for (int l = top; l > 0; --l) {
    Scalar* below = tape->delta[delta == tape->delta[0].data() ? 1 : 0].data();
    ForBlocks(n, [&](int start, int columns) {
      Scalar* to = below + static_cast<ptrdiff_t>(start) * layers_[l].in;
      const std::span<const int> block = samples.subspan(start, columns);
      kernels_[l].backward(weights.transposed.data() + layers_[l].transposed,
                           delta + static_cast<ptrdiff_t>(start) * layers_[l].out, columns, to);
      layers::MaskSamples(tape->activations[l - 1].data(), block, layers_[l].in, to);
      if (shape_.layer_norm) SampleNormGradient(weights, l - 1, block, *tape, to);
    });
    delta = below;
  }
  // dx_o = Σ_i W[i, o] dz_i, where the columns of W are contiguous.
  const Scalar* w = weights.values.data() + bottom.weights + static_cast<size_t>(first) * bottom.out;
  const Scalar* const no_offsets = nullptr;
  const Scalar* const dz = delta;
  cairn::layers::NarrowProduct(w, no_offsets, dz, bottom.out, count, n, d_input);
}

// LayerNorm's part of BackwardActivation, for chosen samples and without the parameters' derivatives.
template <typename Scalar>
void Mlp<Scalar>::SampleNormGradient(const MlpWeights<Scalar>& weights, int l, std::span<const int> samples,
                                     const MlpTape<Scalar>& tape, Scalar* delta) const {
  const MlpLayer& layer = layers_[l];
  const Scalar* gain = weights.values.data() + layer.gain;
  for (int sample : samples) {
    for (int i = 0; i < layer.out; ++i) delta[i] *= gain[i];
    const Scalar* x = tape.normalized[l].data() + static_cast<size_t>(sample) * layer.out;
    layers::NormalizeBackward(x, tape.inverse_std[l][sample], layer.out, delta);
    delta += layer.out;
  }
}

template <typename Scalar>
void Mlp<Scalar>::FinishGradient(AlignedBuffer<Scalar>* gradient) const {
  for (const MlpLayer& layer : layers_) {
    if (!layer.narrow() || layer.out == 1) continue;  // a single row is its own transpose
    layers::Transpose(gradient->data() + layer.narrow_sums, layer.in, layer.out, gradient->data() + layer.weights);
  }
}

template <typename Scalar>
void Mlp<Scalar>::RefreshTransposed(MlpWeights<Scalar>* weights) const {
  for (size_t l = 1; l < layers_.size(); ++l) RefreshLayer(layers_[l], weights);  // nothing goes back through the first
}

template <typename Scalar>
void Mlp<Scalar>::RefreshHead(MlpWeights<Scalar>* weights) const {
  if (layers_.back().narrow()) RefreshLayer(layers_.back(), weights);
}

template <typename Scalar>
void Mlp<Scalar>::RefreshLayer(const MlpLayer& layer, MlpWeights<Scalar>* weights) const {
  layers::Transpose(weights->values.data() + layer.weights, layer.out, layer.in,
                    weights->transposed.data() + layer.transposed);
}

template struct MlpWeights<float>;
template struct MlpWeights<double>;
template struct MlpTape<float>;
template struct MlpTape<double>;
template class Mlp<float>;
template class Mlp<double>;

}  // namespace cairn::learner
