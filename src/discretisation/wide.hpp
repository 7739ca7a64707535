#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <type_traits>

// One program for every x86-64 processor: what gains by wide registers is compiled for each width of them, and the
// processor that runs it decides. Another compiler than GCC, another architecture and -march=native have one width.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__AVX2__)
#define VISCOBAR_WIDTHS
#endif

namespace viscobar {

template <std::size_t width>
using Width = std::integral_constant<std::size_t, width>;

/// `width` numbers side by side, as a register of the processor holds them.
template <std::size_t width>
struct Wide {
  using type [[gnu::vector_size(width * sizeof(double))]] = double;
};

template <class Values>
[[gnu::always_inline]] inline Values take(const double* x) {
  Values values;
  std::memcpy(&values, x, sizeof values);
  return values;
}
template <class Values>
[[gnu::always_inline]] inline void put(const Values& values, double* x) {
  std::memcpy(x, &values, sizeof values);
}

/// Numbers in a register where nothing is chosen: what the whole program is compiled for.
#if defined(__AVX512F__)
inline constexpr std::size_t compiled_width = 8;
#elif defined(__AVX2__)
inline constexpr std::size_t compiled_width = 4;
#else
inline constexpr std::size_t compiled_width = 2;
#endif

/// Numbers in a register of this processor: 8 with AVX-512, 4 with AVX2, else compiled_width. Tests set it.
extern std::size_t register_width;

#ifdef VISCOBAR_WIDTHS
template <class Body>
[[gnu::target("avx512f")]] inline auto with_avx512(Body body) {
  return body(Width<8>());
}
template <class Body>
[[gnu::target("avx2")]] inline auto with_avx2(Body body) {
  return body(Width<4>());
}
#endif

/// body(Width<w>()), w = register_width, compiled for such registers: a lambda, and all that it calls, that is to be
/// inlined (gnu::always_inline). Every width gives the same bits: each entry is worked out by the same operations in
/// the same order, and none are fused (-ffp-contract=off).
template <class Body>
[[gnu::always_inline]] inline auto by_width(Body body) {
#ifdef VISCOBAR_WIDTHS
  if (register_width == 8) return with_avx512(body);
  if (register_width == 4) return with_avx2(body);
#endif
  return body(Width<compiled_width>());
}

/// body(i) for each i < n, in any order and side by side: a lambda that is to be inlined, and holds copies of pointers.
template <class Body>
[[gnu::always_inline]] inline void each(std::size_t n, Body of) {
  by_width([ n, body = of ](auto) __attribute__((always_inline)) {
#pragma GCC ivdep
    for (std::size_t i = 0; i < n; ++i) body(i);
  });
}

/// max |value(i, kind)| over i < n; `kind` is of the type of the values: a double, or as many as a register holds. One
/// that is not a number may be passed over.
template <class Value>
[[gnu::always_inline]] inline double largest_of(std::size_t n, Value of) {
  return by_width([ n, value = of ](auto width) __attribute__((always_inline)) {
    constexpr std::size_t size = width, turns = 4;  // one alone would wait for itself
    using Pack = typename Wide<size>::type;
    Pack most[turns]{};
    const auto take_in = [&](Pack & so_far, std::size_t k) __attribute__((always_inline)) {
      const Pack now = value(k, Pack()), size_of_it = now < 0.0 ? -now : now;
      so_far = size_of_it > so_far ? size_of_it : so_far;
    };
    std::size_t i = 0;
    for (; i + turns * size <= n; i += turns * size)
#pragma GCC unroll 4
      for (std::size_t k = 0; k < turns; ++k) take_in(most[k], i + k * size);
    for (; i + size <= n; i += size) take_in(most[0], i);
    double largest = 0.0;
    for (const Pack& one : most)
      for (std::size_t l = 0; l < size; ++l) largest = std::max(largest, one[l]);
    for (; i < n; ++i) largest = std::max(largest, std::abs(value(i, 0.0)));
    return largest;
  });
}

}  // namespace viscobar
