#include "axode/constraints/loop_system/loop_system.hpp"
#include "axode/recursion/instantiate.hpp"

/// Two fast algorithms for mechanisms with loops. accelerate_fast() computes accelerations by a version of
/// the articulated-body algorithm (D4.12) for mechanisms without coupled joints (joints that share a
/// velocity), which does not estimate rounding errors. force_fast() computes the joint forces that the
/// spanning tree needs for a given motion (q, v, a), by inverse dynamics.
namespace axode {

template <class T>
bool LoopSystem<T>::accelerate_fast(const T* q, const T* v, const T* tau, const Loads<T>& loads, T* a,
                                    T* lambda, const RowRank& rank) noexcept {
  if (!table_.of_couplings().empty()) return false;
  const Tree<T>& t = tree();
  using Bodies = typename FastKernel::Bodies;
  Bodies& bodies = (*fast_)->tree.bodies;
  auto* const moving = (*fast_)->moving;
  auto* const V = dynamics_->recursion.motion.bodies.V;
  auto* const dV = dynamics_->recursion.motion.bodies.dV;
  link_ = dynamics_->recursion.motion.bodies.link;
  origin_ = dynamics_->recursion.origin;
  link_[0] = Link<Spatial, T>::root();
  V[0] = {};
  dV[0] = {{}, -t.g};
  moving[0] = {};
  const bool sound = (*fast_)->tree.prepare(
      t, q, v, tau, loads,
      [&](int i, const typename Bodies::Matrix& R, const typename Bodies::Motion& now,
          const typename Bodies::Vector& u) {
        const int p = t->parent[i];
        const auto& d = bodies.body[i].r;
        auto& [r, r_dot] = moving[i];
        r = p > 0 ? moving[p].r + d : typename Bodies::Vector{};
        r_dot = moving[p].v + u;
        if (p == 0) origin_[i] = d;
        if (!table_.ends[index(i)]) return;
        const typename Bodies::Factor at(r);
        link_[i].C = {{R.x, R.y, R.z}, r};
        V[i] = {now.w, r_dot + cross(at, now.w_)};
        dV[i] = {now.dw, now.a + cross(at, now.dw_) + cross(typename Bodies::Factor(r_dot), now.w_)};
      });
  if (!sound) return false;
  const auto each_velocity = [&](const auto& f) {
    for (int i = 1; i <= t->n; ++i)
      for (int s = t->first_screw[i]; s < t->first_screw[i + 1]; ++s)
        f(t->iv[i] + s - t->first_screw[i], bodies.pivot[s]);
  };
  each_velocity([&](int c, const auto& pivot) {
    root_[c] = value(pivot.D_inv);
    w_[c] = value(pivot.u);
  });
  root_ = root_.cwiseSqrt();
  w_.array() /= root_.array();
  update_loop_ends();
  make_wrenches(ConstraintLevel::velocity);
  table_.each([&](std::size_t k, const auto& joint) {
    loops::bias(joint, at_[k].frames, at_[k].W.data(), motion_of_ends(k, V, dV),
                b_.data() + table_.paths[k].rows.first);
  });
  for (const PrescribedRow<T>& it : prescribed_) b_[it.row] -= it.dds;
  for (std::size_t k = 0; k < at_.size(); ++k)
    each_register_of_rows<T>(count(table_.paths[k]),
                             [&](int row, auto n) { pull_rows_fast<n()>(table_.paths[k], at_[k], row); });
  multiply_rows();
  for (const LoopPath& path : table_.paths) {  // if all rows of a loop nearly vanish, the general elimination
                                               // is needed
    constexpr T least_part = T(1e-10);
    T most(0);
    for (const int c : path.velocities) most = std::max(most, root_[c] * root_[c]);
    if (!(G_.diagonal().segment(first(path), count(path)).maxCoeff() > least_part * most)) return false;
  }
  add_to_rows(b_.data());
  if (!solve_sound_rows(b_.data(), lambda, rank)) {
    set_filter(q, rank);
    solve_filtered_rows(b_.data(), lambda, rank);
  }
  w_.setZero();
  add_to_velocities(lambda);
  each_velocity([&](int c, auto& pivot) { pivot.u = pivot.u + root_[c] * w_[c]; });
  bodies.accelerate(t, (*fast_)->tree.motion, a);
  return true;
}

template <class T>
std::span<T> LoopSystem<T>::force_fast(const T* q, const T* v, const T* a, const Loads<T>& loads) noexcept {
  using Bodies = typename FastKernel::Bodies;
  using Triple = typename Bodies::Vector;
  using Factor = typename Bodies::Factor;
  using Spread = typename Bodies::Spread;
  const Tree<T>& t = tree();
  auto& inverse = (*fast_)->inverse;
  auto* const motion = (*fast_)->motion;
  auto* const V = dynamics_->recursion.motion.bodies.V;
  auto* const dV = dynamics_->recursion.motion.bodies.dV;
  link_ = dynamics_->recursion.motion.bodies.link;
  origin_ = dynamics_->recursion.origin;
  link_[0] = Link<Spatial, T>::root();
  V[0] = {};
  dV[0] = {{}, -t.g};
  motion[0] = {typename Bodies::Matrix(SO3<T>{}), {}, {}, {}};
  inverse.run(t, q, v, a, loads, t.g, [&](int i, const auto& now, const Triple& v_J) {
    const int p = t->parent[i];
    const auto& [R_p, r_p, v_p, w_p] = motion[p];
    const auto& b = inverse.fast.body[i];
    const typename Bodies::Matrix R{R_p * Spread(b.R.x), R_p * Spread(b.R.y), R_p * Spread(b.R.z)};
    const Triple d = R_p * Spread(b.r), w = R * now.w.spread();
    const Triple r = p > 0 ? r_p + d : Triple{};
    Triple r_dot = v_p + cross(Factor(w_p), Factor(d));
    if (!is_hinge(t, i)) r_dot += R * Spread(v_J);
    motion[i] = {R, r, r_dot, w};
    if (p == 0) origin_[i] = d;
    link_[i].C = {{R.x, R.y, R.z}, r};
    if (!table_.ends[index(i)]) return;
    const Triple dw = R * now.dw.spread();
    const Factor at(r);
    V[i] = {w, r_dot + cross(at, Factor(w))};
    dV[i] = {dw, R * Spread(now.a) + cross(at, Factor(dw)) + cross(Factor(r_dot), Factor(w))};
  });
  inverse.project(t, v, a, loads.joint_losses, forces_.data());
  update_loops();
  make_rows(ConstraintLevel::velocity);
  return {forces_.data(), index(model_.nv())};
}

/// Computes the entries of Y = D^-½ L⁻ᵀ Aᵀ for n equations of a loop (D7.6), with the Jacobian A of the loop
/// equations and the mass matrix LᵀD L of the spanning tree. `row` is the first of the equations. The
/// wrenches of the equations are moved from body to body along the path to the ground; on each body they are
/// about its origin.
template <class T>
template <int n>
void LoopSystem<T>::pull_rows_fast(const LoopPath& path, const State& at, int row) noexcept {
  const Tree<T>& t = tree();
  const auto& bodies = (*fast_)->tree.bodies;
  using Wrenches = RowsInLanes<T, n>;
  Wrenches F_i = -Wrenches(at.W, row), F_j(at.W, row);
  F_i.move(-at.shift - link_[path.ends[0].body].C.r);
  F_j.move(-link_[path.ends[1].body].C.r);
  propagate_to_root(path, F_i, F_j, [&](int i, Wrenches& F) {
    const auto& body = bodies.body[i];
    const int first_screw = t->first_screw[i];
    const auto eliminate = [&](int s, const auto& u) {
      const int c = t->iv[i] + s - first_screw;
      const auto& pivot = bodies.pivot[s];
      F.eliminate(u, root_[c], &Y_(c, first(path) + row), u, pivot.K_m, pivot.K_f);
    };
    if (is_hinge(t, i)) {  // the stored K of a hinge is about the predecessor's origin
      const auto u = dot(Wrenches::all(body.n), F.m);
      F.move(body.r);
      eliminate(first_screw, u);
    } else {
      for (int s = t->first_screw[i + 1]; s-- > first_screw;) {
        const auto& pivot = bodies.pivot[s];
        eliminate(s, dot(Wrenches::all(pivot.w), F.m) + dot(Wrenches::all(pivot.v), F.f));
      }
      F.move(body.r);
    }
  });
}

template AXODE_ENTRY std::span<AXODE_T> LoopSystem<AXODE_T>::force_fast(const AXODE_T*, const AXODE_T*,
                                                                        const AXODE_T*,
                                                                        const Loads<AXODE_T>&) noexcept;
template AXODE_ENTRY bool LoopSystem<AXODE_T>::accelerate_fast(const AXODE_T*, const AXODE_T*, const AXODE_T*,
                                                               const Loads<AXODE_T>&, AXODE_T*, AXODE_T*,
                                                               const RowRank&) noexcept;

}  // namespace axode
