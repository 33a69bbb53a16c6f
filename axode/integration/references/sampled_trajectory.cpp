#include "axode/integration/references/sampled_trajectory.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <stdexcept>
#include <string>
#include <vector>

#include "axode/constraints/prescribed/motion_rows.hpp"
#include "axode/constraints/prescribed/quintic_spline.hpp"
#include "axode/eigen.hpp"
#include "axode/integration/configuration_group.hpp"
#include "axode/integration/references/number_checks.hpp"
#include "axode/model/building/checks/value_checks.hpp"
#include "axode/model/configuration.hpp"

namespace axode {
namespace {

using Span = std::span<const double>;
using Vector = std::vector<double>;

/// The number of samples that determine a polynomial of degree 5.
constexpr std::size_t of_quintic = 6;

void check_sample_times(Span t) {
  if (t.size() < 2)
    throw std::invalid_argument("t has " + std::to_string(t.size()) +
                                " times; a trajectory needs at least two");
  check_times(t);
}

/// The times t and configurations q of a motion, with given or computed velocities v and accelerations a.
struct Samples {
  const Model& model;
  Span t;
  Vector q, v, a;
  std::size_t nq = static_cast<std::size_t>(model.nq()), nv = static_cast<std::size_t>(model.nv());

  Samples(const Model& of, Span times, Span configurations);

  Span row(std::size_t k) const { return Span(q).subspan(k * nq, nq); }
  QuinticSpline spline(const Vector& all, std::size_t width, int column) const;
  void differentiate_by_splines();
  void differentiate_on_group();
  void accelerations_from_velocities();
  Trajectory trajectory() const;
};

Samples::Samples(const Model& of, Span times, Span configurations) : model(of), t(times) {
  check_sample_times(t);
  check_size("q", configurations.size(), t.size() * nq, "nq for each time");
  check_finite("q", configurations);
  for (std::size_t k = 0; k < t.size(); ++k) {
    const Span q_k = configurations.subspan(k * nq, nq);
    check_configuration(model, q_k, ("q[" + std::to_string(k) + "]").c_str());
    const Vector normalized = normalize(model, q_k);
    q.insert(q.end(), normalized.begin(), normalized.end());
  }
}

QuinticSpline Samples::spline(const Vector& all, std::size_t width, int column) const {
  Vector values(t.size());
  for (std::size_t k = 0; k < t.size(); ++k) values[k] = all[k * width + static_cast<std::size_t>(column)];
  return {t, values};
}

/// Computes v and a of the joints of one velocity, from splines through their coordinates.
void Samples::differentiate_by_splines() {
  for (const Joint& joint : model.joints()) {
    if (joint.nv != 1) continue;
    const QuinticSpline spline = this->spline(q, nq, joint.iq);
    for (std::size_t k = 0; k < t.size(); ++k) {
      const std::size_t c = k * nv + static_cast<std::size_t>(joint.iv);
      v[c] = spline.derivative(1, t[k]);
      a[c] = spline.derivative(2, t[k]);
    }
  }
}

/// Computes v and a of the joints with several velocities by polynomial interpolation of neighbouring
/// samples. Near sample k at the time t_k, the motion is q = (q_k ⊕ (t - t_k) z) ⊕ x(t), where z is the mean
/// velocity between samples k and k + 1 (or k - 1 and k, for the last sample) and x(t) a polynomial with
/// x(t_k) = 0. Hence v = z + x' and a = x'' - [x', z] at this sample.
void Samples::differentiate_on_group() {
  const ConfigurationGroup<double> group(model.tree<double>());
  if (group.commutes()) return;
  const std::size_t count = std::min(t.size(), of_quintic);
  Vector moved(nq), z(nv), y(nv), dx(nv), ddx(nv), turning(nv), values(count);
  std::vector<Vector> x(count, Vector(nv));
  for (std::size_t k = 0; k < t.size(); ++k) {
    const std::size_t end = std::max<std::size_t>(std::min(k + 1, t.size() - 1), 1);
    const double h = t[end] - t[end - 1];
    group.difference(row(end - 1), row(end), z);
    group.noncommuting(z, z);
    for (double& z_c : z) z_c /= h;
    const std::size_t first = std::min(k < 2 ? 0 : k - 2, t.size() - count);
    for (std::size_t j = 0; j < count; ++j) {
      for (std::size_t c = 0; c < nv; ++c) y[c] = (t[first + j] - t[k]) * z[c];
      group.move(row(k), y, moved);
      group.difference(moved, row(first + j), x[j]);
    }
    for (std::size_t c = 0; c < nv; ++c) {
      for (std::size_t j = 0; j < count; ++j) values[j] = x[j][c];
      const QuinticSpline polynomial(t.subspan(first, count), values);
      dx[c] = polynomial.derivative(1, t[k]);
      ddx[c] = polynomial.derivative(2, t[k]);
    }
    group.bracket(dx, z, turning);
    for (const Joint& joint : model.joints()) {
      if (joint.nv == 1) continue;
      for (int i = joint.iv; i < joint.iv + joint.nv; ++i) {
        const auto c = static_cast<std::size_t>(i);
        v[k * nv + c] = z[c] + dx[c];
        a[k * nv + c] = ddx[c] - turning[c];
      }
    }
  }
}

void Samples::accelerations_from_velocities() {
  for (int c = 0; c < model.nv(); ++c) {
    const QuinticSpline spline = this->spline(v, nv, c);
    for (std::size_t k = 0; k < t.size(); ++k)
      a[k * nv + static_cast<std::size_t>(c)] = spline.derivative(1, t[k]);
  }
}

Trajectory Samples::trajectory() const {
  Trajectory motion(model);
  const Vector tau(nv);
  for (std::size_t k = 0; k < t.size(); ++k)
    motion.append(t[k], row(k), Span(v).subspan(k * nv, nv), Span(a).subspan(k * nv, nv), tau);
  motion.steps = t.size() - 1;
  return motion;
}

/// The joint with the name `of`. Throws std::invalid_argument for rods and for joints coupled to others.
const Joint& joint_of(const Model& model, const std::string& of) {
  const auto joint = std::ranges::find(model.joints(), of, &Joint::name);
  if (joint == model.joints().end())
    throw std::invalid_argument("motions: " + quoted(of) +
                                " is a rod; a trajectory follows joints, and kinematic_motion() moves rods");
  if (joint->leader)
    throw std::invalid_argument("motions: joint " + quoted(of) + " is coupled to joint " +
                                quoted(model.joint(joint->leader->joint).name) +
                                "; remove it from `motions`, and give the motion of that joint");
  return *joint;
}

/// The times t of a trajectory, and the times between them at which a derivative of a motion jumps.
Vector with_jumps(Span t, const MotionRows& motions) {
  const double rounding = 1e-9 * (t.back() - t.front());
  Vector times(t.begin(), t.end());
  for (double at = motions.next_jump(t.front()); at < t.back(); at = motions.next_jump(at)) {
    const auto after = std::ranges::lower_bound(times, at);
    const double nearest = std::min(*after - at, at - *std::prev(after));
    if (nearest > rounding) times.insert(after, at);
  }
  return times;
}

}  // namespace

Trajectory trajectory_from_samples(const Model& model, Span t, Span q, Span v, Span a) {
  Samples samples(model, t, q);
  const std::size_t size = t.size() * samples.nv;
  if (v.empty() && !a.empty())
    throw std::invalid_argument("v is missing; a trajectory with accelerations a needs velocities as well");
  for (const auto& [name, given] : {std::pair{"v", v}, {"a", a}})
    if (!given.empty()) {
      check_size(name, given.size(), size, "nv for each time");
      check_finite(name, given);
    }
  samples.v.assign(v.begin(), v.end());
  samples.a.assign(a.begin(), a.end());
  samples.v.resize(size);
  samples.a.resize(size);
  if (v.empty()) {
    samples.differentiate_by_splines();
    samples.differentiate_on_group();
  } else if (a.empty()) {
    samples.accelerations_from_velocities();
  }
  return samples.trajectory();
}

Trajectory trajectory_from_functions(const Model& model, Span t, std::span<const PrescribedMotion> motions,
                                     Span q) {
  check_sample_times(t);
  const Vector rest = q.empty() ? initial_state(model).q : Vector(q.begin(), q.end());
  check_configuration(model, rest);
  check_finite("q", rest);
  const MotionRows rows(model, motions);
  rows.check_times(t.front(), t.back());
  const Vector times = with_jumps(t, rows);
  const auto nq = static_cast<std::size_t>(model.nq()), nv = static_cast<std::size_t>(model.nv());
  Vector all_q, all_v(times.size() * nv), all_a(all_v);
  for (std::size_t k = 0; k < times.size(); ++k) all_q.insert(all_q.end(), rest.begin(), rest.end());
  for (const MotionRows::Row& row : rows.rows()) {
    const Joint& joint = joint_of(model, row.of);
    for (std::size_t k = 0; k < times.size(); ++k) {
      const MotionValue at = row.function(times[k]);
      if (!std::isfinite(at.s) || !std::isfinite(at.ds) || !std::isfinite(at.dds))
        throw std::invalid_argument("motions: the motion of " + quoted(row.of) +
                                    " is not finite at t = " + to_text(times[k]) + " s");
      all_q[k * nq + static_cast<std::size_t>(joint.iq)] = at.s;
      all_v[k * nv + static_cast<std::size_t>(joint.iv)] = at.ds;
      all_a[k * nv + static_cast<std::size_t>(joint.iv)] = at.dds;
    }
  }
  return trajectory_from_samples(model, times, all_q, all_v, all_a);
}

}  // namespace axode
