// Every case below must not compile, for the reason that is stated after `expect:`, and all that stands
// outside of them must. must_not_compile.py compiles the file with none of them, and with each.
#include "axode/axode.hpp"
#include "axode/dynamics/generic_dynamics.hpp"
#include "axode/scalar/dual.hpp"
#include "axode/table/words.hpp"

using namespace axode;

template <class Rep> struct Quantities {
  Twist<Rep> V;
  TwistRate<Rep> dV;
  Wrench<Rep> W;
  Momentum<Rep> Pi;
};

void mix(Quantities<Spatial> s, Quantities<Hybrid> h, Quantities<Mixed> m, Quantities<BodyFixed> b) {
  h.W = h.W + h.W, b.V = b.V + b.V, s.W = s.W - s.W, m.V = Twist<Mixed>{};
  static_cast<void>((s.W | s.V) + (h.W | h.V));
#ifdef add_momentum_to_wrench  // expect: do not add to one another
  h.W + h.Pi;
#endif
#ifdef add_twist_rate_to_twist  // expect: do not add to one another
  b.V + b.dV;
#endif
#ifdef add_twist_to_wrench  // expect: do not add to one another
  s.W + s.V;
#endif
#ifdef add_twists_of_two_representations  // expect: bring one into that of the other with change<To>(C, x)
  s.V + h.V;
#endif
#ifdef subtract_wrenches_of_two_representations  // expect: bring one into that of the other with change<To>(C, x)
  b.W - m.W;
#endif
#ifdef assign_twist_of_another_representation  // expect: no match for or no viable or conversion from
  m.V = b.V;
#endif
#ifdef pair_wrench_with_twist_of_another_representation  // expect: no match for or invalid operands
  s.W | b.V;
#endif
#ifdef pair_wrench_with_twist_rate  // expect: no match for or invalid operands
  s.W | s.dV;
#endif
#ifdef twist_of_something_else  // expect: a twist is BodyFixed, Spatial, Hybrid, Mixed or InFrames
  Twist<int> V;
#endif
}

using D = Dual<double, 2>;

void fill(const Model& model, Workspace<>& workspace, std::span<const double> q, std::span<Twist<Hybrid>> J) {
  jacobian<Hybrid>(model, workspace, q, 1, J);
#ifdef jacobian_without_representation  // expect: RecursionRepresentation
  jacobian<Fast>(model, workspace, q, 1, J);
#endif
}

void fill(const Model& model, std::span<const D> q, std::span<D> tau) {
  GenericDynamics<D>(model).inverse_dynamics(q, q, q, tau);
#ifdef workspace_of_dual_numbers  // expect: GenericDynamics
  Workspace<D> workspace(model);
  inverse_dynamics(model, workspace, q, q, q, tau);
#endif
}

constexpr catalog::Counts decided{.loops = catalog::counted,
                                  .passive_joints = catalog::counted,
                                  .springs = catalog::counted,
                                  .joint_losses = catalog::optional,
                                  .motions = catalog::refused("simulate counts them"),
                                  .drives = catalog::of_the_tree(),
                                  .plays = catalog::of_the_tree(),
                                  .contacts = catalog::of_the_tree()};
#ifdef row_that_leaves_out_a_count  // expect: to 'axode::catalog::Count' or of 'axode::catalog::Count'
constexpr catalog::Counts undecided{.loops = catalog::counted,
                                    .passive_joints = catalog::counted,
                                    .springs = catalog::counted,
                                    .joint_losses = catalog::optional,
                                    .motions = catalog::refused("simulate counts them"),
                                    .drives = catalog::of_the_tree(),
                                    .plays = catalog::of_the_tree()};
#endif
#ifdef refusal_without_a_sentence  // expect: a refusal says what to call instead
constexpr catalog::Count bare{catalog::Word::refused};
#endif
