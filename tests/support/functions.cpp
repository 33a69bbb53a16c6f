#include "tests/support/functions.hpp"

namespace axode::test {

template <class T> std::span<const catalog::Function<T>> functions_of(const Case& c) {
  if (c.fast) return catalog::functions<Fast, T>();
  return with_representation(c.representation,
                             [](auto rep) { return catalog::functions<decltype(rep), T>(); });
}

template <class T>
Arguments<T>::Arguments(const Ask& ask)
    : q(cast<T>(ask.q)),
      v(cast<T>(ask.v)),
      a(cast<T>(ask.a)),
      tau(cast<T>(ask.tau)),
      p(cast<T>(ask.p)),
      dq(cast<T>(ask.dq)),
      dv(cast<T>(ask.dv)),
      da(cast<T>(ask.da)),
      dtau(cast<T>(ask.dtau)),
      w(cast<T>(ask.w)),
      joint_losses(ask.loads.joint_losses),
      place(ask.place.frame, axode::cast<T>(ask.place.offset)),
      base(ask.base.frame, axode::cast<T>(ask.base.offset)),
      form(ask.form) {
  for (const AppliedWrench<>& W : ask.loads.wrenches)
    wrenches.emplace_back(W.frame, W.representation, axode::cast<T>(W.m), axode::cast<T>(W.f));
}

namespace {

Ask any(const Model& model, const State<double>& state, Random<double>& random) {
  return {.q = state.q,
          .v = state.v,
          .a = state.a,
          .tau = random_numbers(random, model.nv()),
          .p = random_numbers(random, model.nv()),
          .dq = random_numbers(random, model.nv()),
          .dv = random_numbers(random, model.nv()),
          .da = random_numbers(random, model.nv()),
          .dtau = random_numbers(random, model.nv()),
          .w = random_numbers(random, model.nv()),
          .loads = {.wrenches = state.wrenches, .joint_losses = true},
          .place = {model.n_frames() - 1, random.vector()},
          .base = 1};
}
State<double> loaded_state(const Model& model, Random<double>& random) {
  State<double> state = random_state(model, random);
  const Vec3<> f = random.vector(10), m = random.vector(10);
  state.wrenches.emplace_back(1, Representation::hybrid, m, f);
  return state;
}

}  // namespace

template <class T>
Arguments<T>::Arguments(const Model& model, Random<double>& random)
    : Arguments(any(model, loaded_state(model, random), random)) {}

template <class T> catalog::Arguments<T> Arguments<T>::given() const {
  catalog::Arguments<T> given{q, v, a, tau, p, dq, dv, da, dtau, w};
  given.loads = {wrenches, joint_losses};
  given.place = place, given.base = base, given.form = form;
  return given;
}

template std::span<const catalog::Function<double>> functions_of(const Case&);
template std::span<const catalog::Function<float>> functions_of(const Case&);
template struct Arguments<double>;
template struct Arguments<float>;

}  // namespace axode::test
