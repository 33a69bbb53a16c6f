#include "axode/contact/law/sparse_factor.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <bit>
#include <cmath>

#include "axode/scalar/index.hpp"

namespace axode {
namespace {

/// Largest number of columns of a node, a set of columns that are eliminated together, if it is merged from
/// several clusters (sets of columns with the same sparsity pattern).
constexpr int most_columns = 48;

/// A matrix whose columns begin `stride` numbers apart and are filled up to whole tiles.
struct Panel {
  const double* entries;
  int rows, stride;
};

/// Computes out = P Qᵀ for P and Q with n columns, in small square blocks (tiles). The columns of `out` begin
/// padded(P.rows) numbers apart, the number of rows rounded up to whole tiles. If `lower`, tiles above the
/// diagonal are left out.
void multiply(const Panel& P, const Panel& Q, int n, double* out, bool lower) noexcept {
  constexpr int size = SparseFactor::tile;
  const int stride = SparseFactor::padded(P.rows);
  using Tile = Eigen::Matrix<double, size, size>;
  using Part = Eigen::Map<const Eigen::Matrix<double, size, 1>>;
  for (int j = 0; j < Q.rows; j += size)
    for (int i = lower ? j : 0; i < P.rows; i += size) {
      Tile sum = Tile::Zero();
      for (int k = 0; k < n; ++k)
        sum += Part(P.entries + i + k * P.stride).lazyProduct(Part(Q.entries + j + k * Q.stride).transpose());
      Eigen::Map<Tile, 0, Eigen::OuterStride<>>(out + i + j * stride, Eigen::OuterStride<>(stride)) = sum;
    }
}

}  // namespace

void SparseFactor::reserve(int n, int groups) {
  const std::size_t size = index(n), entries = index(groups) * size, padding = index(2 * tile);
  const bool reserved = !size_.empty();  // an empty matrix needs memory for one cluster
  if (reserved && index_.size() >= size && group_indices_.capacity() >= entries) return;
  for (std::vector<int>* x : {&group_end_, &known_end_}) x->reserve(index(groups));
  for (std::vector<int>* x : {&group_indices_, &known_indices_}) x->reserve(entries);
  for (std::vector<int>* x : {&cluster_of_, &members_, &rank_, &index_, &node_of_, &pivot_, &local_})
    x->resize(size);
  for (std::vector<int>* x : {&size_, &members_in_group_, &renamed_, &touched_, &degree_, &order_, &position_,
                              &merged_from_, &node_columns_, &first_member_})
    x->resize(size + 2);
  adjacent_.resize((size + 1) * ((size + 64) / 64));
  nodes_.reserve(size);
  groups_.reserve(index(groups));
  for (std::vector<int>* x : {&list_, &source_}) x->reserve(entries + size * size);
  values_.resize((2 * size + 2 * padding) * size);
  product_.resize((size + padding) * (size + padding));
  for (std::vector<double>* x : {&x_, &below_}) x->resize(size + padding);
}

void SparseFactor::begin(int n) noexcept {
  n_ = n;
  group_end_.clear();
  group_indices_.clear();
}

void SparseFactor::add_group(std::span<const int> indices) noexcept {
  group_indices_.insert(group_indices_.end(), indices.begin(), indices.end());
  group_end_.push_back(static_cast<int>(group_indices_.size()));
}

bool SparseFactor::analyse() noexcept {
  if (n_ == known_n_ && group_end_ == known_end_ && group_indices_ == known_indices_) return false;
  known_n_ = n_;
  known_end_ = group_end_;
  known_indices_ = group_indices_;
  find_clusters();
  order_clusters();
  merge_clusters();
  make_nodes();
  make_lists();
  return true;
}

/// Finds the clusters: the sets of matrix indices that occur in the same given groups. All indices are one
/// cluster at first, and each group splits the clusters of which it has only a part.
void SparseFactor::find_clusters() noexcept {
  std::fill_n(cluster_of_.begin(), n_, 0);
  size_[0] = n_ + 1;  // one more than its members, so that no group has all of cluster 0
  clusters_ = 1;
  std::ranges::fill(members_in_group_, 0);
  int first = 0;
  for (const int end : group_end_) {
    const std::span<const int> group = std::span(group_indices_).subspan(index(first), index(end - first));
    int touched = 0;
    for (const int i : group) {
      const int c = cluster_of_[index(i)];
      if (members_in_group_[index(c)]++ == 0) touched_[index(touched++)] = c;
    }
    for (int k = 0; k < touched; ++k) {
      const int c = touched_[index(k)], members = members_in_group_[index(c)];
      renamed_[index(c)] = c;
      members_in_group_[index(c)] = 0;
      if (members == size_[index(c)]) continue;
      size_[index(c)] -= members;
      size_[index(clusters_)] = members;
      renamed_[index(c)] = clusters_++;
    }
    for (const int i : group) cluster_of_[index(i)] = renamed_[index(cluster_of_[index(i)])];
    first = end;
  }
  std::fill_n(first_member_.begin(), clusters_ + 1, 0);
  for (int i = 0; i < n_; ++i) ++first_member_[index(cluster_of_[index(i)] + 1)];
  for (int c = 0; c < clusters_; ++c) first_member_[index(c + 1)] += first_member_[index(c)];
  std::copy_n(first_member_.begin(), clusters_, touched_.begin());
  for (int i = 0; i < n_; ++i) members_[index(touched_[index(cluster_of_[index(i)])]++)] = i;
}

template <class F> void SparseFactor::each_adjacent(int cluster, const F& f) noexcept {
  const std::uint64_t* const row = adjacent(cluster);
  for (int w = 0; w < words_; ++w)
    for (std::uint64_t bits = row[w]; bits != 0; bits &= bits - 1) f(64 * w + std::countr_zero(bits));
}

/// Chooses the order in which clusters of matrix indices are eliminated. A cluster has the indices that occur
/// in the same given groups, and two clusters are adjacent if the matrix, with its fill-in, has entries
/// between them. The next cluster is always one with the least number of adjacent clusters that are not
/// eliminated yet. Afterwards the bits of adjacent_ for a cluster name the adjacent clusters that are
/// eliminated after it.
void SparseFactor::order_clusters() noexcept {
  words_ = clusters_ / 64 + 1;
  std::fill_n(adjacent_.begin(), clusters_ * words_, 0);
  int first = 0;
  for (const int end : group_end_) {
    for (int a = first; a < end; ++a) {
      std::uint64_t* const row = adjacent(cluster_of_[index(group_indices_[index(a)])]);
      for (int b = first; b < end; ++b) {
        const int c = cluster_of_[index(group_indices_[index(b)])];
        row[c / 64] |= std::uint64_t{1} << (c % 64);
      }
    }
    first = end;
  }
  const auto count = [&](int c) {
    std::uint64_t* const row = adjacent(c);
    row[c / 64] &= ~(std::uint64_t{1} << (c % 64));
    int degree = 0;
    for (int w = 0; w < words_; ++w) degree += std::popcount(row[w]);
    degree_[index(c)] = degree;
  };
  for (int c = 1; c < clusters_; ++c) count(c);
  std::fill_n(position_.begin(), clusters_, -1);
  for (int k = 0; k < clusters_ - 1; ++k) {
    int least = -1;
    for (int c = 1; c < clusters_; ++c)
      if (position_[index(c)] < 0 && (least < 0 || degree_[index(c)] < degree_[index(least)])) least = c;
    position_[index(least)] = k;
    order_[index(k)] = least;
    const std::uint64_t* const eliminated = adjacent(least);
    each_adjacent(least, [&](int c) {
      std::uint64_t* const row = adjacent(c);
      for (int w = 0; w < words_; ++w) row[w] |= eliminated[w];
      row[least / 64] &= ~(std::uint64_t{1} << (least % 64));
      count(c);
    });
  }
}

/// Merges clusters, which are sets of columns with the same sparsity pattern, so that they are eliminated
/// together. When cluster c is eliminated, its columns have entries in the rows of clusters that are
/// eliminated later; let d be the first of these. Cluster c is merged into d if no cluster has been merged
/// into d yet, if the columns of c and of d have entries in the same rows after those of d, and if there are
/// not more than most_columns columns in all.
void SparseFactor::merge_clusters() noexcept {
  std::vector<int>& below = degree_;
  for (int c = 1; c < clusters_; ++c) {
    below[index(c)] = 0;
    each_adjacent(c, [&](int d) { below[index(c)] += size_[index(d)]; });
    merged_from_[index(c)] = -1;
    node_columns_[index(c)] = size_[index(c)];
  }
  for (int k = 0; k < clusters_ - 1; ++k) {
    const int c = order_[index(k)];
    int next = -1;
    each_adjacent(c, [&](int d) {
      if (next < 0 || position_[index(d)] < position_[index(next)]) next = d;
    });
    if (next < 0 || below[index(c)] != node_columns_[index(next)] + below[index(next)] ||
        node_columns_[index(c)] + node_columns_[index(next)] > most_columns)
      continue;
    node_columns_[index(next)] += node_columns_[index(c)];
    node_columns_[index(c)] = 0;  // it is no node of its own
    merged_from_[index(next)] = c;
  }
}

void SparseFactor::make_nodes() noexcept {
  nodes_.clear();
  std::size_t size = 0;
  int rank = 0;
  cost_ = 0;
  for (int k = 0; k < clusters_ - 1; ++k) {
    const int last = order_[index(k)];
    if (node_columns_[index(last)] == 0) continue;
    Node node;
    node.first = rank;
    node.columns = node_columns_[index(last)];
    node.below.count = degree_[index(last)];
    // The clusters of the node in descending order of elimination.
    int end = rank + node.columns;
    for (int c = last; c >= 0; c = merged_from_[index(c)]) {
      end -= size_[index(c)];
      for (int i = 0; i < size_[index(c)]; ++i) {
        const int at = members_[index(first_member_[index(c)] + i)];
        rank_[index(at)] = end + i;
        index_[index(end + i)] = at;
        node_of_[index(end + i)] = static_cast<int>(nodes_.size());
      }
    }
    rank += node.columns;
    node.stride_of_U = padded(node.below.count);
    node.stride = node.columns + node.stride_of_U;
    node.L = size;
    node.U = size + index(node.stride * node.columns);
    size = node.U + index(node.stride_of_U * node.columns);
    const double rows = node.columns + node.below.count;
    cost_ += node.columns * rows * rows;
    position_[index(last)] = static_cast<int>(nodes_.size());
    nodes_.push_back(node);
    touched_[nodes_.size() - 1] = last;
  }
}

void SparseFactor::make_lists() noexcept {
  list_.clear();
  source_.clear();
  for (std::size_t k = 0; k < nodes_.size(); ++k) {
    List& below = nodes_[k].below;
    below.first = static_cast<int>(list_.size());
    each_adjacent(touched_[k], [&](int c) {
      for (int i = 0; i < size_[index(c)]; ++i)
        list_.push_back(rank_[index(members_[index(first_member_[index(c)] + i)])]);
    });
    std::sort(list_.begin() + below.first, list_.end());
    for (int i = 0; i < below.count; ++i) source_.push_back(i);
  }
  groups_.clear();
  int first = 0;
  for (const int end : group_end_) {
    const int start = static_cast<int>(list_.size());
    groups_.push_back({start, end - first});
    const auto rank = [&](int i) { return rank_[index(group_indices_[index(first + i)])]; };
    for (int i = 0; i < end - first; ++i) source_.push_back(i);
    std::sort(source_.begin() + start, source_.end(), [&](int i, int j) { return rank(i) < rank(j); });
    for (int i = 0; i < end - first; ++i) list_.push_back(rank(source_[index(start + i)]));
    first = end;
  }
}

void SparseFactor::clear(bool symmetric) noexcept {
  symmetric_ = symmetric;
  if (nodes_.empty()) return;
  const Node& last = nodes_.back();
  std::fill_n(values_.begin(), last.U + index(last.stride_of_U * last.columns), 0.0);
  for (const Node& node : nodes_)
    for (int k = 0; k < node.columns; ++k) values_[node.L + index(k * (node.stride + 1))] = 1;
}

void SparseFactor::add(int group, const double* P, const double* Q, int columns) noexcept {
  const List& list = groups_[index(group)];
  const int stride = padded(list.count);
  multiply({P, list.count, stride}, {Q, list.count, stride}, columns, product_.data(), false);
  scatter(list, product_.data(), stride, 1);
}

void SparseFactor::scatter(const List& list, const double* A, int stride, double sign) noexcept {
  const int *const rank = list_.data() + list.first, *const source = source_.data() + list.first;
  int* const local = local_.data();
  for (int begin = 0, end = 0; begin < list.count; begin = end) {
    const int at = node_of_[index(rank[begin])];
    const Node& node = nodes_[index(at)];
    for (end = begin; end < list.count && node_of_[index(rank[end])] == at; ++end)
      local[end] = rank[end] - node.first;
    const int* const below = list_.data() + node.below.first;
    for (int i = end, row = 0; i < list.count; ++i, ++row) {
      while (below[row] != rank[i]) ++row;
      local[i] = row;
    }
    for (int j = begin; j < end; ++j) {
      double* const L = values_.data() + node.L + local[j] * node.stride;
      const double* const column = A + source[j] * stride;
      for (int i = symmetric_ ? j : begin; i < end; ++i) L[local[i]] += sign * column[source[i]];
      for (int i = end; i < list.count; ++i) L[node.columns + local[i]] += sign * column[source[i]];
      if (symmetric_) continue;
      double* const U = values_.data() + node.U + local[j] * node.stride_of_U;
      const double* const row = A + source[j];
      for (int i = end; i < list.count; ++i) U[local[i]] += sign * row[source[i] * stride];
    }
  }
}

void SparseFactor::factorize() noexcept {
  negative_ = false;
  for (const Node& node : nodes_) {
    symmetric_ ? eliminate_symmetric(node) : eliminate(node);
    const int below = node.below.count;
    if (below == 0) continue;
    const Panel L{values_.data() + node.L + node.columns, below, node.stride};
    const Panel U{values_.data() + node.U, below, node.stride_of_U};
    multiply(L, symmetric_ ? L : U, node.columns, product_.data(), symmetric_);
    scatter(node.below, product_.data(), node.stride_of_U, -1);
  }
}

/// Eliminates the columns of a node, which is a set of consecutive columns, by Gauss' elimination with
/// exchanges of rows within the node. Let D be the square block of the matrix in the rows and columns of the
/// node. The elimination computes the factors of P D = L U with a permutation P, the rows of L below this
/// block, and the columns of U to the right of it. These numbers overwrite the entries of the matrix.
void SparseFactor::eliminate(const Node& node) noexcept {
  const int columns = node.columns, below = node.below.count, rows = columns + below;
  double* const L = values_.data() + node.L;
  double* const U = values_.data() + node.U;
  for (int k = 0; k < columns; ++k) {
    double* const column = L + k * node.stride;
    int pivot = k;
    for (int r = k + 1; r < columns; ++r)
      if (std::abs(column[r]) > std::abs(column[pivot])) pivot = r;
    pivot_[index(node.first + k)] = pivot;
    if (pivot != k) {
      for (int j = 0; j < columns; ++j) std::swap(L[k + j * node.stride], L[pivot + j * node.stride]);
      std::swap_ranges(U + k * node.stride_of_U, U + k * node.stride_of_U + below,
                       U + pivot * node.stride_of_U);
      negative_ = !negative_;
    }
    if (column[k] < 0) negative_ = !negative_;
    const double inverse = 1 / column[k];
    for (int r = k + 1; r < rows; ++r) column[r] *= inverse;
    const double* const U_k = U + k * node.stride_of_U;
    for (int j = k + 1; j < columns; ++j) {
      double* const other = L + j * node.stride;
      const double in_row = other[k];
      for (int r = k + 1; r < rows; ++r) other[r] -= in_row * column[r];
      double* const U_j = U + j * node.stride_of_U;
      const double in_column = column[j];
      for (int r = 0; r < below; ++r) U_j[r] -= in_column * U_k[r];
    }
  }
}

/// Eliminates the columns of a node, which is a set of consecutive columns, by Cholesky's factorisation L Lᵀ
/// of the matrix. The columns of L overwrite the columns of the matrix.
void SparseFactor::eliminate_symmetric(const Node& node) noexcept {
  const int columns = node.columns, rows = columns + node.below.count;
  for (int k = 0; k < columns; ++k) {
    double* const column = values_.data() + node.L + k * node.stride;
    const double inverse = 1 / std::sqrt(column[k]);
    for (int r = k; r < rows; ++r) column[r] *= inverse;
    for (int j = k + 1; j < columns; ++j) {
      double* const other = values_.data() + node.L + j * node.stride;
      const double factor = column[j];
      for (int r = j; r < rows; ++r) other[r] -= factor * column[r];
    }
  }
}

void SparseFactor::solve(double* x) noexcept {
  const int ranks = nodes_.empty() ? 0 : nodes_.back().first + nodes_.back().columns;
  for (int r = 0; r < ranks; ++r) x_[index(r)] = x[index_[index(r)]];
  for (const Node& node : nodes_) solve_forward(node);
  for (auto node = nodes_.rbegin(); node != nodes_.rend(); ++node) solve_backward(*node);
  for (int r = 0; r < ranks; ++r) x[index_[index(r)]] = x_[index(r)];
}

void SparseFactor::solve_forward(const Node& node) noexcept {
  const int columns = node.columns, below = node.below.count;
  double* const x = x_.data() + node.first;
  if (!symmetric_)
    for (int k = 0; k < columns; ++k) std::swap(x[k], x[pivot_[index(node.first + k)]]);
  std::fill_n(below_.begin(), below, 0.0);
  for (int k = 0; k < columns; ++k) {
    const double* const L = values_.data() + node.L + k * node.stride;
    if (symmetric_) x[k] /= L[k];
    for (int r = k + 1; r < columns; ++r) x[r] -= L[r] * x[k];
    for (int r = 0; r < below; ++r) below_[index(r)] += L[columns + r] * x[k];
  }
  for (int r = 0; r < below; ++r) x_[index(list_[index(node.below.first + r)])] -= below_[index(r)];
}

void SparseFactor::solve_backward(const Node& node) noexcept {
  const int columns = node.columns, below = node.below.count;
  double* const x = x_.data() + node.first;
  for (int r = 0; r < below; ++r) below_[index(r)] = x_[index(list_[index(node.below.first + r)])];
  for (int k = columns - 1; k >= 0; --k) {
    const double* const L = values_.data() + node.L + k * node.stride;
    const double* const right = symmetric_ ? L + columns : values_.data() + node.U + k * node.stride_of_U;
    double sum = 0;
    for (int r = 0; r < below; ++r) sum += right[r] * below_[index(r)];
    for (int r = k + 1; r < columns; ++r)
      sum += (symmetric_ ? L[r] : values_[node.L + index(k + r * node.stride)]) * x[r];
    x[k] = (x[k] - sum) / L[k];
  }
}

}  // namespace axode
