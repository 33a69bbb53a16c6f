#pragma once
#include <cstdint>
#include <span>
#include <vector>

namespace axode {

/// Factorises matrices A = 1 + Σ_g E_g A_g E_gᵀ, where E_g selects a set of indices: a group g adds a dense
/// matrix A_g to the rows and columns of its indices. Indices that occur in the same groups form a cluster,
/// and clusters are eliminated in an order of least degree. Consecutive clusters with entries in the same
/// rows below them form a node, whose columns are stored as one dense panel (a supernodal method). Rows are
/// exchanged for pivots only within a node.
///
/// The order of elimination depends on the groups alone and is kept while they remain the same. Indices that
/// occur in no group have rows of the identity.
class SparseFactor {
 public:
  /// Size of the square tiles in which matrices are multiplied, and to which their columns are filled up.
  static constexpr int tile = 4;
  static constexpr int padded(int n) { return (n + tile - 1) / tile * tile; }

  /// Allocates memory for matrices of size n with up to `groups` groups.
  void reserve(int n, int groups);

  /// Begins the list of the groups of a matrix of size n.
  void begin(int n) noexcept;
  /// Appends a group, given by its indices in ascending order.
  void add_group(std::span<const int> indices) noexcept;
  /// Ends the list of groups of indices; finds the order of elimination if the groups have changed, and
  /// returns whether they have. Factors of earlier matrices are then lost.
  bool analyse() noexcept;
  /// The approximate number of multiplications of a factorisation, for the groups of the last analyse().
  double cost() const { return cost_; }

  /// Sets A to the identity. `symmetric` says whether all A_g will be symmetric.
  void clear(bool symmetric) noexcept;
  /// Adds the matrix A_g = P Qᵀ to the rows and columns of one group of indices. P and Q have a row for each
  /// index of the group and `columns` columns. Columns begin padded(rows) numbers apart, the number of rows
  /// rounded up to whole tiles (small square blocks).
  void add(int group, const double* P, const double* Q, int columns) noexcept;
  /// Factorises A, which must be positive definite if it was declared symmetric. If it is singular or not
  /// positive definite, solve() gives numbers that are not finite.
  void factorize() noexcept;
  /// Computes x := A⁻¹ x (n numbers), after factorize().
  void solve(double* x) noexcept;
  /// Whether the determinant of A is negative, after factorize().
  bool is_negative() const { return negative_; }

 private:
  /// A range of entries of list_ and source_, in the order of elimination.
  struct List {
    int first = 0, count = 0;
  };
  /// Columns that are eliminated together, and the rows below them in which they have entries.
  struct Node {
    int columns = 0;
    int first = 0;  ///< rank of the first column
    List below;     ///< ranks of the rows below the columns
    int stride = 0, stride_of_U = 0;
    std::size_t L = 0;  ///< first of (columns + below) × columns numbers in values_
    std::size_t U = 0;  ///< first of below × columns numbers in values_: the rows right of L, transposed
  };

  void find_clusters() noexcept;
  void order_clusters() noexcept;
  void merge_clusters() noexcept;
  void make_nodes() noexcept;
  void make_lists() noexcept;
  std::uint64_t* adjacent(int cluster) noexcept {
    return adjacent_.data() + static_cast<std::size_t>(cluster) * static_cast<std::size_t>(words_);
  }
  template <class F> void each_adjacent(int cluster, const F& f) noexcept;

  /// Adds `sign` times a matrix to A at the rows and columns of a list of indices. The columns of the matrix
  /// begin `stride` numbers apart.
  void scatter(const List& list, const double* A, int stride, double sign) noexcept;
  void eliminate(const Node& node) noexcept;
  void eliminate_symmetric(const Node& node) noexcept;
  void solve_forward(const Node& node) noexcept;
  void solve_backward(const Node& node) noexcept;

  int n_ = 0, known_n_ = -1;
  double cost_ = 0;
  bool symmetric_ = true, negative_ = false;
  std::vector<int> group_end_, group_indices_;  ///< the groups
  std::vector<int> known_end_, known_indices_;  ///< the groups of the last order of elimination
  // Clusters. Cluster 0 has the indices that occur in no group.
  int clusters_ = 0, words_ = 0;
  std::vector<int> cluster_of_;  ///< cluster of each index
  std::vector<int> size_, members_in_group_, renamed_, touched_, degree_, order_, position_, merged_from_,
      node_columns_, first_member_, members_;
  std::vector<std::uint64_t> adjacent_;  ///< a bit for each pair of clusters
  // Nodes, in the order of elimination.
  std::vector<Node> nodes_;
  std::vector<List> groups_;
  std::vector<int> list_;    ///< ranks
  std::vector<int> source_;  ///< row and column of each entry of list_ in the matrix that is added
  std::vector<int> rank_;    ///< position of each index in the order of elimination
  std::vector<int> index_, node_of_, pivot_, local_;  ///< entries by rank
  std::vector<double> values_, product_, x_, below_;
};

}  // namespace axode
