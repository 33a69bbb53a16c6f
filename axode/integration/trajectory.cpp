#include "axode/integration/trajectory.hpp"

#include <algorithm>
#include <stdexcept>

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

  // x, x' and x'' of both ends. At the first x = 0, so that x' = v and x'' = a; at the second
  // x'' is the derivative of x' = dexp⁻¹_{-x} v = v + [x, v]/2 + [x, [x, v]]/12.
  using Numbers = std::vector<double>;
  const std::span<const double> v_0 = v(k), a_0 = a(k), v_1 = v(k + 1), a_1 = a_before(k + 1);
  Numbers x(nv()), dx(nv()), ddx(a_1.begin(), a_1.end());
  group.difference(q(k).data(), q(k + 1).data(), x.data());
  group.rate(x.data(), v_1.data(), dx.data());
  if (!group.commutes()) {
    const auto bracket = [&](const Numbers& y, std::span<const double> z) {
      Numbers out(nv());
      group.bracket(y.data(), z.data(), out.data());
      return out;
    };
    const Numbers dx_v = bracket(dx, v_1), x_a = bracket(x, a_1), x_v = bracket(x, v_1);
    const Numbers one = bracket(dx, x_v), two = bracket(x, dx_v), three = bracket(x, x_a);
    for (std::size_t c = 0; c < nv(); ++c)
      ddx[c] += (dx_v[c] + x_a[c]) / 2 + (one[c] + two[c] + three[c]) / 12;
  }

  Numbers y(nv()), dy(nv()), ddy(nv());
  const double s2 = s * s, s3 = s2 * s, s4 = s3 * s, s5 = s4 * s;
  for (std::size_t c = 0; c < nv(); ++c) {
    // y = p1 s + p2 s² + p3 s³ + p4 s⁴ + p5 s⁵ with the first two from the first end.
    const double p1 = h * v_0[c], p2 = h * h * a_0[c] / 2;
    const double A = x[c] - p1 - p2, B = h * dx[c] - p1 - 2 * p2, C = h * h * ddx[c] - 2 * p2;
    const double p3 = 10 * A - 4 * B + C / 2, p4 = -15 * A + 7 * B - C, p5 = 6 * A - 3 * B + C / 2;
    y[c] = p1 * s + p2 * s2 + p3 * s3 + p4 * s4 + p5 * s5;
    dy[c] = (p1 + 2 * p2 * s + 3 * p3 * s2 + 4 * p4 * s3 + 5 * p5 * s4) / h;
    ddy[c] = (2 * p2 + 6 * p3 * s + 12 * p4 * s2 + 20 * p5 * s3) / (h * h);
  }
  group.move(q(k).data(), y.data(), q_out.data());
  group.velocity(y.data(), dy.data(), v_out.data());
  if (!a_out.empty()) group.acceleration(y.data(), dy.data(), ddy.data(), a_out.data());
}

}  // namespace axode
