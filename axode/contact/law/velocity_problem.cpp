#include "axode/contact/law/velocity_problem.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace axode {

/// Calls f for each group of consecutive blocks of constraint rows that act on the same velocities. The
/// arguments of f are the first block of the group, the number of rows of the group, and the number of
/// velocities: a compile-time constant if this is 6, 9 or 12, otherwise 0.
template <class F> void VelocityProblem::each_group(const F& f) const noexcept {
  for (std::size_t k = 0; k < blocks_.size();) {
    const Block& first = blocks_[k];
    int rows = 0;
    for (; k < blocks_.size() && blocks_[k].support == first.support; ++k) rows += blocks_[k].rows;
    switch (first.width) {
      case 6: f(first, rows, std::integral_constant<int, 6>{}); break;
      case 9: f(first, rows, std::integral_constant<int, 9>{}); break;
      case 12: f(first, rows, std::integral_constant<int, 12>{}); break;
      default: f(first, rows, std::integral_constant<int, 0>{});
    }
  }
}

void VelocityProblem::reserve(std::size_t blocks) {
  const std::size_t rows = blocks * LawBlock::most_rows, width = static_cast<std::size_t>(nv());
  blocks_.reserve(blocks);
  supports_.reserve(blocks * width);
  Y_.reserve(rows * width);
  for (std::vector<double>* x : {&r, &c, &d2_}) x->reserve(rows);
  moves_.reserve(rows);
}

void VelocityProblem::clear(int compliances) {
  w.resize(joint_velocities_ + compliances);
  w.tail(compliances).setZero();
  blocks_.clear();
  supports_.clear();
  Y_.clear();
  for (std::vector<double>* x : {&r, &c, &d2_}) x->clear();
  moves_.clear();
}

double* VelocityProblem::add(ContactLaw law, int rows, std::span<const int> support, double bound,
                             bool compliant) {
  Block b;
  b.law = law;
  b.first = this->rows();
  b.rows = rows;
  b.bound = bound;
  const bool repeated = !blocks_.empty() && std::ranges::equal(support, this->support(blocks_.back()));
  b.support = repeated ? blocks_.back().support : supports_.size();
  b.width = static_cast<int>(support.size());
  b.columns = Y_.size();
  b.compliances = compliant ? 1 : 0;
  if (!repeated) supports_.insert(supports_.end(), support.begin(), support.end());
  const std::size_t m = r.size() + static_cast<std::size_t>(rows);
  Y_.resize(Y_.size() + support.size() * static_cast<std::size_t>(rows));
  r.resize(m, 0.0);
  c.resize(m, 1.0);
  d2_.resize(m, 0.0);
  moves_.resize(m, 1);
  blocks_.push_back(b);
  return Y_.data() + b.columns;
}

void VelocityProblem::finish() noexcept {
  double greatest = 1e-300;
  std::ranges::fill(moves_, 1);
  for (const Block& b : blocks_) {
    Eigen::Map<Eigen::MatrixXd> Y(Y_.data() + b.columns, b.width, b.rows);
    for (int k = 0; k < b.rows; ++k) {
      const std::size_t row = static_cast<std::size_t>(b.first + k);
      Y.col(k) *= c[row];
      r[row] *= c[row];
    }
    const double d2 = scale(b);
    std::fill_n(d2_.begin() + b.first, b.rows, d2);
    greatest = std::max(greatest, d2);
  }
  // A row of a loop that repeats a joint of the tree has only rounding errors in Y: it moves nothing and is
  // left out.
  constexpr double rounding = 1e-20, least = 1e-12;
  for (const Block& b : blocks_) {
    const std::size_t row = static_cast<std::size_t>(b.first);
    if (b.law != ContactLaw::loop || d2_[row] > rounding * greatest) continue;
    std::fill_n(Y_.begin() + static_cast<std::ptrdiff_t>(b.columns), b.width, 0.0);
    r[row] = 0;
    moves_[row] = 0;
  }
  for (double& x : d2_) x = std::max(x, least * greatest);
  for (const Block& b : blocks_)
    if (b.law == ContactLaw::pressed)
      for (std::size_t k = 0; k < support(b).size(); ++k) w[support(b)[k]] += b.bound * Y_[b.columns + k];
}

/// d² of a block (D11.6).
double VelocityProblem::scale(const Block& b) const noexcept {
  const auto Y = columns(b);
  const double normal = Y.col(0).squaredNorm();
  double largest = normal;
  for (int k = 1; k < b.rows; ++k) largest = std::max(largest, Y.col(k).squaredNorm());
  return std::max(normal, largest / 2);
}

void VelocityProblem::set_compliance(const Block& b, double C) noexcept {
  Y_[b.columns + static_cast<std::size_t>(b.width) - 1] = std::sqrt(C);
  std::fill_n(d2_.begin() + b.first, b.rows, scale(b));
}

double VelocityProblem::compliance(const Block& b) const noexcept {
  return std::pow(Y_[b.columns + static_cast<std::size_t>(b.width) - 1], 2);
}

void VelocityProblem::complete(double* lambda) const noexcept {
  for (const Block& b : blocks_)
    if (b.law == ContactLaw::pressed) lambda[b.first] = b.bound;
}

void VelocityProblem::add_product(double factor, const double* lambda, double* x) const noexcept {
  each_group([&](const Block& first, int rows, auto size) {
    const int* const at = supports_.data() + first.support;
    const double* Y = Y_.data() + first.columns;
    if constexpr (size() > 0) {
      using Column = Eigen::Vector<double, size()>;
      Column sum = Column::Zero();
      for (int k = 0; k < rows; ++k, Y += size())
        sum += lambda[first.first + k] * Eigen::Map<const Column>(Y);
      for (int i = 0; i < size(); ++i) x[at[i]] += factor * sum[i];
    } else {
      for (int k = 0; k < rows; ++k, Y += first.width) {
        const double l = factor * lambda[first.first + k];
        for (int i = 0; i < first.width; ++i) x[at[i]] += l * Y[i];
      }
    }
  });
}

void VelocityProblem::add_transposed(const double* x, double* u) const noexcept {
  each_group([&](const Block& first, int rows, auto size) {
    const int* const at = supports_.data() + first.support;
    const double* Y = Y_.data() + first.columns;
    if constexpr (size() > 0) {
      using Column = Eigen::Vector<double, size()>;
      Column part;
      for (int i = 0; i < size(); ++i) part[i] = x[at[i]];
      for (int k = 0; k < rows; ++k, Y += size()) u[first.first + k] += Eigen::Map<const Column>(Y).dot(part);
    } else {
      for (int k = 0; k < rows; ++k, Y += first.width) {
        double sum = 0;
        for (int i = 0; i < first.width; ++i) sum += Y[i] * x[at[i]];
        u[first.first + k] += sum;
      }
    }
  });
}

void VelocityProblem::delassus(Eigen::Ref<Eigen::MatrixXd> G) const noexcept {
  for (const Block& a : blocks_)
    for (const Block& b : blocks_) {
      if (b.first < a.first) continue;
      const int *i = supports_.data() + a.support, *j = supports_.data() + b.support;
      const auto A = columns(a), B = columns(b);
      auto G_ab = G.block(a.first, b.first, a.rows, b.rows);
      G_ab.setZero();
      for (int m = 0, n = 0; m < a.width && n < b.width;) {
        if (i[m] < j[n]) {
          ++m;
        } else if (j[n] < i[m]) {
          ++n;
        } else {
          for (int k = 0; k < b.rows; ++k)
            for (int l = 0; l < a.rows; ++l) G_ab(l, k) += A(m, l) * B(n, k);
          ++m;
          ++n;
        }
      }
      if (a.first != b.first) G.block(b.first, a.first, b.rows, a.rows) = G_ab.transpose();
    }
}

double certificate_of(const VelocityProblem& p, const double* residual, const double* t) noexcept {
  using Vector = Eigen::Map<const Eigen::VectorXd>;
  const Vector left(residual, p.rows()), d2(p.squared_scales().data(), p.rows()), motion(t, p.nv());
  const double size = p.w.norm() + motion.norm();
  constexpr double least = 1e-140, most = 1e140;  // squares of numbers beyond these vanish or overflow
  if (size > least && size < most) return std::sqrt((d2.array() * left.array().square()).sum()) / size;
  const double largest = std::max(p.w.lpNorm<Eigen::Infinity>(), motion.lpNorm<Eigen::Infinity>());
  if (largest == 0) return left.isZero(0) ? 0 : std::numeric_limits<double>::infinity();
  return (d2.array().sqrt() * left.array() / largest).matrix().norm() /
         ((p.w / largest).norm() + (motion / largest).norm());
}

double certificate(const VelocityProblem& p, const double* lambda, double* scratch) noexcept {
  const int m = p.rows();
  double *const u = scratch, *const z = scratch + m, *const t = scratch + 2 * m;
  std::fill_n(t, p.nv(), 0.0);
  p.add_product(1, lambda, t);
  std::copy_n(p.r.data(), m, u);
  p.add_transposed(p.w.data(), u);
  p.add_transposed(t, u);
  for (int k = 0; k < m; ++k) z[k] = lambda[k] - u[k] / p.squared_scales()[static_cast<std::size_t>(k)];
  for (const VelocityProblem::Block& b : p.blocks()) resolve(b, z + b.first, u + b.first);
  for (int k = 0; k < m; ++k) u[k] = lambda[k] - u[k];
  return certificate_of(p, u, t);
}

}  // namespace axode
