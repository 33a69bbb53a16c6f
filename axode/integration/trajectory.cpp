#include "axode/integration/trajectory.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "axode/model/configuration.hpp"

namespace axode {

void Trajectory::append(double t, std::span<const double> q, std::span<const double> v,
                        std::span<const double> a, std::span<const double> tau) {
  t_.push_back(t);
  q_.insert(q_.end(), q.begin(), q.end());
  v_.insert(v_.end(), v.begin(), v.end());
  a_.insert(a_.end(), a.begin(), a.end());
  tau_.insert(tau_.end(), tau.begin(), tau.end());
}

void Trajectory::jump(std::span<const double> v, std::span<const double> a) {
  const std::size_t k = size() - 1;
  before_jumps_.try_emplace(k, this->a(k).begin(), this->a(k).end());
  std::ranges::copy(v, v_.end() - static_cast<std::ptrdiff_t>(v.size()));
  std::ranges::copy(a, a_.end() - static_cast<std::ptrdiff_t>(a.size()));
}

std::span<const double> Trajectory::a_before(std::size_t k) const {
  const auto jump = before_jumps_.find(k);
  return jump == before_jumps_.end() ? a(k) : std::span<const double>(jump->second);
}

void Trajectory::take_back() {
  before_jumps_.erase(size() - 1);
  t_.pop_back();
  q_.resize(q_.size() - nq()), v_.resize(v_.size() - nv()), a_.resize(a_.size() - nv());
  tau_.resize(tau_.size() - nv());
}

void Trajectory::at(double time, std::span<double> q_out, std::span<double> v_out,
                    std::span<double> a_out) const {
  check_size("q", q_out.size(), nq(), "nq");
  check_size("v", v_out.size(), nv(), "nv");
  if (!a_out.empty()) check_size("a", a_out.size(), nv(), "nv");
  if (t_.empty() || !(time >= t_.front() && time <= t_.back()))
    throw std::invalid_argument(
        "t is " + std::to_string(time) + "; the trajectory " +
        (t_.empty() ? std::string("is empty")
                    : "is from " + std::to_string(t_.front()) + " to " + std::to_string(t_.back()) + " s"));
  const auto after = std::upper_bound(t_.begin(), t_.end(), time);
  const std::size_t end = static_cast<std::size_t>(std::distance(t_.begin(), after)),
                    k = std::min(end - 1, t_.size() - 1);
  if (time == t_[k] || k + 1 == t_.size()) {
    std::ranges::copy(q(k), q_out.begin()), std::ranges::copy(v(k), v_out.begin());
    if (!a_out.empty()) std::ranges::copy(a(k), a_out.begin());
    return;
  }
  const double h = t_[k + 1] - t_[k], s = (time - t_[k]) / h;
  const ConfigurationGroup<double> group(model_.tree<double>());
  using Numbers = std::vector<double>;
  const std::span<const double> v_0 = v(k), a_0 = a(k), v_1 = v(k + 1), a_1 = a_before(k + 1);

  // The mean velocity z of the step, and the x at its second end.
  Numbers z(nv()), none(nv()), x(nv()), y(nv());
  for (std::size_t c = 0; c < nv(); ++c) z[c] = (v_0[c] + v_1[c]) / 2 + h * (a_0[c] - a_1[c]) / 12;
  group.noncommuting(z.data(), z.data());
  const auto move_along_z = [&](double t, std::span<double> q_z) {
    for (std::size_t c = 0; c < nv(); ++c) y[c] = t * z[c];
    group.move(q(k).data(), y.data(), q_z.data());
  };
  move_along_z(h, q_out);
  group.difference(q_out.data(), q(k + 1).data(), x.data());

  // z carried by x: Ad_{exp(-x)} z = z - [x, dexp_{-x} z].
  const auto carried = [&](const Numbers& x_t) {
    Numbers out(nv());
    group.velocity(x_t.data(), z.data(), out.data());
    group.bracket(x_t.data(), out.data(), out.data());
    for (std::size_t c = 0; c < nv(); ++c) out[c] = z[c] - out[c];
    return out;
  };
  // x' and x'' of an end, from v = Ad_{exp(-x)} z + u and a = u' - [u, Ad_{exp(-x)} z] with u = dexp_{-x} x'.
  const auto rates = [&](const Numbers& x_t, std::span<const double> v_t, std::span<const double> a_t) {
    const Numbers z_t = carried(x_t);
    Numbers dx(nv()), ddx(nv()), turning(nv());
    for (std::size_t c = 0; c < nv(); ++c) dx[c] = v_t[c] - z_t[c];
    group.bracket(dx.data(), z_t.data(), turning.data());
    group.rate(x_t.data(), dx.data(), dx.data());
    group.acceleration(x_t.data(), dx.data(), none.data(), ddx.data());
    for (std::size_t c = 0; c < nv(); ++c) ddx[c] = a_t[c] + turning[c] - ddx[c];
    group.rate(x_t.data(), ddx.data(), ddx.data());
    return std::pair(dx, ddx);
  };
  const auto [dx_0, ddx_0] = rates(none, v_0, a_0);
  const auto [dx_1, ddx_1] = rates(x, v_1, a_1);

  Numbers dy(nv()), ddy(nv());
  move_along_z(time - t_[k], q_out);
  const double s2 = s * s, s3 = s2 * s, s4 = s3 * s, s5 = s4 * s;
  for (std::size_t c = 0; c < nv(); ++c) {
    // y = p1 s + p2 s² + p3 s³ + p4 s⁴ + p5 s⁵ with the first two from the first end.
    const double p1 = h * dx_0[c], p2 = h * h * ddx_0[c] / 2;
    const double A = x[c] - p1 - p2, B = h * dx_1[c] - p1 - 2 * p2, C = h * h * ddx_1[c] - 2 * p2;
    const double p3 = 10 * A - 4 * B + C / 2, p4 = -15 * A + 7 * B - C, p5 = 6 * A - 3 * B + C / 2;
    y[c] = p1 * s + p2 * s2 + p3 * s3 + p4 * s4 + p5 * s5;
    dy[c] = (p1 + 2 * p2 * s + 3 * p3 * s2 + 4 * p4 * s3 + 5 * p5 * s4) / h;
    ddy[c] = (2 * p2 + 6 * p3 * s + 12 * p4 * s2 + 20 * p5 * s3) / (h * h);
  }
  const Numbers z_t = carried(y);
  group.move(q_out.data(), y.data(), q_out.data());
  if (!a_out.empty()) group.acceleration(y.data(), dy.data(), ddy.data(), a_out.data());
  group.velocity(y.data(), dy.data(), v_out.data());
  group.bracket(v_out.data(), z_t.data(), ddy.data());
  for (std::size_t c = 0; c < nv(); ++c) v_out[c] += z_t[c];
  for (std::size_t c = 0; c < a_out.size(); ++c) a_out[c] -= ddy[c];
}

}  // namespace axode
