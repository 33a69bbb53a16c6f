#include "axode/integration/trajectory.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "axode/eigen.hpp"
#include "axode/model/configuration.hpp"
#include "axode/scalar/text.hpp"

namespace axode {

void Trajectory::append(double t, std::span<const double> q, std::span<const double> v,
                        std::span<const double> a, std::span<const double> tau, std::span<const double> x,
                        std::span<const double> dx) {
  t_.push_back(t);
  q_.insert(q_.end(), q.begin(), q.end());
  v_.insert(v_.end(), v.begin(), v.end());
  a_.insert(a_.end(), a.begin(), a.end());
  tau_.insert(tau_.end(), tau.begin(), tau.end());
  x_.insert(x_.end(), x.begin(), x.end());
  dx_.insert(dx_.end(), dx.begin(), dx.end());
}

void Trajectory::jump(std::span<const double> v, std::span<const double> a, std::span<const double> x,
                      std::span<const double> dx) {
  const std::size_t k = size() - 1;
  const auto vector_of = [](std::span<const double> all) { return std::vector(all.begin(), all.end()); };
  before_jumps_.try_emplace(k, Rates{vector_of(this->v(k)), vector_of(this->a(k)), vector_of(this->dx(k))});
  const auto replace_end = [](std::vector<double>& all, std::span<const double> by) {
    std::ranges::copy(by, all.end() - static_cast<std::ptrdiff_t>(by.size()));
  };
  replace_end(v_, v);
  replace_end(a_, a);
  replace_end(x_, x);
  replace_end(dx_, dx);
}

std::span<const double> Trajectory::v_before(std::size_t k) const {
  const auto jump = before_jumps_.find(k);
  return jump == before_jumps_.end() ? v(k) : std::span<const double>(jump->second.v);
}

std::span<const double> Trajectory::a_before(std::size_t k) const {
  const auto jump = before_jumps_.find(k);
  return jump == before_jumps_.end() ? a(k) : std::span<const double>(jump->second.a);
}

std::span<const ContactForce> Trajectory::contacts(std::size_t k) const {
  if (k >= contacts_end_.size()) return {};
  const std::size_t begin = k == 0 ? 0 : contacts_end_[k - 1];
  return std::span(contacts_).subspan(begin, contacts_end_[k] - begin);
}

std::span<const ContactForce> Trajectory::contacts_at(double time) const {
  const auto end = std::ranges::lower_bound(t_, time);
  return contacts(static_cast<std::size_t>(end - t_.begin()));
}

void Trajectory::set_contacts(std::span<const ContactForce> contacts) {
  if (contacts_end_.size() == size()) contacts_end_.pop_back();
  contacts_.resize(contacts_end_.empty() ? 0 : contacts_end_.back());
  contacts_end_.resize(size() - 1, contacts_.size());
  contacts_.insert(contacts_.end(), contacts.begin(), contacts.end());
  contacts_end_.push_back(contacts_.size());
}

void Trajectory::pop_back() {
  if (contacts_end_.size() == size()) contacts_end_.pop_back();
  contacts_.resize(contacts_end_.empty() ? 0 : contacts_end_.back());
  before_jumps_.erase(size() - 1);
  t_.pop_back();
  q_.resize(q_.size() - nq());
  v_.resize(v_.size() - nv());
  a_.resize(a_.size() - nv());
  tau_.resize(tau_.size() - nv());
  x_.resize(x_.size() - nx());
  dx_.resize(dx_.size() - nx());
}

std::size_t Trajectory::step_at(double time) const {
  if (t_.empty() || !(time >= t_.front() && time <= t_.back()))
    throw std::invalid_argument(
        "t is " + to_text(time) + "; the trajectory " +
        (t_.empty() ? std::string("is empty")
                    : "is from " + to_text(t_.front()) + " to " + to_text(t_.back()) + " s"));
  const auto after = std::upper_bound(t_.begin(), t_.end(), time);
  const std::size_t end = static_cast<std::size_t>(std::distance(t_.begin(), after));
  return std::min(end - 1, t_.size() - 1);
}

void Trajectory::drive_states_at(double time, std::span<double> x_out) const {
  check_size("x", x_out.size(), nx(), "the number of states of the drives");
  const std::size_t k = step_at(time);
  if (time == t_[k] || k + 1 == t_.size()) {
    std::ranges::copy(x(k), x_out.begin());
    return;
  }
  const auto jump = before_jumps_.find(k + 1);
  const std::span<const double> dx_1 =
      jump == before_jumps_.end() ? dx(k + 1) : std::span<const double>(jump->second.dx);
  const double h = t_[k + 1] - t_[k], s = (time - t_[k]) / h, r = 1 - s;
  for (std::size_t c = 0; c < nx(); ++c)
    x_out[c] = r * r * ((1 + 2 * s) * x(k)[c] + s * h * dx(k)[c]) +
               s * s * ((1 + 2 * r) * x(k + 1)[c] - r * h * dx_1[c]);
}

void Trajectory::at(double time, std::span<double> q_out, std::span<double> v_out,
                    std::span<double> a_out) const {
  check_size("q", q_out.size(), nq(), "nq");
  check_size("v", v_out.size(), nv(), "nv");
  if (!a_out.empty()) check_size("a", a_out.size(), nv(), "nv");
  const std::size_t k = step_at(time);
  if (time == t_[k] || k + 1 == t_.size()) {
    std::ranges::copy(q(k), q_out.begin());
    std::ranges::copy(v(k), v_out.begin());
    if (!a_out.empty()) std::ranges::copy(a(k), a_out.begin());
    return;
  }
  const double h = t_[k + 1] - t_[k], s = (time - t_[k]) / h;
  const ConfigurationGroup<double> group(model_.tree<double>());
  using Vector = Eigen::VectorXd;
  const Eigen::Index n = model_.nv();
  const auto v_0 = as_eigen(v(k)), a_0 = as_eigen(a(k)), v_1 = as_eigen(v_before(k + 1)),
             a_1 = as_eigen(a_before(k + 1));

  // Computes the mean velocity z of the step, and the value of x(t) at the end of the step.
  Vector z = (v_0 + v_1) / 2 + h * (a_0 - a_1) / 12, x(n), y(n);
  group.noncommuting(z, z);
  const auto move_along_z = [&](double t) {
    y = t * z;
    group.move(q(k), y, q_out);
  };
  move_along_z(h);
  group.difference(q_out, q(k + 1), x);

  // Computes Ad_{exp(-x)} z = z - [x, dexp_{-x} z].
  const auto carried = [&](const Vector& x_t) -> Vector {
    Vector turned(n);
    group.velocity(x_t, z, turned);
    group.bracket(x_t, turned, turned);
    return z - turned;
  };
  // Computes x' and x'' at one end of the step, from v = Ad_{exp(-x)} z + u and a = u' - [u, Ad_{exp(-x)} z]
  // with u = dexp_{-x} x'.
  const Vector none = Vector::Zero(n);
  const auto rates = [&](const Vector& x_t, const auto& v_t, const auto& a_t) {
    const Vector z_t = carried(x_t);
    Vector dx = v_t - z_t, ddx(n), turning(n);
    group.bracket(dx, z_t, turning);
    group.rate(x_t, dx, dx);
    group.acceleration(x_t, dx, none, ddx);
    ddx = a_t + turning - ddx;
    group.rate(x_t, ddx, ddx);
    return std::pair(dx, ddx);
  };
  const auto [dx_0, ddx_0] = rates(none, v_0, a_0);
  const auto [dx_1, ddx_1] = rates(x, v_1, a_1);

  // The quintic is y = p1 s + p2 s² + p3 s³ + p4 s⁴ + p5 s⁵, where p1 and p2 follow from the start of the
  // step.
  move_along_z(time - t_[k]);
  const Vector p1 = h * dx_0, p2 = h * h / 2 * ddx_0;
  const Vector A = x - p1 - p2, B = h * dx_1 - p1 - 2 * p2, C = h * h * ddx_1 - 2 * p2;
  const Vector p3 = 10 * A - 4 * B + C / 2, p4 = -15 * A + 7 * B - C, p5 = 6 * A - 3 * B + C / 2;
  y = s * (p1 + s * (p2 + s * (p3 + s * (p4 + s * p5))));
  const Vector dy = (p1 + s * (2 * p2 + s * (3 * p3 + s * (4 * p4 + s * 5 * p5)))) / h;
  const Vector ddy = (2 * p2 + s * (6 * p3 + s * (12 * p4 + s * 20 * p5))) / (h * h);
  const Vector z_t = carried(y);
  Vector turning(n);
  group.move(q_out, y, q_out);
  if (!a_out.empty()) group.acceleration(y, dy, ddy, a_out);
  group.velocity(y, dy, v_out);
  group.bracket(v_out, z_t, turning);
  as_eigen(v_out) += z_t;
  if (!a_out.empty()) as_eigen(a_out) -= turning;
}

}  // namespace axode
