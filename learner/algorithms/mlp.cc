#include "learner/algorithms/mlp.h"

#include <algorithm>
#include <set>

#include "common/core/check.h"
#include "common/nn/layers.h"
#include "learner/algorithms/layer_gradients.h"

namespace cairn::learner {
namespace {

int RoundUp(int n, int step) { return (n + step - 1) / step * step; }

std::vector<int> MultiplesUpTo(int n, int step) {
  std::vector<int> multiples;
  for (int i = step; i <= RoundUp(n, step); i += step) multiples.push_back(i);
  return multiples;
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
  for (const MlpLayer& layer : MakeLayers(shape)) deltas.emplace_back(static_cast<size_t>(layer.out) * columns);
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

// The sizes of the blocks of such numbers of columns, ascending.
template <typename Scalar>
std::vector<int> Mlp<Scalar>::BlockSizes(const std::vector<int>& columns) {
  std::set<int> sizes;
  for (int n : columns) ForBlocks(n, [&](int /*first*/, int size) { sizes.insert(size); });
  return {sizes.begin(), sizes.end()};
}

template <typename Scalar>
void Mlp<Scalar>::AddLayer(const MlpLayer& layer, int x_stride) {
  using Transposition = typename Gemm<Scalar>::Transpose;
  const int in = layer.in, out = layer.out;
  Kernels kernels{
      ColumnGemm<Scalar>(out, in, out, x_stride, out, BlockSizes(columns_)),
      ColumnGemm<Scalar>(in, out, in, out, in, MultiplesUpTo(std::min(columns_.back(), kBlock * 3 / 2), kColumnStep)),
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
const Scalar* Mlp<Scalar>::Forward(const MlpWeights<Scalar>& weights, const Scalar* x, int n,
                                   MlpTape<Scalar>* tape) const {
  ForBlocks(n, [&](int first, int count) { ForwardBlock(weights, x, first, count, Keep::kActivations, tape); });
  return tape->output.data();
}

template <typename Scalar>
const Scalar* Mlp<Scalar>::Value(const MlpWeights<Scalar>& weights, const Scalar* x, int n,
                                 MlpTape<Scalar>* tape) const {
  ForBlocks(n, [&](int first, int count) { ForwardBlock(weights, x, first, count, Keep::kOutput, tape); });
  return tape->output.data();
}

template <typename Scalar>
void Mlp<Scalar>::ForwardBlock(const MlpWeights<Scalar>& weights, const Scalar* x, int first, int count, Keep keep,
                               MlpTape<Scalar>* tape) const {
  const int last = static_cast<int>(layers_.size()) - 2;
  const int start = keep == Keep::kActivations ? first : 0;  // what is not kept has its place in the cache already
  x += static_cast<ptrdiff_t>(first) * input_stride_;
  for (int l = 0; l <= last; ++l) {
    Scalar* h = tape->activations[l].data() + static_cast<ptrdiff_t>(start) * layers_[l].out;
    kernels_[l].forward(weights.values.data() + layers_[l].weights, x, count, h);
    if (l < last || !fused_head()) Activate(weights, l, start, count, tape);
    x = h;
  }
  Head(weights, start, count, keep, tape, tape->output.data() + static_cast<ptrdiff_t>(first) * shape_.num_outputs);
}

template <typename Scalar>
void Mlp<Scalar>::Activate(const MlpWeights<Scalar>& weights, int l, int first, int count,
                           MlpTape<Scalar>* tape) const {
  const MlpLayer& layer = layers_[l];
  const Scalar* p = weights.values.data();
  const ptrdiff_t start = static_cast<ptrdiff_t>(first) * layer.out;
  Scalar* h = tape->activations[l].data() + start;
  if (!shape_.layer_norm) {
    cairn::layers::BiasRelu(p + layer.bias, layer.out, count, h);
    return;
  }
  Scalar* x = tape->normalized[l].data() + start;
  cairn::layers::Normalize(p + layer.bias, layer.out, count, h, tape->inverse_std[l].data() + first);
  std::copy_n(h, static_cast<size_t>(layer.out) * count, x);
  cairn::layers::GainRelu(p + layer.gain, p + layer.offset, layer.out, count, x, h);
}

// The output from the last activations; a fused head computes those too.
template <typename Scalar>
void Mlp<Scalar>::Head(const MlpWeights<Scalar>& weights, int first, int count, Keep keep, MlpTape<Scalar>* tape,
                       Scalar* y) const {
  const MlpLayer& head = layers_.back();
  const Scalar* p = weights.values.data();
  Scalar* x = tape->activations.back().data() + static_cast<ptrdiff_t>(first) * head.in;
  const Scalar* transposed = head.out == 1 ? p + head.weights : weights.transposed.data() + head.transposed;
  if (fused_head()) {
    const Scalar* bias = p + layers_[layers_.size() - 2].bias;
    layers::BiasReluProduct(bias, transposed, p + head.bias, head.in, head.out, count, keep == Keep::kActivations, x,
                            y);
  } else if (head.narrow()) {
    const Scalar* input = x;
    cairn::layers::NarrowProduct(transposed, p + head.bias, input, head.in, head.out, count, y);
  } else {
    kernels_.back().forward(p + head.weights, x, count, y);
    cairn::layers::AddBias(p + head.bias, head.out, count, y);
  }
}

// The parts of the gradient that are only ever added to start at 0.
template <typename Scalar>
void Mlp<Scalar>::StartGradient(Accumulate accumulate, AlignedBuffer<Scalar>* gradient) const {
  CAIRN_DCHECK(gradient->size() == gradient_buffer_size_);
  if (accumulate == Accumulate::kAdd) return;
  for (const MlpLayer& layer : layers_) {
    const size_t norm = layer.hidden && shape_.layer_norm ? 2 * layer.out : 0;
    std::fill_n(gradient->data() + layer.bias, layer.out + norm, Scalar{0});
  }
  if (fused_single_head()) std::fill_n(gradient->data() + layers_.back().weights, layers_.back().in, Scalar{0});
}

// The deltas of all layers but the last, whose are there, and the sums that go with them.
template <typename Scalar>
void Mlp<Scalar>::BackwardBlock(const MlpWeights<Scalar>& weights, int first, int count, MlpTape<Scalar>* tape,
                                AlignedBuffer<Scalar>* gradient) const {
  Scalar* sums = gradient->data();
  const int top = static_cast<int>(layers_.size()) - 1;
  for (int l = top; l > 0; --l) {
    const MlpLayer& layer = layers_[l];
    const Scalar* delta = tape->deltas[l].data() + static_cast<ptrdiff_t>(first) * layer.out;
    const ptrdiff_t start = static_cast<ptrdiff_t>(first) * layer.in;
    Scalar* below = tape->deltas[l - 1].data() + start;
    if (l == top && fused_single_head()) {
      layers::DotBackward(weights.values.data() + layer.weights, delta, tape->activations[l - 1].data() + start,
                          layer.in, count, below, sums + layers_[l - 1].bias, sums + layer.weights);
    } else {
      kernels_[l].backward(weights.transposed.data() + layer.transposed, delta, count, below);
      BackwardActivation(weights, l - 1, first, count, tape, sums);
    }
  }
}

// deltas[l]: derivatives by the layer's activations → by its z = W x + b.
template <typename Scalar>
void Mlp<Scalar>::BackwardActivation(const MlpWeights<Scalar>& weights, int l, int first, int count,
                                     MlpTape<Scalar>* tape, Scalar* gradient) const {
  const MlpLayer& layer = layers_[l];
  const ptrdiff_t start = static_cast<ptrdiff_t>(first) * layer.out;
  const Scalar* h = tape->activations[l].data() + start;
  Scalar* delta = tape->deltas[l].data() + start;
  if (!shape_.layer_norm) {
    layers::ReluBackward(h, layer.out, count, delta, gradient + layer.bias);
    return;
  }
  const Scalar* x = tape->normalized[l].data() + start;
  layers::GainReluBackward(weights.values.data() + layer.gain, x, h, layer.out, count, delta, gradient + layer.gain,
                           gradient + layer.offset);
  for (int j = 0; j < count; ++j) {
    const ptrdiff_t column = static_cast<ptrdiff_t>(j) * layer.out;
    layers::NormalizeBackward(x + column, tape->inverse_std[l][first + j], layer.out, delta + column);
  }
  layers::AddColumns(delta, layer.out, count, gradient + layer.bias);
}

// In pieces that depend on the width, for no other reason than that runs keep the bits they have had.
template <typename Scalar>
void Mlp<Scalar>::AddHeadBiasGradient(int n, const MlpTape<Scalar>& tape, AlignedBuffer<Scalar>* gradient) const {
  const MlpLayer& head = layers_.back();
  const int limit = std::clamp(8192 / head.in, 32, 128);
  const int pieces = (n + limit - 1) / limit;
  const int piece = (n + pieces - 1) / pieces;
  for (int first = 0; first < n; first += piece) {
    layers::AddColumns(tape.deltas.back().data() + static_cast<ptrdiff_t>(first) * head.out, head.out,
                       std::min(piece, n - first), gradient->data() + head.bias);
  }
}

// The products dW = dz xᵀ of all layers, after the deltas of n columns.
template <typename Scalar>
void Mlp<Scalar>::AddWeightGradients(const Scalar* x, int n, Accumulate accumulate, const MlpTape<Scalar>& tape,
                                     AlignedBuffer<Scalar>* gradient) const {
  const auto size = std::lower_bound(columns_.begin(), columns_.end(), n) - columns_.begin();
  CAIRN_DCHECK(columns_[size] == n);
  AddHeadBiasGradient(n, tape, gradient);
  for (size_t l = 0; l < layers_.size(); ++l) {
    const MlpLayer& layer = layers_[l];
    if (!layer.hidden && fused_single_head()) continue;  // BackwardBlock has done it
    const Scalar* in = l == 0 ? x : tape.activations[l - 1].data();
    const Scalar* delta = tape.deltas[l].data();
    const Kernels& kernels = kernels_[l];
    const auto& product =
        (accumulate == Accumulate::kAdd ? kernels.weight_gradient_sum : kernels.weight_gradient)[size];
    if (layer.narrow()) {
      product(in, delta, gradient->data() + layer.narrow_sums);
    } else {
      product(delta, in, gradient->data() + layer.weights);
    }
  }
}

template <typename Scalar>
void Mlp<Scalar>::InputGradient(const MlpWeights<Scalar>& weights, std::span<const int> samples, int first, int count,
                                MlpTape<Scalar>* tape, Scalar* d_input) const {
  const int n = static_cast<int>(samples.size());
  const MlpLayer& head = layers_.back();
  const MlpLayer& bottom = layers_.front();
  CAIRN_DCHECK(head.out == 1);
  const int top = static_cast<int>(layers_.size()) - 2;
  Scalar* delta = tape->deltas[top].data();
  layers::MaskVector(weights.values.data() + head.weights, tape->activations[top].data(), samples, head.in, delta);
  if (shape_.layer_norm) SampleNormGradient(weights, top, samples, *tape, delta);
  for (int l = top; l > 0; --l) {
    Scalar* below = tape->deltas[l - 1].data();
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
