#include "integration/sundials/vector.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <experimental/simd>

namespace viscobar::sundials {

namespace {

constexpr std::size_t highest_order = 12;

namespace simd = std::experimental;
using Pack = simd::native_simd<double>;

template <class Values>
Values load(const double* x) {
  if constexpr (std::is_same_v<Values, Pack>)
    return Pack(x, simd::element_aligned);
  else
    return *x;
}
void store(const Pack& pack, double* x) { pack.copy_to(x, simd::element_aligned); }
void store(double value, double* x) { *x = value; }

// body(i, 0.0) for each i < n, or body(i, Pack()) for as many from i on as a register has: four of those a turn, since
// the loop itself would be as many instructions as what is done in it.
template <class Body>
[[gnu::always_inline]] inline void in_packs(std::size_t n, const Body& body) {
  constexpr std::size_t size = Pack::size();
  std::size_t i = 0;
  for (; i + 4 * size <= n; i += 4 * size)
#pragma GCC unroll 4
    for (std::size_t k = 0; k < 4; ++k) body(i + k * size, Pack());
  for (; i + size <= n; i += size) body(i, Pack());
  for (; i < n; ++i) body(i, 0.0);
}

// The whole triangle, or its first cascade alone.
template <std::size_t q, bool whole>
void sum_history(double* const* z, std::size_t n) {
  const auto sum = [z](std::size_t i, auto kind) {
    using Values = decltype(kind);
    std::array<Values, q + 1> values;
#pragma GCC unroll 16
    for (std::size_t j = 0; j <= q; ++j) values[j] = load<Values>(z[j] + i);
#pragma GCC unroll 16
    for (std::size_t k = 1; k <= (whole ? q : 1); ++k)
#pragma GCC unroll 16
      for (std::size_t j = q; j >= k; --j) values[j - 1] += values[j];
#pragma GCC unroll 16
    for (std::size_t j = 0; j < q; ++j) store(values[j], z[j] + i);
  };
  std::size_t i = 0;
  for (; i + Pack::size() <= n; i += Pack::size()) sum(i, Pack());
  for (; i < n; ++i) sum(i, 0.0);
}

using Kernel = void (*)(double* const*, std::size_t);

template <bool whole, std::size_t... q>
constexpr std::array<Kernel, sizeof...(q)> kernels(std::index_sequence<q...>) {
  return {sum_history<q + 1, whole>...};
}

}  // namespace

Context::Context() : put_off_(std::make_unique<HistorySums>()) {
  if (make_context(&context_) != 0) throw std::bad_alloc();
}

Context::~Context() { free_context(&context_); }

bool HistorySums::put_off(double* x, const double* y, std::size_t n) {
  if (count_ == sums_.size() || (count_ > 0 && n != size_)) return false;
  sums_[count_++] = {x, y};
  size_ = n;
  return true;
}

std::size_t HistorySums::cascade() const {
  // The vectors must differ: one that comes back would have to be read again.
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
  static constexpr auto orders = std::make_index_sequence<highest_order>{};
  static constexpr auto triangles = kernels<true>(orders), cascades = kernels<false>(orders);
  std::size_t q = cascade();
  const bool whole = q <= highest_order && is_triangle(q);
  if (q > highest_order) q = 0;
  if (q > 0) {
    std::array<double*, highest_order + 1> z;
    z[q] = const_cast<double*>(sums_[0].y);  // is read only
    for (std::size_t j = 0; j < q; ++j) z[q - 1 - j] = sums_[j].x;
    (whole ? triangles : cascades)[q - 1](z.data(), size_);
  }
  for (std::size_t k = whole ? count_ : q; k < count_; ++k)
    in_packs(size_, [x = sums_[k].x, y = sums_[k].y](std::size_t i, auto kind) {
      store(load<decltype(kind)>(x + i) + load<decltype(kind)>(y + i), x + i);
    });
  count_ = 0;
}

namespace {

struct Content {
  HistorySums* put_off;  // of all vectors of its context
  Eigen::ArrayXd data;
  const Probed* probed = nullptr;  // of a probe
  Recorded* record = nullptr;      // of a recorder
  Eigen::Index weighed = 0;        // entries from the first on that norms look at
  int owners = 1;
};

constinit thread_local bool out_of_memory = false;

Eigen::ArrayXd& stored(N_Vector x) { return static_cast<Content*>(x->content)->data; }

// The first look at a vector passes here.
Content& content(N_Vector x) {
  auto& found = *static_cast<Content*>(x->content);
  if (!found.put_off->empty()) found.put_off->carry_out();
  return found;
}
Eigen::ArrayXd& array(N_Vector x) { return content(x).data; }

// The library takes for granted that it gets a vector. Without memory it gets the same one again, and require_memory()
// ends what it makes of that.
N_Vector clone(N_Vector x) noexcept {
  N_Vector copy = N_VNewEmpty(x->sunctx);
  try {
    if (!copy || N_VCopyOps(x, copy) != 0) throw std::bad_alloc();
    const Content& of = content(x);
    copy->content = new Content{of.put_off, Eigen::ArrayXd::Zero(of.data.size()), of.probed, of.record, of.weighed};
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

// to <- what `value` makes of entries i of the operands.
template <class Value>
void each_entry(N_Vector to, const Value& value) {
  auto& out = array(to);
  in_packs(static_cast<std::size_t>(out.size()),
           [&value, z = out.data()](std::size_t i, auto kind) { store(value(i, kind), z + i); });
}

// The result is written once, and may be one of the operands. Of two products the one that is named first is rounded
// before the other is added to it, since the compiler fuses what follows.
template <std::size_t count>
void combine(const sunrealtype* c, N_Vector* x, N_Vector z) {
  std::array<const double*, count> from;
  for (std::size_t k = 0; k < count; ++k) from[k] = array(x[k]).data();
  each_entry(z, [c, from](std::size_t i, auto kind) {
    const auto term = [&](std::size_t k) { return c[k] * load<decltype(kind)>(from[k] + i); };
    auto sum = count > 1 ? term(count > 1) : term(0);
    if constexpr (count > 1) sum = term(0) + sum;
    constexpr std::size_t first = std::min<std::size_t>(count, 4);
#pragma GCC unroll 4
    for (std::size_t k = 2; k < first; ++k) sum += term(k);
#pragma GCC unroll 4
    for (std::size_t k = first; k + 1 < count; k += 2) {
      const auto other = term(k + 1);
      sum += term(k) + other;
    }
    if constexpr (count > first && (count - first) % 2 == 1) sum += term(count - 1);
    return sum;
  });
}

template <std::size_t... k>
constexpr std::array<void (*)(const sunrealtype*, N_Vector*, N_Vector), sizeof...(k)> combinations(
    std::index_sequence<k...>) {
  return {combine<k + 1>...};
}

int linear_combination(int count, sunrealtype* c, N_Vector* x, N_Vector z) noexcept {
  static constexpr auto up_to_eight = combinations(std::make_index_sequence<8>{});
  const int most = std::min(count, 8);
  up_to_eight[static_cast<std::size_t>(most - 1)](c, x, z);
  for (int k = most; k + 1 < count; k += 2) array(z) += c[k] * array(x[k]) + c[k + 1] * array(x[k + 1]);
  if ((count - most) % 2 == 1) array(z) += c[count - 1] * array(x[count - 1]);
  return 0;
}

// Up to eight terms a turn, so that a sum is rarely stored between them.
int probed_combination(int count, sunrealtype* c, N_Vector* x, N_Vector z) noexcept {
  const Probed& probed = *content(z).probed;
  double* out = array(z).data();
  for (const std::size_t i : probed.selected) out[i] = 0.0;
  std::size_t k = 0, end = static_cast<std::size_t>(count);
  const auto add = [&]<std::size_t... of>(std::index_sequence<of...>) {
    const std::array factors = {c[k + of]...};
    const std::array from = {static_cast<const double*>(array(x[k + of]).data())...};
    for (const std::size_t i : probed.selected) {
      const std::size_t entry = probed.entries[i];
      out[i] = (out[i] + ... + (factors[of] * from[of][entry]));
    }
    k += sizeof...(of);
  };
  while (end > 0 && c[end - 1] == 0.0) --end;  // a derivative at the end of a step is a single term
  while (k < end && c[k] == 0.0) ++k;
  while (k + 8 <= end) add(std::make_index_sequence<8>());
  [&]<std::size_t... rest>(std::index_sequence<rest...>) {
    ((k + rest + 1 == end ? add(std::make_index_sequence<rest + 1>()) : void()), ...);
  }
  (std::make_index_sequence<7>());
  return 0;
}

// The library hands x_0 over first, or last.
int hull_combination(int count, sunrealtype* c, N_Vector* x, N_Vector z) noexcept {
  const Probed& probed = *content(z).probed;
  const std::size_t size = probed.entries.size();
  double *lowest = array(z).data(), *highest = lowest + size, *last = highest + size;
  const int at_end = c[0] != 0.0 ? 0 : count - 1, onward = at_end == 0 ? 1 : -1;
  // Neighbours at once, as those under a span obstacle are.
  for (std::size_t at = 0, run; at < probed.selected.size(); at += run) {
    const std::size_t i = probed.selected[at], entry = probed.entries[i];
    const auto goes_on = [&](std::size_t k) {
      return at + k < probed.selected.size() && probed.selected[at + k] == i + k && probed.entries[i + k] == entry + k;
    };
    for (run = 1; goes_on(run); ++run) {
    }
    const auto term = [&](int k) { return stored(x[at_end + k * onward]).data() + entry; };
    // At first what p goes away by, and what the slope bends by.
    double *const away = &lowest[i], *const bend = &highest[i];
    const double *const ends = term(0), *const slopes = term(1);
    for (std::size_t j = 0; j < run; ++j) away[j] = std::abs(slopes[j]), bend[j] = 0.0;
    for (int k = 2; k < count; ++k) {
      const double* const terms = term(k);
#pragma GCC ivdep
      for (std::size_t j = 0; j < run; ++j) away[j] += std::abs(terms[j]), bend[j] += k * std::abs(terms[j]);
    }
#pragma GCC ivdep
    for (std::size_t j = 0; j < run; ++j) {
      const double end = ends[j], low = end - away[j], high = end + away[j], bends = bend[j];
      away[j] = slopes[j] < -bends ? end : low;
      bend[j] = slopes[j] > bends ? end : high;
      last[i + j] = end;
    }
  }
  return 0;
}

int recorded_combination(int count, sunrealtype* c, N_Vector* x, N_Vector z) noexcept {
  Recorded& record = *content(z).record;
  record.count = static_cast<std::size_t>(count);
  for (std::size_t k = 0; k < record.count; ++k) {
    record.factors[k] = c[k];
    record.terms[k] = stored(x[k]).data();
  }
  return 0;
}

int scale_add_multi(int count, sunrealtype* c, N_Vector x, N_Vector* y, N_Vector* z) noexcept {
  const auto& added = array(x);
  // Piece by piece, so that x is read from memory once.
  constexpr std::size_t piece = 1024;
  for (std::size_t begin = 0, size = static_cast<std::size_t>(added.size()); begin < size; begin += piece)
    for (int k = 0; k < count; ++k) {
      const double *from = stored(y[k]).data() + begin, *term = added.data() + begin;
      in_packs(std::min(piece, size - begin),
               [from, term, factor = c[k], to = stored(z[k]).data() + begin](std::size_t i, auto kind) {
                 store(load<decltype(kind)>(from + i) + factor * load<decltype(kind)>(term + i), to + i);
               });
    }
  return 0;
}

bool put_off(N_Vector x, N_Vector y) {
  auto &sum = stored(x), &term = stored(y);
  return static_cast<Content*>(x->content)
      ->put_off->put_off(sum.data(), term.data(), static_cast<std::size_t>(sum.size()));
}

void linear_sum(sunrealtype a, N_Vector x, sunrealtype b, N_Vector y, N_Vector z) noexcept {
  if (a == 1.0 && b == 1.0 && x == z && y != z && put_off(x, y)) return;
  const double *first = array(x).data(), *second = array(y).data();
  if (a == 1.0)
    each_entry(z, [b, first, second](std::size_t i, auto kind) {
      return load<decltype(kind)>(first + i) + b * load<decltype(kind)>(second + i);
    });
  else
    each_entry(z, [a, b, first, second](std::size_t i, auto kind) {
      const auto other = b * load<decltype(kind)>(second + i);
      return a * load<decltype(kind)>(first + i) + other;
    });
}

double weighted_max_norm(N_Vector x, N_Vector w) noexcept {
  const Eigen::Index n = content(x).weighed;
  return (array(x).head(n) * array(w).head(n)).abs().maxCoeff();
}

using Combination = int (*)(int, sunrealtype*, N_Vector*, N_Vector);

Vector make(Eigen::Index size, const Probed* probed, Eigen::Index weighed, Combination combination,
            const Context& context, Recorded* record = nullptr) {
  Vector vector(N_VNewEmpty(context.get()));
  if (!vector) throw std::bad_alloc();
  vector->content = new Content{&context.put_off(), Eigen::ArrayXd::Zero(size), probed, record, weighed};
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
  ops.nvscale = [](sunrealtype c, N_Vector x, N_Vector z) noexcept { combine<1>(&c, &x, z); };
  ops.nvabs = [](N_Vector x, N_Vector z) noexcept { array(z) = array(x).abs(); };
  ops.nvinv = [](N_Vector x, N_Vector z) noexcept { array(z) = array(x).inverse(); };
  ops.nvaddconst = [](N_Vector x, sunrealtype b, N_Vector z) noexcept { array(z) = array(x) + b; };
  ops.nvdotprod = [](N_Vector x, N_Vector y) noexcept { return (array(x) * array(y)).sum(); };
  ops.nvmaxnorm = [](N_Vector x) noexcept { return array(x).abs().maxCoeff(); };
  ops.nvmin = [](N_Vector x) noexcept { return array(x).minCoeff(); };
  ops.nvwrmsnorm = weighted_max_norm;
  ops.nvlinearcombination = combination;
  ops.nvscaleaddmulti = scale_add_multi;
  return vector;
}

}  // namespace

Vector make_vector(std::size_t size, const Context& context, std::size_t weighed) {
  return make(static_cast<Eigen::Index>(size), nullptr, static_cast<Eigen::Index>(std::min(size, weighed)),
              linear_combination, context);
}

Vector make_probe(const Probed& probed, const Context& context) {
  const auto size = static_cast<Eigen::Index>(probed.entries.size());
  return make(size, &probed, size, probed_combination, context);
}

Vector make_hull(const Probed& probed, const Context& context) {
  const auto size = static_cast<Eigen::Index>(3 * probed.entries.size());
  return make(size, &probed, size, hull_combination, context);
}

Vector make_recorder(Recorded& record, const Context& context) {
  return make(0, nullptr, 0, recorded_combination, context, &record);
}

void require_memory() {
  if (std::exchange(out_of_memory, false)) throw std::bad_alloc();
}

std::span<double> values(N_Vector vector) {
  auto& data = array(vector);
  return {data.data(), static_cast<std::size_t>(data.size())};
}

}  // namespace viscobar::sundials
