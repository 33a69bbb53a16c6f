#include "axode/constraints/embedding/drive_elimination.hpp"

#include "axode/recursion/instantiate.hpp"

namespace axode {

template <class T>
DriveElimination<T>::DriveElimination(const Model& model, const LoopTable& table)
    : table_(table), limbs_(limbs_of(model, table.paths)), parts_(limbs_.limbs.size()) {
  const std::size_t nv = index(model.nv()), carrying = limbs_.carrying.size();
  driven_.assign(nv, 2);  // 2 is neither flag, so that the first call sorts the velocities
  column_.resize(nv);
  carries_.resize(nv);
  for (const int c : limbs_.carrying) carries_[index(c)] = 1;
  carrying_passive_.reserve(carrying);
  carrying_active_.reserve(carrying);
  std::size_t rows = 0;
  for (std::size_t l = 0; l < parts_.size(); ++l) {
    const Limb& limb = limbs_.limbs[l];
    Part& part = parts_[l];
    std::size_t columns = 0;
    for (const int k : limb.loops) {
      const LoopPath& path = table.paths[index(k)];
      for (int r = 0; r < path.rows.count; ++r) part.rows.push_back(path.rows.first + r);
      columns += path.columns.size();
    }
    part.columns.reserve(columns);
    part.passive.reserve(limb.velocities.size());
    part.active.reserve(limb.velocities.size());
    part.matrix.reserve(part.rows.size(), limb.velocities.size() + carrying);
    part.mu.resize(part.rows.size());
    rows += part.rows.size();
  }
  remaining_.reserve(rows, carrying);
  b_.resize(std::max(nv, carrying));
  nu_.resize(rows);
  x_.resize(rows);
  forces_.resize(nv);
  basis_.resize((std::min(rows, nv) + 1) * nv);
}

template <class T>
bool DriveElimination<T>::solve(const std::vector<std::vector<T>>& entries, const T& considerable,
                                const char* driven, const T* f, T* tau, T* lambda) noexcept {
  sort_velocities(driven);
  for (const int c : limbs_.outside)
    if (driven_[index(c)] == 0) return false;
  if (!eliminate_limbs(entries, considerable, f) || !eliminate_carrying(considerable, f)) return false;
  const bool unique = remaining_.rows() == remaining_.rank();
  if (!unique && lambda != nullptr) return false;
  std::copy_n(f, forces_.size(), forces_.data());
  subtract_rows(false, forces_.data());
  if (!unique && !take_least(considerable, forces_.data())) return false;
  for (std::size_t c = 0; c < forces_.size(); ++c) tau[c] = driven_[c] != 0 ? forces_[c] : T(0);
  if (lambda == nullptr) return true;
  for (Part& part : parts_) {
    part.matrix.multipliers(part.mu.data(), x_.data());
    for (std::size_t i = 0; i < part.rows.size(); ++i) lambda[part.rows[i]] = x_[i];
  }
  return true;
}

template <class T> void DriveElimination<T>::sort_velocities(const char* driven) noexcept {
  if (std::equal(driven_.begin(), driven_.end(), driven)) return;
  std::copy_n(driven, driven_.size(), driven_.begin());
  const auto sort = [&](const std::vector<int>& velocities, std::vector<int>& passive,
                        std::vector<int>& active) {
    passive.clear();
    active.clear();
    for (const int c : velocities) (driven[c] != 0 ? active : passive).push_back(c);
    int column = 0;
    for (const std::vector<int>* part : {&passive, &active})
      for (const int c : *part) column_[index(c)] = column++;
  };
  sort(limbs_.carrying, carrying_passive_, carrying_active_);
  for (std::size_t l = 0; l < parts_.size(); ++l) {
    Part& part = parts_[l];
    sort(limbs_.limbs[l].velocities, part.passive, part.active);
    part.columns.clear();
    for (const int k : limbs_.limbs[l].loops)
      for (const LoopColumn& column : table_.paths[index(k)].columns) {
        const std::size_t c = index(column.velocity);
        part.columns.push_back(carries_[c] != 0 ? carrying_column(part) + column_[c] : column_[c]);
      }
  }
}

template <class T>
bool DriveElimination<T>::eliminate_limbs(const std::vector<std::vector<T>>& entries, const T& considerable,
                                          const T* f) noexcept {
  for (std::size_t l = 0; l < parts_.size(); ++l) {
    Part& part = parts_[l];
    const int p = size(part.passive);
    part.matrix.reset(size(part.rows), p);
    int row = 0;
    const int* next = part.columns.data();
    for (const int k : limbs_.limbs[l].loops) {
      const LoopPath& path = table_.paths[index(k)];
      const T* entry = entries[index(k)].data();
      for (std::size_t c = 0; c < path.columns.size(); ++c, ++next)
        for (int r = 0; r < path.rows.count; ++r) part.matrix.row(row + r)[*next] += *entry++;
      row += path.rows.count;
    }
    if (!part.matrix.run(considerable) || part.matrix.rank() < p) return false;
    for (int j = 0; j < p; ++j) b_[index(j)] = f[part.passive[index(j)]];
    part.matrix.solve_transposed(b_.data(), part.mu.data());
  }
  return true;
}

template <class T> bool DriveElimination<T>::eliminate_carrying(const T& considerable, const T* f) noexcept {
  const int s = size(carrying_passive_);
  int rows = 0;
  for (const Part& part : parts_) rows += part.matrix.rows() - part.matrix.rank();
  remaining_.reset(rows, s);
  for (int j = 0; j < s; ++j) b_[index(j)] = f[carrying_passive_[index(j)]];
  T largest = considerable;
  int next = 0;
  for (const Part& part : parts_) {
    const int first = carrying_column(part);
    for (int i = 0; i < part.matrix.rows(); ++i) {
      const T* const a = part.matrix.row(i) + first;
      for (int j = 0; j < s; ++j) largest = std::max(largest, std::abs(a[j]));
      if (i < part.matrix.rank())
        for (int j = 0; j < s; ++j) b_[index(j)] -= a[j] * part.mu[index(i)];
      else
        std::copy_n(a, s, remaining_.row(next++));
    }
  }
  if (!remaining_.run(largest) || remaining_.rank() < s) return false;
  std::fill_n(nu_.begin(), rows, T(0));
  remaining_.solve_transposed(b_.data(), nu_.data());
  set_remaining(nu_.data());
  return true;
}

template <class T> void DriveElimination<T>::set_remaining(T* nu) noexcept {
  remaining_.multipliers(nu, x_.data());
  std::size_t next = 0;
  for (Part& part : parts_)
    for (int i = part.matrix.rank(); i < part.matrix.rows(); ++i) part.mu[index(i)] = x_[next++];
}

template <class T> T DriveElimination<T>::subtract_rows(bool only_remaining, T* forces) const noexcept {
  T most(0);
  for (const Part& part : parts_) {
    const int p = size(part.passive), d = size(part.active), s = size(carrying_passive_);
    for (int i = only_remaining ? part.matrix.rank() : 0; i < part.matrix.rows(); ++i) {
      const T mu = part.mu[index(i)];
      const T* const a = part.matrix.row(i) + p;
      const auto subtract = [&](int c, const T& entry) {
        forces[c] -= entry * mu;
        most = std::max(most, std::abs(entry * mu));
      };
      for (int j = 0; j < d; ++j) subtract(part.active[index(j)], a[j]);
      for (std::size_t j = 0; j < carrying_active_.size(); ++j)
        subtract(carrying_active_[j], a[index(d + s) + j]);
    }
  }
  return most;
}

template <class T> bool DriveElimination<T>::take_least(const T& considerable, T* forces) noexcept {
  const std::size_t nv = forces_.size();
  const auto project = [&](const T* e, T* x) {
    T along(0);
    for (std::size_t c = 0; c < nv; ++c) along += e[c] * x[c];
    for (std::size_t c = 0; c < nv; ++c) x[c] -= along * e[c];
  };
  const auto norm = [&](const T* x) {
    T square(0);
    for (std::size_t c = 0; c < nv; ++c) square += x[c] * x[c];
    return std::sqrt(square);
  };
  for (std::size_t c = 0; c < nv; ++c)
    if (driven_[c] == 0) forces[c] = T(0);
  std::size_t found = 0;
  for (int i = remaining_.rank(); i < remaining_.rows(); ++i) {
    std::fill_n(nu_.begin(), remaining_.rows(), T(0));
    nu_[index(i)] = T(1);
    set_remaining(nu_.data());
    T* const x = basis_.data() + found * nv;
    std::fill_n(x, nv, T(0));
    const T size = std::max(considerable, subtract_rows(true, x));
    for (int twice = 0; twice < 2; ++twice)
      for (std::size_t k = 0; k < found; ++k) project(basis_.data() + k * nv, x);
    const T rest = norm(x);
    if (rest <= RowElimination<T>::rounding * size) continue;
    if (!(rest > RowElimination<T>::certain * size)) return false;
    for (std::size_t c = 0; c < nv; ++c) x[c] /= rest;
    project(x, forces);
    ++found;
  }
  return true;
}

template class DriveElimination<AXODE_T>;

}  // namespace axode
