#pragma once
#include <cstdint>
#include <span>
#include <vector>

namespace axode {

/// Factorises matrices A = 1 + Σ_g E_g A_g E_gᵀ, where a group g adds a dense matrix A_g to the rows and
/// columns of a set of indices. Indices that occur in the same groups form a cluster. Clusters are eliminated
/// in an order of least degree; consecutive clusters with the same rows below them form a node, whose panel
/// is dense (a supernodal method). Hence the cost grows with the fill-in alone: linearly along a stack of
/// bodies or with the branches of a tree. Rows are exchanged for pivots within a node only.
///
/// The order depends on the groups alone and is kept while they stay the same. Indices that occur in no group
/// keep their rows of the identity.
class SparseFactor {
 public:
  /// Products are computed in square tiles of this size, and columns are filled up to whole tiles.
  static constexpr int tile = 4;
  static constexpr int padded(int n) { return (n + tile - 1) / tile * tile; }

  /// Allocates for matrices of size n with up to a number of groups.
  void reserve(int n, int groups);

  /// Begins the list of the groups of a matrix of size n.
  void begin(int n) noexcept;
  /// Appends a group of ascending indices.
  void add_group(std::span<const int> indices) noexcept;
  /// Ends the list of groups. Finds the order of elimination if the groups are not those of the last call.
  void analyse() noexcept;
  /// Number of multiplications of a factorisation, about, if the groups are as in the last analyse().
  double cost() const { return cost_; }

  /// Sets A to the identity. `symmetric` says whether all A_g will be symmetric.
  void clear(bool symmetric) noexcept;
  /// Adds A_g = P Qᵀ of a group. P and Q have a row for each index of the group and `columns` columns, which
  /// begin padded(rows) numbers apart.
  void add(int group, const double* P, const double* Q, int columns) noexcept;
  /// Factorises A. A symmetric A must be positive definite. If A is singular or not positive definite,
  /// solve() gives numbers that are not finite.
  void factorize() noexcept;
  /// x := A⁻¹ x.
  void solve(double* x) noexcept;
  /// Whether the determinant of A is negative, after factorize().
  bool is_negative() const { return negative_; }

 private:
  /// Entries of list_ and source_, in ascending order of their ranks.
  struct List {
    int first = 0, count = 0;
  };
  /// Columns that are eliminated together, and the rows that they still meet.
  struct Node {
    int columns = 0;
    int first = 0;  ///< rank of the first column
    List below;     ///< ranks of the rows below the columns
    int stride = 0, stride_of_U = 0;
    std::size_t L = 0;  ///< place in values_ of (columns + below) × columns numbers
    std::size_t U = 0;  ///< place in values_ of below × columns numbers: the transposed rows right of L
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

  /// Adds sign times a matrix, whose columns begin `stride` numbers apart, at the entries of a list.
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
  std::vector<int> cluster_of_;  ///< by index
  std::vector<int> size_, members_in_group_, renamed_, touched_, degree_, order_, position_, merged_from_,
      node_columns_, first_member_, members_;
  std::vector<std::uint64_t> adjacent_;  ///< a bit for each pair of clusters
  // Nodes, in the order of elimination.
  std::vector<Node> nodes_;
  std::vector<List> groups_;
  std::vector<int> list_;    ///< ranks
  std::vector<int> source_;  ///< row and column of each rank in the matrix that is added
  std::vector<int> rank_;    ///< place in the order of elimination, by index
  std::vector<int> index_, node_of_, pivot_, local_;  ///< by rank
  std::vector<double> values_, product_, x_, below_;
};

}  // namespace axode
