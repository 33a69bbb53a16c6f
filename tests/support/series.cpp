#include "tests/support/series.hpp"

#include "tests/support/any_scalar.hpp"

namespace axode::test {
namespace {

using S = Taylor<double, 3>;

Vec3<> rate(const Vec3<S>& a) { return {a.x.c[1], a.y.c[1], a.z.c[1]}; }

struct Motion {
  Tree<S> tree;
  std::vector<S> q, v;
  std::vector<SE3<S>> C;  ///< the poses of all frames

  Motion(const Model& model, const State<double>& state)
      : tree(cast<S>(model.tree<double>())),
        q(moving(tree, state.q, state.v, state.a)),
        v(moving<3>(state.v, state.a)),
        C(frame_poses(tree, q)) {}
};

struct SixSeries {
  Vec3<S> a, b;
};
std::vector<SixSeries> twists_of(Representation representation, const Motion& at) {
  std::vector<SixSeries> all;
  with_representation(representation, [&](auto rep) {
    for (const auto& [w, v] : frame_twists<decltype(rep)>(at.tree, at.q, at.v)) all.push_back({w, v});
  });
  return all;
}
/// f(M, C, V) for every body, with its inertia and its twist in its own frame.
template <class F>
void each_body(Representation representation, const Model& model, const Motion& at, const F& f) {
  const std::vector<SixSeries> V = twists_of(representation, at);
  for (int i = 1; i <= model.n_bodies(); ++i) {
    const std::size_t k = static_cast<std::size_t>(i);
    const Twist<BodyFixed, S> V_b = with_representation(representation, [&](auto rep) {
      return change<BodyFixed>(at.C[k], Twist<decltype(rep), S>{V[k].a, V[k].b});
    });
    f(axode::cast<S>(model.body(i).M), at.C[k], V_b);
  }
}

}  // namespace

std::vector<Vec3<>> rates_of_poses(const Model& model, const State<double>& state) {
  std::vector<Vec3<>> all;
  for (const SE3<S>& C : Motion(model, state).C)
    for (const Vec3<S>& column : {C.R.x, C.R.y, C.R.z, C.r}) all.push_back(rate(column));
  return all;
}

std::vector<Six> rates_of_twists(Representation representation, const Model& model,
                                 const State<double>& state) {
  std::vector<Six> all;
  for (const auto& [a, b] : twists_of(representation, Motion(model, state)))
    all.push_back({rate(a), rate(b)});
  return all;
}

double rate_of_energy(Representation representation, const Model& model, const State<double>& state) {
  const Motion at(model, state);
  S E(0.0);
  each_body(representation, model, at, [&](const Inertia<S>& M, const SE3<S>& C, const auto& V) {
    E += S(0.5) * (M * V | V) - dot(at.tree.g, M.m * C.r + C.R * M.h);
  });
  for (std::size_t k = 0; k < at.v.size(); ++k) E += S(0.5) * at.tree.armature[k] * at.v[k] * at.v[k];
  return E.c[1];
}

Six rate_of_momentum(Representation representation, const Model& model, const State<double>& state) {
  Momentum<Spatial, S> Pi{};
  each_body(representation, model, Motion(model, state),
            [&](const Inertia<S>& M, const SE3<S>& C, const auto& V) { Pi += change<Spatial>(C, M * V); });
  return {rate(Pi.l), rate(Pi.p)};
}

}  // namespace axode::test
