#pragma once
#include <algorithm>
#include <span>
#include <vector>

#include "axode/lie/twist.hpp"
#include "axode/model/workspace.hpp"
#include "axode/recursion/articulated_bodies.hpp"
#include "axode/recursion/spatial_tree.hpp"

namespace axode {

/// The floating bases of a mechanism for schemes on (q, p): the root bodies (bodies joined to the ground) on
/// a free joint without armature, damping and friction, if no loop connects their subtrees to other bodies
/// and no coupling contains velocities of the joint. Instead of its joint momentum, a floating base has the
/// state y, the spatial momentum of its subtree in a moving frame (D5.6, D5.7). The frame does not rotate,
/// but falls with gravity and, if no wrenches are applied, also moves with the initial velocity of the centre
/// of mass of the subtree. Hence every scheme keeps the linear momentum, and the angular momentum about the
/// centre of mass, exact to rounding if no load acts on the mechanism and no drive on a floating base.
class FloatingBases {
 public:
  FloatingBases(const Model& model, const double* q, const double* v, bool wrenches)
      : tree_(&model.tree<double>()),
        kernel_(model.topology()),
        ends_(model.topology()),
        momenta_(model.topology()),
        gravity_(size((*tree_)->n + 1), tree_->g) {
    kernel_->run(*tree_, q);
    each_root(model.topology(), [&](int i) {
      const double mass = kernel_->M[i].m;
      if ((*tree_)->kind[i] != Subgroup::free || !moves_freely(i) || is_connected(model, i) || !(mass > 0))
        return;
      roots_.push_back({i, !wrenches, {}, {}});
      gravity_[size(i)] = {};
    });
    restart(0, q, v, wrenches);
  }
  /// Lets the moving frames coincide with the inertial frame at time t. wrenches: whether wrenches act.
  void restart(double t, const double* q, const double* v, bool wrenches) {
    place(t, q);
    momenta_->run(*kernel_, v);
    for (Root& root : roots_) set_frame(root, momenta_->Pi[root.body].p, wrenches);
  }
  /// Begins the motion of the moving frames of floating bases, which do not rotate and fall with gravity:
  /// lets them coincide with the inertial frame at time t. start() then sets their velocities. Also computes,
  /// for restore_centers(), the centre of mass of each floating base with its subtree at the configuration q.
  void place(double t, const double* q) {
    kernel_->run(*tree_, q);
    place(t);
  }
  /// Places the moving frames for a time t like the other overload, at the configuration at which `bodies`
  /// have factorised the mass matrix. Their poses and inertias are taken over, so that they are not computed
  /// again.
  void place(double t, const ArticulatedBodies<Spatial, double>& bodies) {
    if (roots_.empty()) return;
    kernel_->take(*tree_->operator->(), bodies);
    place(t);
  }
  /// Sets the initial velocities of the moving frames of the floating bases, and converts the joint momenta p
  /// = M v from the inertial frame to the moving frames. A moving frame does not rotate, but falls with
  /// gravity from the time at which place() lets it coincide with the inertial frame. Its initial velocity is
  /// 0 if `wrenches` says that wrenches are applied, and otherwise that of the centre of mass of the floating
  /// base with its subtree. The function may be called again with other momenta.
  void start(bool wrenches, double* p) {
    for (Root& root : roots_) {
      set_frame(root, kernel_->link[root.body].C.R * read<BodyFixed>(root, p).f, wrenches);
      if (!root.constant) continue;
      const Twist<Spatial> U{{}, root.u};
      for (int i = root.body; i < (*tree_)->subtree_end[root.body]; ++i) {
        const Momentum<Spatial> of_frame = kernel_->M[i] * U;
        kernel_->each_screw(i, [&](int c, const Twist<Spatial>& J) { p[c] -= of_frame | J; });
      }
    }
  }
  /// The gravity (m/s², inertial axes) for equations of motion relative to the moving frames of the floating
  /// bases. If body i is joined to the ground, entry i holds for its subtree. It is 0 for a floating base,
  /// because its moving frame falls with gravity. Entries of other bodies are not used.
  std::span<const Vec3<>> gravity() const { return gravity_; }
  /// Calls f(body, constant) for each floating base. `constant` says whether the centre of mass of the base
  /// with its subtree is at rest in the moving frame of the base, which does not rotate and falls with
  /// gravity.
  template <class F> void each(const F& f) const {
    for (const Root& root : roots_) f(root.body, root.constant);
  }
  /// Whether one of the joint forces tau (nv numbers) of a floating base is not 0.
  bool driven_by(const double* tau) const {
    for (const Root& root : roots_)
      for (int k = 0; k < 6; ++k)
        if (tau[first(root) + k] != 0) return true;
    return false;
  }

  /// to_moving_frame() converts q and v of each floating base at time t from the inertial frame to the moving
  /// frame of the base; from_moving_frame() converts them back. A moving frame does not rotate, but falls
  /// with gravity from the time at which place() lets it coincide with the inertial frame.
  void to_moving_frame(double t, double* q, double* v) const { add(-1, t, q, v); }
  void from_moving_frame(double t, double* q, double* v) const { add(1, t, q, v); }
  /// Converts q alone from the moving frames to the inertial frame.
  void from_moving_frame(double t, double* q) const { displace(1, t - begin_, q); }

  // In the functions begin() to restore_centers(), q, p and y are relative to the moving frames.
  /// Converts the states of the floating bases in y from joint momenta to spatial momenta.
  void begin(const double* q, double* y) const {
    for (const Root& root : roots_) {
      const Wrench<Spatial> Pi = coAd(pose(root, q), read<BodyFixed>(root, y));
      write(root, Wrench<Spatial>{Pi.m, root.constant ? Vec3<>{} : Pi.f}, y);
    }
  }
  /// Computes the joint momenta p of the floating bases from their spatial momenta in y.
  void to_momenta(const double* q, const double* y, double* p) const {
    for (const Root& root : roots_) write(root, coAd_inv(pose(root, q), read<Spatial>(root, y)), p);
  }
  /// Computes the rates y' of the spatial momenta y of the floating bases from f = p' - ad_vᵀ p with their
  /// joint momenta p and velocities v. Each floating base has a moving frame, which does not rotate and falls
  /// with gravity from the time at which place() lets it coincide with the inertial frame. y, p and v belong
  /// to the motion of the base and its subtree relative to this frame, so that gravity does not change y and
  /// p. Hence y' is 0 unless loads act on the mechanism or a joint force acts on one of the floating bases.
  /// `pushed` says whether this is so, for all floating bases together.
  void rates(const double* q, bool pushed, const double* f, double* dy) {
    for (Root& root : roots_) {
      write(root, pushed ? coAd(pose(root, q), read<BodyFixed>(root, f)) : Wrench<Spatial>{}, dy);
      root.constant = root.constant && !pushed;
    }
  }
  /// Advances the spatial momenta y of the floating bases by a time h (s): y becomes y + h y'. Each floating
  /// base has a moving frame, which does not rotate and falls with gravity; y, p and v belong to the motion
  /// relative to this frame. On entry the six entries of each floating base in f (nv numbers) must contain
  /// p' - ad_vᵀ p, with the joint momenta p and the body-fixed twist v of the base. rates() computes y' from
  /// them, and y' replaces them. The other entries of f do not change. For `pushed` see rates().
  void advance(const double* q, double h, bool pushed, double* f, double* y) {
    rates(q, pushed, f, f);
    for (const Root& root : roots_)
      for (int c = first(root); c < first(root) + 6; ++c) y[c] += h * f[c];
  }
  /// Removes the drift of the centres of mass of floating bases on which no load or drive has acted. The
  /// centre of mass of such a base with its subtree rests in its moving frame, which does not rotate and
  /// falls with gravity. The base is translated so that the centre of mass has exactly the position in this
  /// frame that place() computed when the motion of the frame began.
  void restore_centers(double* q) {
    if (std::ranges::none_of(roots_, &Root::constant)) return;
    ends_->run(*tree_, q);
    for (const Root& root : roots_) {
      if (!root.constant) continue;
      Vec3<> h;  // about the origin of the base
      for (int i = root.body; i < (*tree_)->subtree_end[root.body]; ++i)
        h += ends_->link[i].C.R * tree_->M[i].h + tree_->M[i].m * ends_->link[i].C.r;
      const Vec3<> c = ends_->origin[root.body] + (1 / kernel_->M[root.body].m) * h;
      move(root, root.center - c, q);
    }
  }

 private:
  void place(double t) {
    begin_ = t;
    for (Root& root : roots_) root.center = center(root.body);
  }
  struct Root {
    int body;
    bool constant;
    Vec3<> center, u;  ///< centre of mass and velocity of the frame at time begin_
  };
  static std::size_t size(int n) { return static_cast<std::size_t>(n); }
  int first(const Root& root) const { return (*tree_)->iv[root.body]; }
  /// Whether the joint of a base has no armature, damping and friction.
  bool moves_freely(int i) const {
    for (int c = (*tree_)->iv[i]; c < (*tree_)->iv[i] + 6; ++c)
      if (tree_->armature[size(c)] != 0 || tree_->damping[size(c)] != 0 || tree_->friction[size(c)] != 0)
        return false;
    return true;
  }
  /// Whether a loop connects the subtree of body i, which is joined to the ground, to other bodies, or a
  /// coupling contains a velocity of joint i.
  bool is_connected(const Model& model, int i) const {
    const auto carried = [&](int body) { return body >= i && body < (*tree_)->subtree_end[i]; };
    const auto its = [&](const LoopCoupling::Term& term) {
      return term.velocity >= (*tree_)->iv[i] && term.velocity < (*tree_)->iv[i] + 6;
    };
    const auto leaves = [&](const Loop& loop) {
      return carried(loop.ends[0].body) != carried(loop.ends[1].body);
    };
    const auto binds = [&](const LoopCoupling& coupling) { return std::ranges::any_of(coupling.terms, its); };
    return std::ranges::any_of(model.loops().joints, leaves) ||
           std::ranges::any_of(model.loops().couplings, binds);
  }
  void set_frame(Root& root, const Vec3<>& momentum, bool wrenches) {
    root.constant = !wrenches;
    root.u = wrenches ? Vec3<>{} : (1 / kernel_->M[root.body].m) * momentum;
  }
  /// The centre of mass of the subtree of body i, at the configuration of the kernel.
  Vec3<> center(int i) {
    const Inertia<>& M = kernel_->M[i];
    return kernel_->origin[i] + (1 / M.m) * M.h;
  }
  SE3<> pose(const Root& root, const double* q) const {
    return subgroup::Free<double>::pose(tree_->B[size(root.body)], q + (*tree_)->iq[root.body]);
  }
  void move(const Root& root, const Vec3<>& by, double* q) const {
    const Vec3<> d = transpose(tree_->B[size(root.body)].R) * by;
    double* const r = q + (*tree_)->iq[root.body] + 4;
    r[0] += d.x;
    r[1] += d.y;
    r[2] += d.z;
  }
  void add(double sign, double time, double* q, double* v) const {
    const double t = time - begin_;
    for (const Root& root : roots_) {
      const Vec3<> u = transpose(pose(root, q).R) * (root.u + t * tree_->g);
      double* const linear = v + first(root) + 3;
      linear[0] += sign * u.x;
      linear[1] += sign * u.y;
      linear[2] += sign * u.z;
    }
    displace(sign, t, q);
  }
  void displace(double sign, double t, double* q) const {
    for (const Root& root : roots_) move(root, (sign * t) * (root.u + (0.5 * t) * tree_->g), q);
  }
  template <class Rep> Wrench<Rep> read(const Root& root, const double* y) const {
    const double* x = y + first(root);
    return {{x[0], x[1], x[2]}, {x[3], x[4], x[5]}};
  }
  template <class Rep> void write(const Root& root, const Wrench<Rep>& W, double* y) const {
    double* x = y + first(root);
    for (const double number : {W.m.x, W.m.y, W.m.z, W.f.x, W.f.y, W.f.z}) *x++ = number;
  }

  const Tree<double>* tree_;
  WithScratch<double, SpatialTree<double>> kernel_;
  WithScratch<double, BodyLinks<Spatial, double>> ends_;
  WithScratch<double, SubtreeMomenta<double>> momenta_;
  double begin_ = 0;  ///< time at which moving and inertial frames coincide, s
  std::vector<Vec3<>> gravity_;
  std::vector<Root> roots_;
};

}  // namespace axode
