#pragma once
#include <vector>

#include "axode/model/workspace.hpp"
#include "axode/recursion/inverse_dynamics.hpp"
#include "axode/scalar/taylor.hpp"

/// The kernels in a scalar type that the test chooses, for every frame of a tree. On Taylor series they give
/// time derivatives.
namespace axode::test {

template <class T> std::vector<SE3<T>> frame_poses(const Tree<T>& tree, const std::vector<T>& q) {
  WithScratch<T, BodyPoses<T>> C(*tree.topology());
  C->run(tree, q.data());
  std::vector<SE3<T>> frames;
  for (int f = 0; f < tree->n_frames(); ++f)
    frames.push_back((*C)[tree->frame_body[f]] * tree.frame_offset[f]);
  return frames;
}

template <class Rep, class T>
std::vector<Twist<Rep, T>> frame_twists(const Tree<T>& tree, const std::vector<T>& q,
                                        const std::vector<T>& v) {
  WithScratch<T, TreeMotion<Rep, T>> motion(*tree.topology());
  motion->run(tree, q.data(), v.data(), v.data());
  const BodyMotion<Rep, T>& bodies = motion->bodies;
  std::vector<Twist<Rep, T>> V;
  for (int f = 0; f < tree->n_frames(); ++f)
    V.push_back(
        bodies.link[tree->frame_body[f]].child(tree.frame_offset[f]).down(bodies.V[tree->frame_body[f]]));
  return V;
}

template <class Rep, class T>
std::vector<T> generalised_forces(const Tree<T>& tree, const std::vector<T>& q, const std::vector<T>& v,
                                  const std::vector<T>& a, const Loads<T>& loads = {}) {
  WithScratch<T, InverseDynamicsRecursion<Rep, T>> recursion(*tree.topology());
  recursion->run(tree, q.data(), v.data(), a.data(), loads);
  std::vector<T> tau(static_cast<std::size_t>(tree->nv));
  recursion->project(tree, v.data(), a.data(), loads.joint_losses, tau.data());
  return tau;
}

/// q + v t + a t²/2 on the configuration manifold: the coordinates of a motion that has the velocities v and
/// the accelerations a at t = 0, as series in t.
template <std::size_t N, class T>
std::vector<Taylor<T, N>> moving(const Tree<Taylor<T, N>>& tree, const std::vector<T>& q,
                                 const std::vector<T>& v, const std::vector<T>& a) {
  using Series = Taylor<T, N>;
  const std::vector<Series> q0(q.begin(), q.end());
  std::vector<Series> dv(v.size()), out(q.size());
  for (std::size_t k = 0; k < v.size(); ++k) {
    dv[k].c[1] = v[k];
    if constexpr (N > 2) dv[k].c[2] = T(0.5) * a[k];
  }
  each_joint(tree, [&](const auto& joint, int i, bool coupled) {
    if (!coupled) joint.integrate(&q0[tree->iq[i]], &dv[tree->iv[i]], &out[tree->iq[i]]);
  });
  return out;
}

/// v + a t.
template <std::size_t N, class T>
std::vector<Taylor<T, N>> moving(const std::vector<T>& v, const std::vector<T>& a) {
  std::vector<Taylor<T, N>> out;
  for (std::size_t k = 0; k < v.size(); ++k) out.push_back(Taylor<T, N>({v[k], a[k]}));
  return out;
}

}  // namespace axode::test
