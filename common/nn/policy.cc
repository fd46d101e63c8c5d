#include "common/nn/policy.h"

#include <algorithm>
#include <numeric>

#include "common/core/check.h"
#include "common/nn/aligned_buffer.h"
#include "common/nn/column_gemm.h"
#include "common/nn/full_width.h"
#include "common/nn/kernels.h"
#include "common/nn/layers.h"
#include "common/nn/vector_math.h"

namespace cairn {
namespace {

constexpr int kChunk = 64;   // columns that are pushed through all layers at a time
constexpr int kNarrow = 16;  // heads with fewer outputs are dot products instead of a product vectorised over outputs
constexpr float kMinLogStd = -20.0f;
constexpr float kMaxLogStd = 2.0f;

std::vector<int> Widths(int max_columns) {
  std::vector<int> widths(static_cast<size_t>(max_columns));
  std::iota(widths.begin(), widths.end(), 1);
  return widths;
}

float Clip(float x) { return std::min(std::max(x, -1.0f), 1.0f); }

}  // namespace

size_t PolicyShape::num_parameters() const {
  size_t count = 0;
  size_t in = static_cast<size_t>(observation_size);
  for (int width : net_arch) {
    const auto out = static_cast<size_t>(width);
    count += out * in + out * (layer_norm ? 3 : 1);
    in = out;
  }
  const auto out = static_cast<size_t>(output_size());
  return count + out * in + out;
}

std::string PolicyShape::ToString() const {
  std::string text = fmt::format("{} {}", head == Head::kGaussian ? "gaussian" : "deterministic", observation_size);
  for (int width : net_arch) text += fmt::format("-{}", width);
  text += fmt::format("-{}", output_size());
  return layer_norm ? text + " layer_norm" : text;
}

/// Parameters, kernels and activations of one forward pass of at most kChunk columns.
struct Policy::Workspace {
  struct Layer {
    int in, out;
    size_t weights, bias, gain, offset;  // positions in `parameters`
    ColumnGemm<float> product;           // not for a narrow head
  };

  Workspace(const PolicyShape& shape, int max_batch)
      : chunk(std::min(max_batch, kChunk)), layer_norm(shape.layer_norm), parameters(shape.num_parameters()) {
    const std::vector<int> widths = Widths(chunk);
    size_t position = 0;
    int in = shape.observation_size;
    for (int out : shape.net_arch) in = AddLayer(in, out, layer_norm, widths, &position);
    AddLayer(in, shape.output_size(), false, widths, &position);
    CAIRN_CHECK(position == parameters.size());
    for (const Layer& layer : layers) activations.emplace_back(static_cast<size_t>(layer.out) * chunk);
    head_transposed = AlignedBuffer<float>(static_cast<size_t>(layers.back().in) * layers.back().out);
    std = AlignedBuffer<float>(static_cast<size_t>(shape.action_size) * chunk);
  }

  int AddLayer(int in, int out, bool norm, const std::vector<int>& widths, size_t* position) {
    const size_t weights = *position;
    const size_t bias = weights + static_cast<size_t>(out) * in;
    const size_t gain = bias + out;
    const size_t offset = gain + (norm ? out : 0);
    *position = offset + (norm ? out : 0);
    layers.push_back({in, out, weights, bias, gain, offset, ColumnGemm<float>(out, in, out, in, out, widths)});
    return out;
  }

  void SetParameters(std::span<const float> values) {
    std::copy(values.begin(), values.end(), parameters.begin());
    const Layer& head = layers.back();
    kernels::Best().transpose(parameters.data() + head.weights, head.out, head.in, head_transposed.data());
  }

  /// Output of the last layer, [output_size × n].
  const float* Forward(const float* observations, int n) {
    const float* x = observations;
    for (size_t l = 0; l + 1 < layers.size(); ++l) {
      float* h = activations[l].data();
      layers[l].product(parameters.data() + layers[l].weights, x, n, h);
      if (!fused_head() || l + 2 < layers.size()) Activate(layers[l], n, h);
      x = h;
    }
    return Head(x, n, activations.back().data());
  }

  /// Few outputs without LayerNorm below them share the pass of the last activation.
  bool fused_head() const { return layers.size() > 1 && layers.back().out < kNarrow && !layer_norm; }

  void Activate(const Layer& layer, int n, float* h) const {
    const float* p = parameters.data();
    if (layer_norm) {
      layers::Normalize<float>(p + layer.bias, layer.out, n, h, nullptr);
      layers::GainRelu(p + layer.gain, p + layer.offset, layer.out, n, h, h);
    } else {
      layers::BiasRelu(p + layer.bias, layer.out, n, h);
    }
  }

  const float* Head(const float* x, int n, float* y) {
    const Layer& head = layers.back();
    const float* p = parameters.data();
    if (fused_head()) {
      const size_t last = layers.size() - 2;
      kernels::Best().bias_relu_product(p + layers[last].bias, head_transposed.data(), p + head.bias, head.in, head.out,
                                        n, false, activations[last].data(), y);
    } else if (head.out < kNarrow) {
      layers::NarrowProduct(head_transposed.data(), p + head.bias, x, head.in, head.out, n, y);
    } else {
      head.product(p + head.weights, x, n, y);
      layers::AddBias(p + head.bias, head.out, n, y);
    }
    return y;
  }

  int chunk;
  bool layer_norm;
  AlignedBuffer<float> parameters;
  std::vector<Layer> layers;
  std::vector<AlignedBuffer<float>> activations;
  AlignedBuffer<float> head_transposed;  // [in × out]
  AlignedBuffer<float> std;
};

namespace {

// Copies `count` rows of y [rows × n] from `first` on into `to` [count × n].
void CopyRows(const float* y, int rows, int first, int count, int n, float* to) {
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < count; ++i) to[j * count + i] = y[j * rows + first + i];
  }
}

}  // namespace

Policy::Policy(PolicyShape shape, int max_batch) : shape_(std::move(shape)) {
  CAIRN_CHECK(max_batch > 0, "max_batch {}", max_batch);
  workspace_ = std::make_unique<Workspace>(shape_, max_batch);
}

Policy::~Policy() = default;
Policy::Policy(Policy&&) noexcept = default;
Policy& Policy::operator=(Policy&&) noexcept = default;

void Policy::SetParameters(std::span<const float> parameters) {
  const size_t size = shape_.num_parameters();
  if (parameters.size() != size) {
    ThrowError("policy parameters: got {}, but {} has {}", parameters.size(), shape_.ToString(), size);
  }
  for (size_t i = 0; i < size; ++i) {
    if (!std::isfinite(parameters[i])) ThrowError("policy parameter {} of {} is {}", i, size, parameters[i]);
  }
  workspace_->SetParameters(parameters);
}

void Policy::Act(const float* observations, int n, float* actions) {
  const int size = shape_.action_size;
  for (int first = 0; first < n; first += workspace_->chunk) {
    const int columns = std::min(workspace_->chunk, n - first);
    const float* y = workspace_->Forward(observations + static_cast<size_t>(first) * shape_.observation_size, columns);
    float* a = actions + static_cast<size_t>(first) * size;
    CopyRows(y, shape_.output_size(), 0, size, columns, a);
    const int count = columns * size;
    AtFullWidth([=]() CAIRN_INLINE_LOOP {
      for (int i = 0; i < count; ++i) a[i] = math::Tanh(a[i]);
    });
  }
}

void Policy::Explore(const float* observations, int n, const float* noise, float action_noise, float* actions) {
  if (shape_.head == PolicyShape::Head::kDeterministic) {
    Act(observations, n, actions);
    for (int i = 0; i < n * shape_.action_size; ++i) actions[i] = Clip(math::Fma(action_noise, noise[i], actions[i]));
    return;
  }
  const int size = shape_.action_size;
  for (int first = 0; first < n; first += workspace_->chunk) {
    const int columns = std::min(workspace_->chunk, n - first);
    const float* y = workspace_->Forward(observations + static_cast<size_t>(first) * shape_.observation_size, columns);
    float* a = actions + static_cast<size_t>(first) * size;
    const float* normal = noise + static_cast<size_t>(first) * size;
    float* const std = workspace_->std.data();
    CopyRows(y, shape_.output_size(), 0, size, columns, a);
    CopyRows(y, shape_.output_size(), size, size, columns, std);
    const int count = columns * size;
    AtFullWidth([=]() CAIRN_INLINE_LOOP {
      for (int i = 0; i < count; ++i) {
        const float above = std[i] < kMinLogStd ? kMinLogStd : std[i];
        const float log_std = kMaxLogStd < above ? kMaxLogStd : above;
        a[i] = math::Tanh(math::Fma(math::Exp(log_std), normal[i], a[i]));
      }
    });
  }
}

}  // namespace cairn
