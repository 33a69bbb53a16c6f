#include "axode/constraints/assembly.hpp"
#include "tests/constraints/mechanisms.hpp"
#include "tests/integration/motions.hpp"
#include "tests/model/random_mechanism.hpp"

/// For mechanisms with loops the steps conserve the symplectic form on the closed states (q, p).
namespace axode::test {
namespace {

using Eigen::MatrixXd;

/// A mechanism in motion, away from the configuration in which it is drawn.
struct MovingMechanism {
  Model model;
  AssemblyResult at;

  MovingMechanism(const Description& description, Random<double>& random)
      : model(ModelBuilder(description).build()), at([&] {
          const Numbers away = random_numbers(random, model.nv(), 0.1);
          return assemble(model, integrate(model, neutral(model), away), random_numbers(random, model.nv()));
        }()) {}
};
/// A mechanism of five bodies with a loop at the last one, which is closed in the drawn configuration.
Description random_loop_of_five(Random<double>& random) {
  constexpr std::array joints{JointKind::revolute, JointKind::universal, JointKind::spherical,
                              JointKind::prismatic, JointKind::planar};
  constexpr std::array loops{LoopKind::spherical, LoopKind::rod, LoopKind::universal, LoopKind::revolute,
                             LoopKind::planar};
  Description d = random_tree(random, 5, joints);
  const auto kind = loops[static_cast<std::size_t>(random.number(0, static_cast<double>(loops.size())))];
  d.loops.push_back({.between = {"b4", random.number(0, 1) < 0.5 ? "ground" : "b0"},
                     .kind = kind,
                     .axis = random.direction(),
                     .second_axis = random.direction(),
                     .point = random.vector(),
                     .points = {random.vector(), random.vector()}});
  return d;
}

/// The symplectic form dqᵀ dp' - dq'ᵀ dp + p [dq, dq'] for all pairs of columns (dq, dp) of Z.
MatrixXd form(const ConfigurationGroup<double>& group, const Numbers& p, const MatrixXd& Z) {
  const auto nv = static_cast<Eigen::Index>(p.size());
  const MatrixXd dq = Z.topRows(nv), dp = Z.bottomRows(nv);
  MatrixXd turning(nv, Z.cols());
  for (Eigen::Index k = 0; k < Z.cols(); ++k)
    group.ad_transpose(dq.col(k).data(), p.data(), turning.col(k).data());
  return dq.transpose() * dp - dp.transpose() * dq - dq.transpose() * turning;
}

/// The largest change of the form in one step, relative to its largest entry, for tangents at closed states.
/// A tangent is a difference of two states that were displaced along a coordinate or a velocity and closed
/// again; after the step it is the difference of their successors.
template <class Run> double form_error(const MovingMechanism& mechanism, const Run& run) {
  const Model& model = mechanism.model;
  const ConfigurationGroup<double> group(model.tree<double>());
  Workspace<> workspace(model);
  const auto nv = static_cast<Eigen::Index>(model.nv());
  struct Point {
    Numbers q, p;
  };
  const auto point = [&](Span q, Span v) {
    Numbers p(v.size());
    momenta(model, workspace, q, v, p);
    return Point{{q.begin(), q.end()}, p};
  };
  const auto ends_of_step = [&](const AssemblyResult& at) {
    const Trajectory motion = run(at.q, at.v);
    EXPECT_TRUE(motion.complete) << motion.stop_reason;
    return std::array{point(at.q, at.v), point(last_q(motion), last_v(motion))};
  };
  const std::array own = ends_of_step(mechanism.at);
  constexpr double e = 1e-3;
  MatrixXd Z(4 * nv, 2 * nv);  // the tangents at both ends of the step
  for (Eigen::Index k = 0; k < 2 * nv; ++k) {
    const auto moved = [&](double by) {
      Numbers x(mechanism.at.v.size()), v = mechanism.at.v;
      (k < nv ? x : v)[static_cast<std::size_t>(k % nv)] += by;
      const std::array ends = ends_of_step(assemble(model, integrate(model, mechanism.at.q, x), v));
      Eigen::VectorXd z(4 * nv);
      for (std::size_t end = 0; end < 2; ++end) {
        auto part = z.segment(static_cast<Eigen::Index>(end) * 2 * nv, 2 * nv);
        group.difference(own[end].q.data(), ends[end].q.data(), part.data());
        part.tail(nv) = Eigen::Map<const Eigen::VectorXd>(ends[end].p.data(), nv);
      }
      return z;
    };
    Z.col(k) = (8 * (moved(e) - moved(-e)) - (moved(2 * e) - moved(-2 * e))) / (12 * e);
  }
  const MatrixXd before = form(group, own[0].p, Z.topRows(2 * nv)),
                 after = form(group, own[1].p, Z.bottomRows(2 * nv));
  return (after - before).cwiseAbs().maxCoeff() / before.cwiseAbs().maxCoeff();
}

void expect_the_form_kept(const MovingMechanism& mechanism, double tolerance) {
  constexpr double h = 0.02;
  const auto error = [&](const auto& run) {
    return form_error(mechanism, [&](Span q, Span v) { return run(mechanism.model, q, v); });
  };
  for (const int order : {2, 4}) {
    SCOPED_TRACE(order);
    for (const LocalCoordinates coordinates : both_local_coordinates)
      EXPECT_LT(error([&](const Model& m, Span q, Span v) {
                  return simulate_symplectic(m, q, v, h, h, order, with(coordinates));
                }),
                tolerance);
    for (const Coordinates kind : {Coordinates::absolute, Coordinates::absolute_SO3xR3}) {
      SimulationOptions options;
      options.coordinates = kind;
      EXPECT_LT(error([&](const Model& m, Span q, Span v) {
                  return simulate_rattle(m, q, v, h, h, order, options);
                }),
                tolerance);
    }
  }
  EXPECT_GT(
      error([&](const Model& m, Span q, Span v) { return simulate_fixed(m, q, v, h, h, runge_kutta(2)); }),
      10 * tolerance)
      << "which is not symplectic";
}

TEST(SymplecticSteps, KeepTheFormOnClosedConfigurations) {
  int seen = 0;
  for_seeds(12, [&](std::uint64_t seed) {
    Random<double> random(seed);
    const MovingMechanism mechanism(random_loop_of_five(random), random);
    if (mechanism.at.status != AssemblyStatus::closed) return;
    ++seen;
    expect_the_form_kept(mechanism, 1e-10);
  });
  EXPECT_GT(seen, 6);
}

/// Bricard's ring has a larger bound, because its loop closes less exactly with its redundant row.
TEST(SymplecticSteps, KeepTheFormOnRingsAndManyLoops) {
  for (const auto& [description, tolerance] :
       {std::pair{four_bar(), 1e-10}, {bricard(), 1e-8}, {gough(), 1e-10}}) {
    SCOPED_TRACE(description.name);
    Random<double> random(3);
    expect_the_form_kept(MovingMechanism(description, random), tolerance);
  }
}

}  // namespace
}  // namespace axode::test
