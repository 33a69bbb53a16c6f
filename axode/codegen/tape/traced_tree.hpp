#pragma once
#include "axode/model/tree.hpp"

namespace axode::codegen {

/// The tree that is traced. It has the dynamics of the given tree, but more of its constants are 0 or 1.
/// Results differ from those of the given tree by rounding.
///
/// Entries of rotations, vectors and tensors that are rounding noise, 1e-15 of the largest entry beside them,
/// are set to 0 (or ±1 in a rotation). Inertia of a body that does not depend on the joint coordinate is
/// moved to the predecessor, and removed at the ground: for a hinge the inertia that is symmetric about its
/// axis, for a prismatic joint the whole of Θ, for a spherical joint a mass in its centre. For hinges, the
/// minimal inertial parameters of identification remain.
///
/// Only kernels that read Tree::B and Tree::M can run on it; their copies for sweeps over several bodies are
/// empty.
Tree<double> traced_tree(const Tree<double>& tree);

}  // namespace axode::codegen
