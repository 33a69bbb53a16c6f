#pragma once
#include <algorithm>
#include <utility>
#include <vector>

#include "axode/catalog.hpp"
#include "tests/support/random_tree.hpp"

namespace axode::test {

/// The numbers of N states, one state after the other. The array of accelerations serves as forces too.
template <class T> struct RandomStates {
  std::vector<T> q, v, a, dq, dv, da, w;

  RandomStates(const Model& model, std::size_t N, std::uint64_t seed) {
    Random<double> random(seed);
    const auto append = [](std::vector<T>& to, const auto& from) {
      for (const double x : from) to.push_back(static_cast<T>(x));
    };
    for (std::size_t k = 0; k < N; ++k) {
      const State<double> state = random_state(model, random);
      append(q, state.q);
      append(v, state.v);
      append(a, state.a);
      for (auto* x : {&dq, &dv, &da, &w}) append(*x, random_numbers(random, model.nv()));
    }
  }

  /// The arguments that a function takes, for `count` states beginning with the state `first`.
  catalog::Arguments<T> given(const Model& model, const catalog::Words& function, std::size_t first,
                              std::size_t count) const {
    const std::pair<catalog::Input, const std::vector<T>*> all[]{
        {catalog::Input::q, &q},   {catalog::Input::v, &v},     {catalog::Input::a, &a},
        {catalog::Input::tau, &a}, {catalog::Input::dq, &dq},   {catalog::Input::dv, &dv},
        {catalog::Input::da, &da}, {catalog::Input::dtau, &da}, {catalog::Input::weights, &w}};
    catalog::Arguments<T> out;
    for (const auto& [input, numbers] : all) {
      if (!function.takes_input(input)) continue;
      const auto n = static_cast<std::size_t>(input == catalog::Input::q ? model.nq() : model.nv());
      catalog::numbers(out, input) = std::span<const T>(*numbers).subspan(first * n, count * n);
    }
    return out;
  }
};

}  // namespace axode::test
