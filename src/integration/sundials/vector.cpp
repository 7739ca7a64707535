#include "integration/sundials/vector.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <experimental/simd>

namespace viscobar::sundials {

namespace {

constexpr std::size_t highest_order = 12;

template <class Values, std::size_t q, class Load, class Store>
void triangle(const Load& load, const Store& store) {
  std::array<Values, q + 1> z;
#pragma GCC unroll 16
  for (std::size_t j = 0; j <= q; ++j) z[j] = load(j);
#pragma GCC unroll 16
  for (std::size_t k = 1; k <= q; ++k)
#pragma GCC unroll 16
    for (std::size_t j = q; j >= k; --j) z[j - 1] += z[j];
#pragma GCC unroll 16
  for (std::size_t j = 0; j < q; ++j) store(j, z[j]);
}

template <std::size_t q>
void sum_history(double* const* z, std::size_t n) {
  namespace simd = std::experimental;
  using Pack = simd::native_simd<double>;
  std::size_t i = 0;
  for (; i + Pack::size() <= n; i += Pack::size())
    triangle<Pack, q>([&](std::size_t j) { return Pack(z[j] + i, simd::element_aligned); },
                      [&](std::size_t j, const Pack& value) { value.copy_to(z[j] + i, simd::element_aligned); });
  for (; i < n; ++i)
    triangle<double, q>([&](std::size_t j) { return z[j][i]; }, [&](std::size_t j, double value) { z[j][i] = value; });
}

using Kernel = void (*)(double* const*, std::size_t);

template <std::size_t... q>
constexpr std::array<Kernel, sizeof...(q)> triangles(std::index_sequence<q...>) {
  return {sum_history<q + 1>...};
}

}  // namespace

bool HistorySums::put_off(double* x, const double* y, std::size_t n) {
  if (count_ == sums_.size() || (count_ > 0 && n != size_)) return false;
  sums_[count_++] = {x, y};
  size_ = n;
  return true;
}

std::size_t HistorySums::cascade() const {
  // Of different vectors: one that comes back would have to be read again.
  const auto seen = [&](const double* x, std::size_t count) {
    return std::ranges::any_of(std::span(sums_).first(count), [x](const Sum& sum) { return sum.x == x || sum.y == x; });
  };
  std::size_t q = 1;
  while (q < count_ && sums_[q].y == sums_[q - 1].x && !seen(sums_[q].x, q)) ++q;
  return q;
}

bool HistorySums::is_triangle(std::size_t order) const {
  if (count_ != order * (order + 1) / 2) return false;
  std::size_t i = order;
  for (std::size_t k = 1; k < order; ++k)
    for (std::size_t j = 0; j < order - k; ++j, ++i)
      if (sums_[i].x != sums_[j].x || sums_[i].y != sums_[j].y) return false;
  return true;
}

void HistorySums::carry_out() {
  static constexpr auto kernels = triangles(std::make_index_sequence<highest_order>{});
  if (const std::size_t q = cascade(); q <= highest_order && is_triangle(q)) {
    std::array<double*, highest_order + 1> z;
    z[q] = const_cast<double*>(sums_[0].y);  // is read only
    for (std::size_t j = 0; j < q; ++j) z[q - 1 - j] = sums_[j].x;
    kernels[q - 1](z.data(), size_);
  } else {
    for (std::size_t k = 0; k < count_; ++k)
      for (std::size_t i = 0; i < size_; ++i) sums_[k].x[i] += sums_[k].y[i];
  }
  count_ = 0;
}

namespace {

struct Content {
  Eigen::ArrayXd data;
  const Probed* probed = nullptr;  // of a probe
  Eigen::Index weighed = 0;        // entries from the first on that norms look at
  int owners = 1;
};

constinit thread_local bool out_of_memory = false;

// Asked for, and not looked at yet. An integration and its vectors stay in one thread.
constinit thread_local HistorySums put_off_sums;

Eigen::ArrayXd& stored(N_Vector x) { return static_cast<Content*>(x->content)->data; }

// The first look at a vector passes here.
Content& content(N_Vector x) {
  if (!put_off_sums.empty()) put_off_sums.carry_out();
  return *static_cast<Content*>(x->content);
}
Eigen::ArrayXd& array(N_Vector x) { return content(x).data; }

// The library takes for granted that it gets a vector. Without memory it gets the same one again, and require_memory()
// ends what it makes of that.
N_Vector clone(N_Vector x) noexcept {
  N_Vector copy = N_VNewEmpty(x->sunctx);
  try {
    if (!copy || N_VCopyOps(x, copy) != 0) throw std::bad_alloc();
    copy->content = new Content{Eigen::ArrayXd::Zero(array(x).size()), content(x).probed, content(x).weighed};
    return copy;
  } catch (const std::bad_alloc&) {
    if (copy) N_VFreeEmpty(copy);
    out_of_memory = true;
    ++content(x).owners;
    return x;
  }
}

void destroy(N_Vector x) noexcept {
  if (--content(x).owners > 0) return;
  delete &content(x);
  x->content = nullptr;
  N_VFreeEmpty(x);
}

int linear_combination(int count, sunrealtype* c, N_Vector* x, N_Vector z) noexcept {
  auto& out = array(z);
  // Several operands a pass: the result is read and written once for each group, and may be the first operand.
  switch (count) {
    case 1: out = c[0] * array(x[0]); return 0;
    case 2: out = c[0] * array(x[0]) + c[1] * array(x[1]); return 0;
    case 3: out = c[0] * array(x[0]) + c[1] * array(x[1]) + c[2] * array(x[2]); return 0;
    default: out = c[0] * array(x[0]) + c[1] * array(x[1]) + c[2] * array(x[2]) + c[3] * array(x[3]);
  }
  int k = 4;
  for (; k + 1 < count; k += 2) out += c[k] * array(x[k]) + c[k + 1] * array(x[k + 1]);
  if (k < count) out += c[k] * array(x[k]);
  return 0;
}

int probed_combination(int count, sunrealtype* c, N_Vector* x, N_Vector z) noexcept {
  const Probed& probed = *content(z).probed;
  double* out = array(z).data();
  for (const std::size_t i : probed.selected) out[i] = 0.0;
  for (int k = 0; k < count; ++k) {
    if (c[k] == 0.0) continue;  // a derivative at the end of a step is a single term
    const double* from = array(x[k]).data();
    for (const std::size_t i : probed.selected) out[i] += c[k] * from[probed.entries[i]];
  }
  return 0;
}

int scale_add_multi(int count, sunrealtype* c, N_Vector x, N_Vector* y, N_Vector* z) noexcept {
  const auto& added = array(x);
  // Piece by piece, so that x is read from memory once.
  constexpr Eigen::Index piece = 1024;
  for (Eigen::Index i = 0; i < added.size(); i += piece) {
    const Eigen::Index n = std::min(piece, added.size() - i);
    for (int k = 0; k < count; ++k)
      stored(z[k]).segment(i, n) = stored(y[k]).segment(i, n) + c[k] * added.segment(i, n);
  }
  return 0;
}

bool put_off(N_Vector x, N_Vector y) {
  auto &sum = stored(x), &term = stored(y);
  return put_off_sums.put_off(sum.data(), term.data(), static_cast<std::size_t>(sum.size()));
}

void linear_sum(sunrealtype a, N_Vector x, sunrealtype b, N_Vector y, N_Vector z) noexcept {
  if (a == 1.0 && b == 1.0 && x == z && y != z && put_off(x, y)) return;
  if (a == 1.0)
    array(z) = array(x) + b * array(y);
  else
    array(z) = a * array(x) + b * array(y);
}

double weighted_max_norm(N_Vector x, N_Vector w) noexcept {
  const Eigen::Index n = content(x).weighed;
  return (array(x).head(n) * array(w).head(n)).abs().maxCoeff();
}

Vector make(Eigen::ArrayXd data, const Probed* probed, Eigen::Index weighed, const Context& context) {
  Vector vector(N_VNewEmpty(context.get()));
  if (!vector) throw std::bad_alloc();
  vector->content = new Content{std::move(data), probed, weighed};
  auto& ops = *vector->ops;
  ops.nvgetvectorid = [](N_Vector) noexcept { return SUNDIALS_NVEC_CUSTOM; };
  ops.nvclone = clone;
  ops.nvcloneempty = clone;
  ops.nvdestroy = destroy;
  ops.nvgetarraypointer = [](N_Vector x) noexcept { return array(x).data(); };
  ops.nvgetlength = [](N_Vector x) noexcept { return static_cast<sunindextype>(array(x).size()); };
  ops.nvlinearsum = linear_sum;
  ops.nvconst = [](sunrealtype c, N_Vector z) noexcept { array(z).setConstant(c); };
  ops.nvprod = [](N_Vector x, N_Vector y, N_Vector z) noexcept { array(z) = array(x) * array(y); };
  ops.nvdiv = [](N_Vector x, N_Vector y, N_Vector z) noexcept { array(z) = array(x) / array(y); };
  ops.nvscale = [](sunrealtype c, N_Vector x, N_Vector z) noexcept { array(z) = c * array(x); };
  ops.nvabs = [](N_Vector x, N_Vector z) noexcept { array(z) = array(x).abs(); };
  ops.nvinv = [](N_Vector x, N_Vector z) noexcept { array(z) = array(x).inverse(); };
  ops.nvaddconst = [](N_Vector x, sunrealtype b, N_Vector z) noexcept { array(z) = array(x) + b; };
  ops.nvdotprod = [](N_Vector x, N_Vector y) noexcept { return (array(x) * array(y)).sum(); };
  ops.nvmaxnorm = [](N_Vector x) noexcept { return array(x).abs().maxCoeff(); };
  ops.nvmin = [](N_Vector x) noexcept { return array(x).minCoeff(); };
  ops.nvwrmsnorm = weighted_max_norm;
  ops.nvlinearcombination = probed ? probed_combination : linear_combination;
  ops.nvscaleaddmulti = scale_add_multi;
  return vector;
}

}  // namespace

Vector make_vector(std::size_t size, const Context& context, std::size_t weighed) {
  return make(Eigen::ArrayXd::Zero(static_cast<Eigen::Index>(size)), nullptr,
              static_cast<Eigen::Index>(std::min(size, weighed)), context);
}

Vector make_probe(const Probed& probed, const Context& context) {
  const auto size = static_cast<Eigen::Index>(probed.entries.size());
  return make(Eigen::ArrayXd::Zero(size), &probed, size, context);
}

void require_memory() {
  if (std::exchange(out_of_memory, false)) throw std::bad_alloc();
}

std::span<double> values(N_Vector vector) {
  auto& data = array(vector);
  return {data.data(), static_cast<std::size_t>(data.size())};
}

}  // namespace viscobar::sundials
