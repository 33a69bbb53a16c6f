#include "axode/model/velocity_parents.hpp"

#include <algorithm>
#include <utility>

namespace axode {
namespace {

int n_columns(const Tree<double>& tree, int i) { return tree.first_screw[i + 1] - tree.first_screw[i]; }

std::vector<int> along_the_paths(const Tree<double>& tree) {
  std::vector<int> parent(static_cast<std::size_t>(tree.nv));
  for (int i = 1; i <= tree.n; ++i) {
    const int p = tree.parent[i];
    for (int k = 0; k < n_columns(tree, i); ++k)
      parent[tree.iv[i] + k] = k > 0 ? tree.iv[i] + k - 1 : p > 0 ? tree.iv[p] + n_columns(tree, p) - 1 : -1;
  }
  return parent;
}

/// For each velocity the later ones with which it shares an entry of M: velocities of joints on one path.
std::vector<std::vector<int>> later_neighbours(const Tree<double>& tree) {
  std::vector<std::vector<int>> later(static_cast<std::size_t>(tree.nv));
  for (int i = 1; i <= tree.n; ++i)
    for (int k = 0; k < n_columns(tree, i); ++k)
      for (int j = i; j > 0; j = tree.parent[j])
        for (int l = 0; l < n_columns(tree, j); ++l) {
          const auto [first, last] = std::minmax({tree.iv[i] + k, tree.iv[j] + l});
          if (first != last) later[first].push_back(last);
        }
  return later;
}

}  // namespace

std::vector<int> velocity_parents(const Tree<double>& tree) {
  if (std::none_of(tree.coupled.begin(), tree.coupled.end(), [](char c) { return c != 0; }))
    return along_the_paths(tree);
  // Liu's algorithm: the root of every subtree that velocity c reaches becomes its child; paths are shortened
  // on the way.
  const std::vector<std::vector<int>> later = later_neighbours(tree);
  std::vector<int> parent(static_cast<std::size_t>(tree.nv), -1), root = parent;
  for (int c = tree.nv - 1; c >= 0; --c)
    for (int k : later[c]) {
      while (root[k] != -1 && root[k] != c) k = std::exchange(root[k], c);
      if (root[k] == -1) root[k] = parent[k] = c;
    }
  return parent;
}

}  // namespace axode
