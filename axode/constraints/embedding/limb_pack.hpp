#pragma once
#include <algorithm>
#include <array>
#include <vector>

#include "axode/constraints/loops/loop_table.hpp"
#include "axode/fast/lanes.hpp"
#include "axode/scalar/index.hpp"

namespace axode {

/// The numbers that limbs (the chains that carry a platform) must have in common to be computed together.
struct LimbShape {
  int rows = 0;       ///< number of loop equations
  int dependent = 0;  ///< number of velocities that follow from the others; those without a drive come first
  int passive = 0;    ///< number of dependent velocities without a drive
  int inner = 0;      ///< number of other velocities of the limb
  /// Whether the mass matrix of the spanning tree couples the limb with the joint between the ground and the
  /// platform, because bodies of the limb are in the subtree of this joint.
  bool coupled = false;
  bool operator==(const LimbShape&) const = default;
};

/// Up to `width` limbs (chains that carry the platform) with the same numbers of equations and velocities,
/// one in each SIMD lane: their loop equations, and their parts of the equations of motion in task space
/// ((D18.2) to (D18.11)). The matrix of a limb's loop equations has columns for three kinds of velocities:
/// the dependent ones, which the equations determine; the inner ones, the other velocities of the limb, which
/// neither the equations nor the platform determine; and the carrying ones. The carrying velocities are those
/// of the joint that connects the platform to the ground in the spanning tree, most often a free joint. Lanes
/// without a limb have an identity matrix in the columns of the dependent velocities, so that their pivots
/// are 1. The number of lanes depends on the instruction set. All code that uses a pack must therefore be
/// compiled for the same instruction set.
class LimbPack {
  using L = Lanes<double>;
  using Number = L::Number;

 public:
  static constexpr int width = L::width;
  LimbShape shape;

  /// `carrying` is the number of carrying velocities, those of the joint that connects the platform to the
  /// ground in the spanning tree. `free` is the number of those that can be chosen independently under all
  /// loop equations, the degrees of freedom of the platform.
  LimbPack(const LimbShape& of, int carrying, int free)
      : shape(of),
        carrying_(carrying),
        free_(free),
        A_(of.rows * columns()),
        row_(of.rows),
        inverse_(of.dependent),
        b_(of.rows),
        x_(velocities()),
        idle_(1),
        F_(of.dependent * motions()),
        Q_(velocities() * motions()),
        M_(velocities() * velocities()),
        M_carrying_(of.coupled ? velocities() * carrying : 0),
        task_(motions() * motions()) {
    for (int l = 0; l < width; ++l) idle_.lane(0, l) = 1;
  }

  bool full() const { return size(limbs_) == width; }
  /// Adds the limb with the index `limb`, a chain that carries the platform. `velocities` has the indices of
  /// its velocities in the model, `rows` the indices of its loop equations among all loop equations of the
  /// model, and `loops` the indices of its loops. The matrix of the limb's loop equations has a column for
  /// each entry of `velocities`, in this order, followed by columns for the velocities of the joint between
  /// the ground and the platform. column(c) returns the index of the column for the velocity with the index c
  /// in the model.
  template <class Column>
  void add(int limb, const std::vector<int>& velocities, const std::vector<int>& rows,
           const std::vector<int>& loops, const LoopTable& table, const Column& column) {
    const int l = size(limbs_);
    idle_.lane(0, l) = 0;
    limbs_.push_back(limb);
    for (const int c : velocities) velocity_.push_back(c);
    for (const int r : rows) equation_.push_back(r);
    int row = 0;
    for (const int k : loops) {
      const LoopPath& path = table.paths[static_cast<std::size_t>(k)];
      loops_.push_back({k, static_cast<int>(path.columns.size()) * path.rows.count});
      for (const LoopColumn& of : path.columns)
        for (int r = 0; r < path.rows.count; ++r)
          target_.push_back(((row + r) * columns() + column(of.velocity)) * width + l);
      row += path.rows.count;
    }
  }
  const std::vector<int>& limbs() const { return limbs_; }
  int velocities() const { return shape.dependent + shape.inner; }
  /// The index of velocity j of the limb in lane l.
  int velocity(int l, int j) const { return velocity_[index(l * velocities() + j)]; }

  /// Reads the entries of the loop equations of each limb (a chain that carries the platform), and eliminates
  /// the limb's dependent velocities, which these equations determine. The pivot of a velocity is the largest
  /// entry of its column in the rows without a pivot. It must exceed `certain` times the larger of two
  /// numbers: the largest entry of the limb's equations at dependent velocities, and `considerable`, a
  /// magnitude of entries that are no rounding errors. Returns the index of a limb with too small a pivot; -1
  /// if there is none.
  int resolve(const std::vector<std::vector<double>>& entries, double considerable, double certain) noexcept {
    fill(entries);
    Number size(considerable);
    for (int i = 0; i < shape.rows; ++i)
      for (int j = 0; j < shape.dependent; ++j) size = larger(size, absolute(a(i, j)));
    size = certain * size;
    for (int k = 0; k < shape.dependent; ++k) {
      for (int i = k + 1; i < shape.rows; ++i) exchange_if_larger(k, i);
      const auto sound = size < absolute(a(k, k));
      if (any(!sound))
        for (int l = 0; l < LimbPack::size(limbs_); ++l)
          if (!sound[index(l)]) return limbs_[index(l)];
      const Number inverse = Number(1) / a(k, k);
      inverse_.set(k, inverse);
      for (int i = k + 1; i < shape.rows; ++i) {
        const Number factor = a(i, k) * inverse;
        set_a(i, k, factor);
        for (int j = k + 1; j < columns(); ++j) set_a(i, j, a(i, j) - factor * a(k, j));
      }
    }
    return -1;
  }
  /// The entry, in row i of the loop equations of the limb in lane l, of velocity c of the joint between the
  /// ground and the platform, after resolve() has eliminated the limb's dependent velocities.
  double carrying_entry(int l, int i, int c) const { return A_.lane(i * columns() + velocities() + c, l); }

  /// Sets the right side -γ of the loop equations A x = -γ of the limbs (chains that carry the platform) in
  /// this pack, where x are joint velocities or accelerations and A is the Jacobian of the equations. `gamma`
  /// has γ for all m loop equations of the mechanism, or is null for γ = 0. The row operations with which
  /// resolve() has eliminated the dependent velocities from A are applied to the right side as well.
  void set_right_side(const double* gamma) noexcept {
    if (gamma == nullptr) return b_.clear();
    for (int l = 0; l < size(limbs_); ++l)
      for (int i = 0; i < shape.rows; ++i)
        b_.lane(i, l) = -gamma[equation_[index(l * shape.rows + static_cast<int>(row_.lane(i, l)))]];
    for (int k = 0; k < shape.dependent; ++k)
      for (int i = k + 1; i < shape.rows; ++i) b_.set(i, b_[i] - a(i, k) * b_[k]);
  }
  /// The right side of row i of the loop equations of the limb in lane l, after the elimination.
  double right_side(int l, int i) const { return b_.lane(i, l); }
  /// Computes the joint velocities, or accelerations, of all limbs (chains that carry the platform) and
  /// writes them to x (nv). `y` has the f task velocities, or their rates. The inner velocities of limb k,
  /// which the platform does not determine, begin at y[first_inner[k]]. `s` has the velocities, or
  /// accelerations, of the joint between the ground and the platform. The other velocities of a limb follow
  /// from the inner ones, from `s`, and from its loop equations with the right side of set_right_side().
  void expand(const double* y, const std::vector<int>& first_inner, const double* s, double* x) noexcept {
    for (int l = 0; l < size(limbs_); ++l)
      for (int j = 0; j < shape.inner; ++j)
        x_.lane(shape.dependent + j, l) = y[first_inner[index(limbs_[index(l)])] + j];
    for (int i = shape.dependent; i-- > 0;) {
      Number rest = b_[i];
      for (int j = i + 1; j < velocities(); ++j) rest -= a(i, j) * x_[j];
      for (int c = 0; c < carrying_; ++c) rest -= s[c] * a(i, velocities() + c);
      x_.set(i, rest * inverse_[i]);
    }
    for (int l = 0; l < size(limbs_); ++l)
      for (int j = 0; j < velocities(); ++j) x[velocity(l, j)] = x_.lane(j, l);
  }

  /// Computes the rows of the matrix F of v = F V (D18.6), which maps task velocities V to joint velocities
  /// v, for the dependent velocities of each limb (a chain that carries the platform): those that the loop
  /// equations determine. A limb has columns for the task velocities of the platform, followed by its inner
  /// velocities, which the platform does not determine. N, with `stride` numbers in each row, maps the task
  /// velocities of the platform to the velocities of the joint that connects the platform to the ground in
  /// the spanning tree.
  void make_F(const double* N, int stride) noexcept {
    for (int i = shape.dependent; i-- > 0;) {
      for (int t = 0; t < free_; ++t) {
        Number sum(0);
        for (int c = 0; c < carrying_; ++c) sum -= N[c * stride + t] * a(i, velocities() + c);
        F_.set(i * motions() + t, sum);
      }
      for (int t = 0; t < shape.inner; ++t) F_.set(i * motions() + free_ + t, -a(i, shape.dependent + t));
      for (int t = 0; t < motions(); ++t) {
        Number sum = F_[i * motions() + t];
        for (int j = i + 1; j < shape.dependent; ++j) sum -= a(i, j) * F_[j * motions() + t];
        F_.set(i * motions() + t, sum * inverse_[i]);
      }
    }
  }
  /// The entry of F, which maps task velocities to joint velocities, for velocity j and column t of the limb
  /// in lane l.
  double F(int l, int j, int t) const {
    return j < shape.dependent ? F_.lane(j * motions() + t, l) : (t - free_ == j - shape.dependent ? 1 : 0);
  }
  int motions() const { return free_ + shape.inner; }

  /// Computes the part Fᵀ M F of each limb (a chain that carries the platform) in the mass matrix of the task
  /// space (D18.11). F maps task velocities to joint velocities, and M (nv × nv) is the mass matrix of the
  /// spanning tree. If shape.coupled is set, the part includes the entries of M for a velocity of the limb
  /// and one of the joint between the ground and the platform. `carrying` has the indices of the velocities
  /// of this joint, and N, with `stride` numbers in each row, maps task velocities to them.
  void make_M(const double* M, int nv, const std::vector<int>& carrying, const double* N,
              int stride) noexcept {
    const int n = velocities(), d = shape.dependent, m = motions();
    for (int l = 0; l < size(limbs_); ++l) {
      for (int i = 0; i < n; ++i)
        for (int j = 0; j <= i; ++j)
          M_.lane(i * n + j, l) = M_.lane(j * n + i, l) = M[velocity(l, i) * nv + velocity(l, j)];
      if (shape.coupled)
        for (int i = 0; i < n; ++i)
          for (int c = 0; c < carrying_; ++c)
            M_carrying_.lane(i * carrying_ + c, l) = M[velocity(l, i) * nv + carrying[index(c)]];
    }
    for (int i = 0; i < n; ++i)  // Q = M F
      for (int t = 0; t < m; ++t) {
        Number sum = t < free_ ? Number(0) : M_[i * n + d + t - free_];
        for (int j = 0; j < d; ++j) sum += M_[i * n + j] * F_[j * m + t];
        Q_.set(i * m + t, sum);
      }
    set_product(Q_, m, true);
    if (!shape.coupled) return;
    for (int i = 0; i < n; ++i)  // Q = M N for the carrying velocities
      for (int t = 0; t < free_; ++t) {
        Number sum(0);
        for (int c = 0; c < carrying_; ++c) sum += N[c * stride + t] * M_carrying_[i * carrying_ + c];
        Q_.set(i * m + t, sum);
      }
    set_product(Q_, free_, false);
  }
  /// Adds the parts of all limbs that make_M() computed to the mass matrix in task space, f × f.
  void add_M(const std::vector<int>& first_inner, double* out, int f) const noexcept {
    const int m = motions();
    for (int r = 0; r < free_; ++r)
      for (int t = r; t < free_; ++t) {
        const double sum = sum_of(task_[r * m + t]);
        out[r * f + t] += sum;
        if (t > r) out[t * f + r] += sum;
      }
    if (shape.inner == 0) return;
    for (int l = 0; l < size(limbs_); ++l) {
      const int first = first_inner[index(limbs_[index(l)])];
      const auto task = [&](int t) { return t < free_ ? t : first + t - free_; };
      for (int r = 0; r < m; ++r)
        for (int t = r < free_ ? free_ : 0; t < m; ++t)
          out[task(r) * f + task(t)] += task_.lane(r * m + t, l);
    }
  }
  /// Adds Fᵀ w (f numbers) for w (nv) to `out`, where F maps task velocities to joint velocities.
  void project(const double* w, const std::vector<int>& first_inner, double* out) noexcept {
    const int m = motions();
    for (int l = 0; l < size(limbs_); ++l) {
      for (int j = 0; j < velocities(); ++j) x_.lane(j, l) = w[velocity(l, j)];
      for (int j = 0; j < shape.inner; ++j)
        out[first_inner[index(limbs_[index(l)])] + j] += x_.lane(shape.dependent + j, l);
    }
    for (int t = 0; t < m; ++t) {
      Number sum(0);
      for (int j = 0; j < shape.dependent; ++j) sum += F_[j * m + t] * x_[j];
      if (t < free_) {
        out[t] += sum_of(sum);
        continue;
      }
      for (int l = 0; l < size(limbs_); ++l)
        out[first_inner[index(limbs_[index(l)])] + t - free_] += sum[index(l)];
    }
  }

  /// Computes multipliers of the loop equations that are pivot rows of the dependent velocities without a
  /// drive, that is, from which the elimination determines these velocities. The constraint forces of these
  /// rows supply the joint forces f (nv) that the motion needs at the velocities without a drive (D18.7).
  /// `carrying` contains the joint forces that the motion needs at the velocities of the platform's joint on
  /// the ground. The constraint forces of the pivot rows at these velocities are subtracted from it, so that
  /// it ends with the forces that the other loop equations must supply (D18.8).
  void subtract_passive(const double* f, double* carrying) noexcept {
    for (int l = 0; l < size(limbs_); ++l)
      for (int j = 0; j < shape.passive; ++j) x_.lane(j, l) = f[velocity(l, j)];
    for (int j = 0; j < shape.passive; ++j) {
      Number rest = x_[j];
      for (int i = 0; i < j; ++i) rest -= a(i, j) * b_[i];
      b_.set(j, rest * inverse_[j]);
    }
    for (int c = 0; c < carrying_; ++c) {
      Number sum(0);
      for (int i = 0; i < shape.passive; ++i) sum += a(i, velocities() + c) * b_[i];
      carrying[c] -= sum_of(sum);
    }
  }
  void set_multiplier(int l, int i, double x) noexcept { b_.lane(i, l) = x; }
  /// Computes the drive forces τ (nv) in all limbs: the joint forces f (nv) that the motion needs, minus the
  /// constraint forces of all loop equations for their multipliers (D18.9). At the velocities without a drive
  /// τ is set to 0.
  void subtract_rows(const double* f, double* tau) noexcept {
    for (int l = 0; l < size(limbs_); ++l)
      for (int j = 0; j < velocities(); ++j) x_.lane(j, l) = j < shape.passive ? 0 : f[velocity(l, j)];
    for (int j = shape.passive; j < velocities(); ++j) {
      Number rest = x_[j];
      const int last = j < shape.dependent ? j : shape.rows - 1;  // entries below a pivot are factors
      for (int i = 0; i <= last; ++i) rest -= a(i, j) * b_[i];
      x_.set(j, rest);
    }
    for (int l = 0; l < size(limbs_); ++l)
      for (int j = 0; j < velocities(); ++j) tau[velocity(l, j)] = x_.lane(j, l);
  }

 private:
  static int size(const std::vector<int>& of) { return static_cast<int>(of.size()); }

  /// Numbers for each lane.
  class Array {
   public:
    explicit Array(int n) : x_(index(n) * width) {}
    Number operator[](int k) const { return L::load(x_.data() + index(k) * width); }
    void set(int k, const Number& to) { L::store(to, x_.data() + index(k) * width); }
    double& lane(int k, int l) { return x_[index(k) * width + index(l)]; }
    double lane(int k, int l) const { return x_[index(k) * width + index(l)]; }
    double* data() { return x_.data(); }
    void clear() { std::ranges::fill(x_, 0.0); }

   private:
    std::vector<double> x_;
  };

  int columns() const { return velocities() + carrying_; }
  Number a(int i, int j) const { return A_[i * columns() + j]; }
  void set_a(int i, int j, const Number& to) { A_.set(i * columns() + j, to); }
  static Number absolute(const Number& x) { return select(x < Number(0), -x, x); }
  static Number larger(const Number& x, const Number& y) { return select(x < y, y, x); }
  /// The sum over all limbs. Numbers are 0 in lanes without a limb.
  static double sum_of(const Number& x) {
    std::array<double, width> lanes;
    L::store(x, lanes.data());
    for (std::size_t half = width / 2; half > 0; half /= 2)
      for (std::size_t l = 0; l < half; ++l) lanes[l] += lanes[l + half];
    return lanes[0];
  }

  void fill(const std::vector<std::vector<double>>& entries) noexcept {
    A_.clear();
    double* const out = A_.data();
    const int* to = target_.data();
    for (const auto& [loop, count] : loops_) {
      const double* const from = entries[index(loop)].data();
      for (int e = 0; e < count; ++e) out[to[e]] += from[e];
      to += count;
    }
    for (int k = 0; k < shape.dependent; ++k) set_a(k, k, a(k, k) + idle_[0]);
    for (int i = 0; i < shape.rows; ++i) row_.set(i, Number(i));
  }
  /// Exchanges rows k and i in the lanes in which row i has the larger entry in column k.
  void exchange_if_larger(int k, int i) noexcept {
    const auto is_larger = absolute(a(k, k)) < absolute(a(i, k));
    const auto exchange = [&](Array& of, int at_k, int at_i) {
      const Number x = of[at_k], y = of[at_i];
      of.set(at_k, select(is_larger, y, x));
      of.set(at_i, select(is_larger, x, y));
    };
    for (int j = 0; j < columns(); ++j) exchange(A_, k * columns() + j, i * columns() + j);
    exchange(row_, k, i);
  }
  /// Computes the product Fᵀ Q for each limb (a chain that carries the platform), a part of the mass matrix
  /// of the task space. F maps task velocities to the velocities of the limb, and Q has `n` columns. If
  /// `first` is set, Q is M F with the mass matrix M of the limb's velocities, and the symmetric product is
  /// stored. Otherwise, Q is M_c N, and the product and its transpose are added to the stored matrix. M_c has
  /// the entries of the mass matrix of the spanning tree for one velocity of the limb and one of the joint
  /// between the ground and the platform; they are not 0 if the limb has bodies in the subtree of this joint.
  /// N maps the task velocities of the platform to the velocities of this joint.
  void set_product(const Array& Q, int n, bool first) noexcept {
    const int m = motions();
    const auto product = [&](int r, int t) {
      Number sum = r < free_ ? Number(0) : Q[(shape.dependent + r - free_) * m + t];
      for (int j = 0; j < shape.dependent; ++j) sum += F_[j * m + r] * Q[j * m + t];
      return sum;
    };
    for (int r = 0; r < m; ++r)
      for (int t = first ? r : 0; t < n; ++t) {
        const Number x = product(r, t);
        if (first) {
          task_.set(r * m + t, x);
          task_.set(t * m + r, x);
        } else {
          task_.set(r * m + t, task_[r * m + t] + x);
          task_.set(t * m + r, task_[t * m + r] + x);
        }
      }
  }

  int carrying_, free_;
  std::vector<int> limbs_;
  std::vector<int> velocity_, equation_;    ///< for each limb: its velocities, and its loop equations
  std::vector<std::pair<int, int>> loops_;  ///< loops of all limbs, and their numbers of entries
  std::vector<int> target_;                 ///< position of each of these entries in A_
  Array A_;        ///< loop equations; after the elimination with its factors below the pivots
  Array row_;      ///< original index of each row
  Array inverse_;  ///< inverse of each pivot
  Array b_, x_;    ///< right side or multipliers of the rows; velocities or forces
  Array idle_;     ///< 1 in lanes without a limb
  Array F_, Q_, M_, M_carrying_, task_;
};

}  // namespace axode
