#include "axode/model/configuration.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <stdexcept>
#include <string_view>
#include <type_traits>
#include <unordered_map>

namespace axode {
namespace {

/// Calls f(s, joint) for every joint that is not coupled, where s has the formulas of its subgroup of SE(3).
template <class F> void each_independent_joint(const Model& model, F&& f) {
  for (int i = 1; i <= model.n_bodies(); ++i)
    if (!model.joint(i).leader)
      with_subgroup(model.joint(i).kind, model.joint(i).pitch,
                    [&](const auto& joint) { f(joint, model.joint(i)); });
}

template <class Real>
void check(const Model& model, std::span<const Real> q, const char* argument, double tolerance) {
  check_size(argument, q.size(), static_cast<std::size_t>(model.nq()), "nq");
  for (const int i : model.tree<double>()->quaternion_bodies) {
    const Joint& joint = model.joint(i);
    const Real* a = &q[joint.iq];
    const double size = norm(Quaternion<Real>{a[0], a[1], a[2], a[3]});
    if (!(std::abs(size - 1) <= tolerance))
      throw std::invalid_argument(std::string(argument) + ": the quaternion of joint \"" + joint.name +
                                  "\" has norm " + to_text(size) + "; it must be 1 to " + to_text(tolerance));
  }
}

/// Throws std::invalid_argument if one of `results` is not finite. The message begins with `step`, the name
/// of the vector from which the results were computed, such as "dq", and names the joint to which the number
/// belongs. `first` and `count` are the members of Joint that contain the index of the joint's first number
/// in `results` and the number of its entries.
void check_finite(const Model& model, const char* step, int Joint::*first, int Joint::*count,
                  std::span<const double> results) {
  for (const Joint& joint : model.joints()) {
    if (joint.leader) continue;
    for (const double x : results.subspan(joint.*first, joint.*count))
      if (!std::isfinite(x))
        throw std::invalid_argument(std::string(step) + ": at joint \"" + joint.name +
                                    "\" it is not finite, or so large that the result is not");
  }
}

/// Makes a name for every coordinate or velocity: the name of the joint, with an index if the joint has
/// several, as in `hip[0]`. `count` is the member of Joint that says how many a joint has, nq or nv.
std::vector<std::string> numbered(const Model& model, int Joint::*count) {
  std::vector<std::string> names;
  for (const Joint& joint : model.joints())
    for (int k = 0; k < joint.*count; ++k)
      names.push_back(joint.*count == 1 ? joint.name : joint.name + "[" + std::to_string(k) + "]");
  return names;
}

std::vector<double> of_each_velocity(const Model& model, double Dof::*number) {
  std::vector<double> numbers;
  for (const Joint& joint : model.joints())
    for (int k = 0; k < joint.nv; ++k) numbers.push_back(joint.dof[k].*number);
  return numbers;
}

}  // namespace

std::string first_not_finite(const Model& model, std::span<const double> q, std::span<const double> v) {
  const auto fault = [&](const char* what, std::span<const double> x, const auto& names) -> std::string {
    const auto bad = std::ranges::find_if_not(x, [](double x_k) { return std::isfinite(x_k); });
    if (bad == x.end()) return {};
    return std::string(what) + " of joint \"" + names(model)[static_cast<std::size_t>(bad - x.begin())] +
           "\" is " + to_text(*bad);
  };
  std::string of_q = fault("q", q, coordinate_names);
  return of_q.empty() ? fault("v", v, velocity_names) : of_q;
}

void check_size(const char* argument, std::size_t actual, std::size_t expected, const char* meaning) {
  if (actual != expected)
    throw std::invalid_argument(std::string(argument) + " has " + std::to_string(actual) +
                                " entries; expected " + meaning + " = " + std::to_string(expected));
}

void check_configuration(const Model& model, std::span<const double> q, const char* argument) {
  check(model, q, argument, 1e-6);
}
void check_configuration(const Model& model, std::span<const float> q, const char* argument) {
  check(model, q, argument, 1e-4);
}

std::vector<double> neutral(const Model& model) {
  std::vector<double> q(model.nq());
  each_independent_joint(model, [&](const auto& s, const Joint& joint) {
    std::ranges::copy(s.neutral(), q.begin() + joint.iq);
  });
  return q;
}

InitialState initial_state(const Model& model) {
  InitialState state{neutral(model), std::vector<double>(model.nv())};
  if (!model.description().state) return state;
  std::unordered_map<std::string_view, const Joint*> joints;
  for (const Joint& joint : model.joints()) joints.emplace(joint.name, &joint);
  for (const auto& [name, numbers] : model.description().state->q)
    std::ranges::copy(numbers, state.q.begin() + joints.at(name)->iq);
  for (const auto& [name, numbers] : model.description().state->v)
    std::ranges::copy(numbers, state.v.begin() + joints.at(name)->iv);
  return state;
}

std::vector<double> random_configurations(const Model& model, std::uint64_t seed, std::size_t n) {
  std::mt19937_64 bits(seed);
  const auto uniform = [&](double lower,
                           double upper) {  // the distributions of the standard library are not used, as
                                            // they give other numbers with every library
    const double s = static_cast<double>(bits() >> 11) * 0x1p-53;
    return lower * (1 - s) + upper * s;  // upper - lower could overflow
  };
  const CoordinateLimits limit = limits(model);
  std::vector<double> all(n * static_cast<std::size_t>(model.nq()));
  double* q = all.data();
  const auto draw = [&](int k, double span) {
    const double lower = limit.lower[k], upper = limit.upper[k];
    const double a = std::isfinite(lower) ? lower : std::isfinite(upper) ? upper - 2 * span : -span;
    const double b = std::isfinite(upper) ? upper : std::isfinite(lower) ? lower + 2 * span : span;
    q[k] = uniform(a, b);
  };
  const auto draw_joint = [&](const auto& s, const Joint& joint) {
    using Kind = std::remove_cvref_t<decltype(s)>;
    if constexpr (Kind::nq > Kind::nv) {  // Shoemake 1992
      const double u = uniform(0, 1), alpha = uniform(0, 2 * std::numbers::pi),
                   beta = uniform(0, 2 * std::numbers::pi);
      const double r = std::sqrt(1 - u), t = std::sqrt(u);
      const double a[4] = {r * std::sin(alpha), r * std::cos(alpha), t * std::sin(beta), t * std::cos(beta)};
      std::ranges::copy(a, q + joint.iq);
      for (int k = 4; k < Kind::nq; ++k) draw(joint.iq + k, 1);
    } else {
      for (int k = 0; k < Kind::nq; ++k) draw(joint.iq + k, k < Kind::angles ? std::numbers::pi : 1);
    }
  };
  for (; n > 0; --n, q += model.nq()) each_independent_joint(model, draw_joint);
  return all;
}
std::vector<double> random_configuration(const Model& model, std::uint64_t seed) {
  return random_configurations(model, seed, 1);
}

std::vector<double> normalize(const Model& model, std::span<const double> q) {
  check_size("q", q.size(), static_cast<std::size_t>(model.nq()), "nq");
  std::vector<double> out(q.begin(), q.end());
  for (const int i : model.tree<double>()->quaternion_bodies) {
    const Joint& joint = model.joint(i);
    double* a = &out[joint.iq];
    const double size = std::hypot(std::hypot(a[0], a[1]), std::hypot(a[2], a[3]));
    if (!(size > 0) || !std::isfinite(size))
      throw std::invalid_argument("q: the quaternion of joint \"" + joint.name + "\" has norm " +
                                  to_text(size) + "; it must be finite and not 0 to be normalised");
    for (int k = 0; k < 4; ++k) a[k] /= size;
  }
  return out;
}

std::vector<double> coordinate_rates(const Model& model, std::span<const double> q,
                                     std::span<const double> v) {
  check_configuration(model, q);
  check_size("v", v.size(), static_cast<std::size_t>(model.nv()), "nv");
  std::vector<double> out(q.size());
  each_independent_joint(
      model, [&](const auto& s, const Joint& joint) { s.rates(&q[joint.iq], &v[joint.iv], &out[joint.iq]); });
  check_finite(model, "v", &Joint::iq, &Joint::nq, out);
  return out;
}

std::vector<double> velocities_from_rates(const Model& model, std::span<const double> q,
                                          std::span<const double> dq) {
  check_configuration(model, q);
  check_size("dq", dq.size(), static_cast<std::size_t>(model.nq()), "nq");
  std::vector<double> out(model.nv());
  each_independent_joint(model, [&](const auto& s, const Joint& joint) {
    s.velocities(&q[joint.iq], &dq[joint.iq], &out[joint.iv]);
  });
  check_finite(model, "dq", &Joint::iv, &Joint::nv, out);
  return out;
}

std::vector<std::string> coordinate_names(const Model& model) { return numbered(model, &Joint::nq); }
std::vector<std::string> velocity_names(const Model& model) { return numbered(model, &Joint::nv); }

std::vector<double> velocity_limits(const Model& model) { return of_each_velocity(model, &Dof::velocity); }
std::vector<double> effort_limits(const Model& model) { return of_each_velocity(model, &Dof::effort); }

std::vector<double> integrate(const Model& model, std::span<const double> q, std::span<const double> dv) {
  check_configuration(model, q);
  check_size("dv", dv.size(), static_cast<std::size_t>(model.nv()), "nv");
  std::vector<double> out(q.size());
  each_independent_joint(model, [&](const auto& s, const Joint& joint) {
    s.integrate(&q[joint.iq], &dv[joint.iv], &out[joint.iq]);
  });
  check_finite(model, "dv", &Joint::iq, &Joint::nq, out);
  return out;
}

std::vector<double> difference(const Model& model, std::span<const double> q0, std::span<const double> q1) {
  check_configuration(model, q0, "q0");
  check_configuration(model, q1, "q1");
  std::vector<double> out(model.nv());
  each_independent_joint(model, [&](const auto& s, const Joint& joint) {
    s.difference(&q0[joint.iq], &q1[joint.iq], &out[joint.iv]);
  });
  check_finite(model, "q1 - q0", &Joint::iv, &Joint::nv, out);
  return out;
}

std::vector<double> interpolate(const Model& model, std::span<const double> q0, std::span<const double> q1,
                                double s) {
  std::vector<double> dv = difference(model, q0, q1);
  for (double& x : dv) x *= s;
  return integrate(model, q0, dv);
}

CoordinateLimits limits(const Model& model) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  CoordinateLimits out{std::vector<double>(model.nq(), -infinity), std::vector<double>(model.nq(), infinity)};
  each_independent_joint(model, [&](const auto& s, const Joint& joint) {
    const int shift = s.nq - s.nv;  // the rotation of a free joint has four coordinates and three velocities
    for (int d = (shift > 0 ? 3 : 0); d < s.nv; ++d) {
      out.lower[joint.iq + d + shift] = joint.dof[d].lower;
      out.upper[joint.iq + d + shift] = joint.dof[d].upper;
    }
  });
  return out;
}

std::vector<double> clamp(const Model& model, std::span<const double> q) {
  check_configuration(model, q);
  const CoordinateLimits limit = limits(model);
  std::vector<double> out(q.begin(), q.end());
  for (std::size_t k = 0; k < out.size(); ++k) out[k] = std::clamp(out[k], limit.lower[k], limit.upper[k]);
  return out;
}

}  // namespace axode
