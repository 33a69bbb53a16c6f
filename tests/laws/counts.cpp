#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cstring>
#include <map>

#include "axode/constraints.hpp"
#include "axode/derivatives.hpp"
#include "axode/dynamics.hpp"
#include "axode/eigen.hpp"
#include "axode/table/check_counts.hpp"
#include "tests/laws/law.hpp"
#include "tests/support/functions.hpp"
#include "tests/support/random_loops.hpp"

/// What the rows of the table say that they count, on mechanisms with loops of all kinds, redundant loops,
/// passive joints, springs and friction. A function gives the answer of the whole mechanism, or that of the
/// cut tree where the row says so, or it refuses.
namespace axode::test {
namespace {

using catalog::Function, catalog::Input, catalog::Word;
using Row = Function<double>;
using Numbers = std::vector<double>;

bool same_bits(const Numbers& x, const Numbers& y) {
  return x.size() == y.size() &&
         (x.empty() || std::memcmp(x.data(), y.data(), x.size() * sizeof(double)) == 0);
}
std::string refusal_of(const auto& call) {
  try {
    call();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

/// A mechanism with loops that move, springs, losses and passive joints, at a closed state, and other
/// mechanisms without some of that.
class Whole {
 public:
  explicit Whole(std::uint64_t seed)
      : random_(seed),
        closed_(closed_mechanism(random_, {.most_bodies = 8, .springs = true, .friction = true})),
        model(closed_.model),
        arguments(model, random_) {
    arguments.q = closed_.state.q, arguments.v = closed_.state.v, arguments.a = closed_.state.a;
    arguments.tau = closed_.tau;
    arguments.wrenches = closed_.state.wrenches;
    arguments.joint_losses = false;  // no drive can make up for the losses of passive joints
    Workspace<> scratch(model);
    momenta(model, scratch, arguments.q, arguments.v, arguments.p);
  }

  /// The mechanism after a change of its description.
  template <class Change> Model with(const Change& change) const {
    Description d = closed_.description;
    change(d);
    return ModelBuilder(d).build();
  }
  Model cut() const {
    return with([](Description& d) { d.loops.clear(), d.couplings.clear(); });
  }

 private:
  Random<double> random_;
  ClosedMechanism closed_;

 public:
  const Model& model;
  Arguments<double> arguments;
};

Numbers call(const Row& row, const Model& model, Workspace<>& workspace,
             const catalog::Arguments<double>& given) {
  Numbers out(row.size(model, given.loads.wrenches.size()));
  static_cast<void>(row.call(model, workspace, given, out));
  return out;
}

/// Calls law(whole, row, representation) for every row in every representation.
template <class F> void for_rows(int seeds, const F& law) {
  for_seeds(seeds, [&](std::uint64_t seed) {
    Whole whole(seed);
    for (const Case& c : cases_with_fast())
      if (!c.single)
        for (const Row& row : functions_of<double>(c)) {
          SCOPED_TRACE(row.name);
          law(whole, row, c);
        }
  });
}

TEST(WhatFunctionsCount, EveryRowHasACallAndViceVersa) {
  const auto rows = catalog::functions<BodyFixed>();
  ASSERT_EQ(rows.size(), catalog::functions_of_state.size());
  for (std::size_t k = 0; k < rows.size(); ++k) EXPECT_EQ(rows[k].name, catalog::functions_of_state[k].name);
}

/// With a workspace for the tree alone, a function answers for the cut tree if its row says so. Otherwise it
/// refuses in the words of its row.
TEST(WhatFunctionsCount, AWorkspaceKnowsTheTree) {
  std::map<Word, int> seen;
  for_rows(10, [&](const Whole& whole, const Row& row, const Case&) {
    const Model cut = whole.cut();
    Workspace<> workspace(whole.model), for_cut_tree(whole.model, cut_tree), of_cut(cut);
    const catalog::Arguments<double> given = whole.arguments.given();
    const Numbers expected = call(row, cut, of_cut, given);
    EXPECT_TRUE(same_bits(call(row, whole.model, for_cut_tree, given), expected)) << "for the cut tree";
    const Word word = row.counts.loops.word;
    ++seen[word];
    if (word == Word::of_the_tree) {
      EXPECT_TRUE(same_bits(call(row, whole.model, workspace, given), expected));
      return;
    }
    const std::string refusal = refusal_of([&] { call(row, whole.model, workspace, given); });
    EXPECT_NE(refusal.find(std::string(row.name) + " does not count loops"), std::string::npos) << refusal;
    EXPECT_NE(
        refusal.find(word == Word::refused ? std::string(row.counts.loops.sentence) : "with a LoopWorkspace"),
        std::string::npos)
        << refusal;
  });
  EXPECT_GT(seen[Word::of_the_tree], 0);
  EXPECT_GT(seen[Word::counted], 0);
  EXPECT_GT(seen[Word::refused], 0);
}

/// Joints that neither follow others nor have another number of velocities than one.
std::vector<std::string> joints_of_one_velocity(const Description& d) {
  std::vector<std::string> names;
  for (const BodyDescription& body : d.bodies)
    if (body.joint.dof.size() == 1 && !body.joint.coupling) names.push_back(body.joint.name);
  return names;
}

/// If a function answers for the mechanism without some property, its results do not change when that
/// property is taken away or added.
TEST(WhatFunctionsCount, OtherPropertiesChangeNothingThatIsOfTheTree) {
  struct Property {
    catalog::Count catalog::Counts::*count;
    void (*change)(Description&);
  };
  const Property properties[]{
      {&catalog::Counts::springs,
       [](Description& d) {
         d.springs.clear();
         for (BodyDescription& body : d.bodies)
           for (Dof& dof : body.joint.dof) dof.stiffness = dof.stop_stiffness = 0;
       }},
      {&catalog::Counts::passive_joints,
       [](Description& d) {
         for (BodyDescription& body : d.bodies) body.joint.passive = false;
       }},
      {&catalog::Counts::joint_losses,
       [](Description& d) {
         for (BodyDescription& body : d.bodies)
           for (Dof& dof : body.joint.dof) dof.damping = dof.friction = 0;
       }},
      {&catalog::Counts::drives,
       [](Description& d) {
         for (const std::string& joint : joints_of_one_velocity(d))
           d.drives.push_back(
               {.joints = {{joint, 1.0}},
                .parameters = {{"resistance", 2}, {"inductance", 0.01}, {"torque_constant", 0.1}},
                .input = {.values = {5}}});
       }},
      {&catalog::Counts::plays,
       [](Description& d) {
         const std::vector<std::string> joints = joints_of_one_velocity(d);
         for (std::size_t k = 1; k < joints.size(); ++k)
           d.couplings.push_back({.terms = {{joints[k - 1], 1.0}, {joints[k], -2.0}}, .play = 0.1});
       }},
      {&catalog::Counts::contacts, [](Description& d) {
         const ShapeDescription ball{
             .role = ShapeDescription::Role::collision, .kind = ShapeKind::sphere, .radius = 10};
         for (BodyDescription& body : d.bodies) {
           body.shapes.push_back(ball);
           const std::vector<Dof>& dof = body.joint.dof;
           if (dof.size() != 1 || body.joint.coupling) continue;
           if (dof[0].stop_stiffness > 0) continue;
           body.joint.dof[0].lower = -1;
           body.joint.dof[0].upper = 1;
           body.joint.dof[0].hard_stops = true;
         }
       }}};
  for_rows(5, [&](const Whole& whole, const Row& row, const Case&) {
    for (const Property& property : properties) {
      const Model without = whole.with(property.change);
      Workspace<> one(whole.model, cut_tree), other(without, cut_tree);
      const Word word = (row.counts.*property.count).word;
      if (word != Word::of_the_tree) continue;
      catalog::Arguments<double> given = whole.arguments.given();
      given.loads.joint_losses = true;
      EXPECT_TRUE(same_bits(call(row, whole.model, one, given), call(row, without, other, given)));
    }
  });
}

/// A function counts losses of gears or refuses them, or is of the mechanism without losses.
TEST(WhatFunctionsCount, LossesOfGearsAreCountedOrRefused) {
  std::map<Word, int> seen;
  for_rows(5, [&](const Whole& whole, const Row& row, const Case&) {
    const auto change = [&](double loss) {
      return whole.with([loss](Description& d) {
        d.springs.clear();
        for (BodyDescription& body : d.bodies) {
          JointDescription& joint = body.joint;
          for (Dof& dof : joint.dof) dof.stiffness = dof.stop_stiffness = dof.stop_damping = 0;
          if (has_one_velocity(joint.kind) && !joint.coupling && !joint.passive.value_or(false)) {
            joint.dof.resize(1);
            joint.dof[0].gear_loss = loss;
          }
        }
      });
    };
    const Model lossless = change(0), lossy = change(0.5);
    if (lossy.gears().empty()) return;
    Workspace<> workspace(lossy, cut_tree), other(lossless, cut_tree);
    catalog::Arguments<double> given = whole.arguments.given();
    const Numbers expected = call(row, lossless, other, given);
    EXPECT_TRUE(same_bits(call(row, lossy, workspace, given), expected)) << "without joint losses";
    given.loads.joint_losses = true;
    const Word word = row.counts.joint_losses.word;
    ++seen[word];
    if (word == Word::of_the_tree) {
      EXPECT_TRUE(same_bits(call(row, lossy, workspace, given), expected));
    } else if (word == Word::partly) {
      const std::string refused = refusal_of([&] { call(row, lossy, workspace, given); });
      EXPECT_NE(refused.find("loses a part of the force that it transmits"), std::string::npos) << refused;
    } else {
      EXPECT_EQ(word, Word::optional);
      EXPECT_EQ(call(row, lossy, workspace, given).size(), expected.size());
    }
  });
  EXPECT_GT(seen[Word::of_the_tree], 0);
  EXPECT_GT(seen[Word::optional], 0);
  EXPECT_GT(seen[Word::partly], 0);
}

/// A function refuses a mechanism with prescribed motions in
/// the words of its row, or is of the mechanism without them.
TEST(WhatFunctionsCount, PrescribedMotionsAreRefusedOrIgnored) {
  std::map<Word, int> seen;
  for_rows(5, [&](const Whole& whole, const Row& row, const Case&) {
    const auto prescribe = [&](Description& d) {
      const std::span<const Joint> joints = whole.model.joints();
      const auto joint = std::ranges::find_if(joints, [](const Joint& j) { return j.dof.size() == 1; });
      if (joint != joints.end()) d.motions.push_back({.of = joint->name, .coefficients = {0, 1}});
    };
    const Model without = whole.cut(), moved = whole.with([&](Description&d) {
      d.loops.clear(), d.couplings.clear();
      prescribe(d);
    });
    if (moved.motions().empty()) return;
    Workspace<> workspace(moved), for_cut_tree(moved, cut_tree), of_cut(without);
    const catalog::Arguments<double> given = whole.arguments.given();
    const Numbers expected = call(row, without, of_cut, given);
    EXPECT_TRUE(same_bits(call(row, moved, for_cut_tree, given), expected));
    const auto& [word, sentence] = row.counts.motions;
    ++seen[word];
    if (word == Word::of_the_tree) {
      EXPECT_TRUE(same_bits(call(row, moved, workspace, given), expected));
      return;
    }
    const std::string refusal = std::string(row.name) + " does not count prescribed motions, and model";
    EXPECT_EQ(refusal_of([&] { call(row, moved, workspace, given); }).find(refusal), 0U);
    if (row.call_with_loops == nullptr) return;
    const Model with_loops = whole.with(prescribe);
    LoopWorkspace<> loops(with_loops);
    Numbers out(row.size(with_loops, given.loads.wrenches.size()));
    const std::string refused =
        refusal_of([&] { static_cast<void>(row.call_with_loops(with_loops, loops, given, out)); });
    EXPECT_NE(refused.find("does not count prescribed motions"), std::string::npos) << refused;
    EXPECT_NE(refused.find(std::string(sentence)), std::string::npos) << refused;
  });
  EXPECT_GT(seen[Word::of_the_tree], 0);
  EXPECT_GT(seen[Word::refused], 0);
}

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;
using RowByRow = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// The cut tree of the mechanism and the directions in which its loops let it move.
struct Reference {
  const Model& model;
  const catalog::Arguments<double> given;
  Workspace<> tree;
  LoopWorkspace<> loops;
  Matrix A, N;  ///< loop_jacobian, and a basis of the v with A v = 0

  Reference(const Model& m, const catalog::Arguments<double>& at)
      : model(m), given(at), tree(m, cut_tree), loops(m), A(m.loops().rows, m.nv()) {
    RowByRow rows(A.rows(), A.cols());
    loop_jacobian<double>(m, loops, given.q, as_span(rows));
    A = rows;
    if (A.size() == 0) {
      N = Matrix::Identity(m.nv(), m.nv());
      return;
    }
    Eigen::FullPivLU<Matrix> lu(A);
    lu.setThreshold(1e-9);
    N = lu.dimensionOfKernel() > 0 ? Matrix(lu.kernel()) : Matrix(m.nv(), 0);
    for (Eigen::Index k = 0; k < N.cols(); ++k) N.col(k).normalize();
  }
  Vector forces(std::span<const double> a) {
    Vector tau(model.nv());
    inverse_dynamics(model, tree, given.q, given.v, a, as_span(tau), given.loads);
    return tau;
  }
  Matrix mass() {
    RowByRow M(model.nv(), model.nv());
    mass_matrix(model, tree, given.q, as_span(M));
    return M;
  }
};

double largest_of(const auto& x) { return x.size() == 0 ? 0 : x.cwiseAbs().maxCoeff(); }
template <class X> void expect_zero(const X& x, double scale, double tolerance = 1e-8) {
  EXPECT_LE(largest_of(x), tolerance * (scale + std::numeric_limits<double>::min()));
}

/// Checks results of functions that count loops against the equations of the cut tree with constraint
/// wrenches, and against differences along the motion.
class CountedLoops {
 public:
  CountedLoops(const Whole& whole, const Row& row, const Case& c)
      : whole_(whole), row_(row), case_(c), reference_(whole.model, whole.arguments.given()) {}

  /// Checks the results of the row. Returns false for a function that it has no check for.
  bool check() {
    const catalog::Arguments<double>& at = reference_.given;
    const Eigen::Index nv = whole_.model.nv();
    const Numbers out = call(at);
    const auto result = [&](Eigen::Index rows, Eigen::Index columns, std::size_t skip = 0) -> Matrix {
      return Eigen::Map<const RowByRow>(out.data() + skip, rows, columns);
    };
    if (row_.name == "inverse_dynamics") {
      const Vector tau = result(nv, 1), need = reference_.forces(at.a);
      expect_zero(reference_.N.transpose() * (need - tau), need.norm());
      for (Eigen::Index c = 0; c < nv; ++c)
        if (!whole_.model.loops().driven[static_cast<std::size_t>(c)]) {
          EXPECT_EQ(tau[c], 0);
        }
    } else if (row_.name == "forward_dynamics") {
      const Vector a = result(nv, 1);
      Vector gamma(reference_.A.rows());
      loop_bias<double>(whole_.model, reference_.loops, at.q, at.v, as_span(gamma));
      expect_zero(reference_.A * a + gamma, 1 + a.norm() + gamma.norm());
      const Vector left = reference_.forces(out) - as_eigen(at.tau);
      expect_zero(reference_.N.transpose() * left, left.norm() + as_eigen(at.tau).norm(), 1e-7);
    } else if (row_.name == "joint_wrenches") {
      return true;  // JointWrenchesOfClosedMechanisms tests these
    } else if (row_.name == "impulse_response" || row_.name == "inverse_operational_space_inertia" ||
               row_.name == "operational_space_inertia") {
      check_impulses(out, verdict_);
    } else if (row_.name == "forward_dynamics_derivatives" || row_.name == "forward_dynamics_jvp" ||
               row_.name == "forward_dynamics_vjp") {
      check_rate(out);
    } else {
      return false;
    }
    return true;
  }

 private:
  Numbers call(const catalog::Arguments<double>& given) { return call(row_, given); }
  Numbers call(const Row& row, const catalog::Arguments<double>& given) {
    Numbers out(row.size(whole_.model, given.loads.wrenches.size()));
    verdict_ = row.call_with_loops(whole_.model, reference_.loops, given, out);
    return out;
  }
  /// Checks that the impulse response Y fulfils A Y = 0 and Nᵀ (M Y - Jᵀ) = 0, and that the two other
  /// functions give the mobility J Y and its inverse.
  void check_impulses(const Numbers& out, const Solvability verdict) {
    const catalog::Arguments<double>& at = reference_.given;
    const Eigen::Index nv = whole_.model.nv();
    const auto row = [&](std::string_view name) -> const Row& {
      const auto rows = functions_of<double>(case_);
      return *std::ranges::find(rows, name, &Row::name);
    };
    const Numbers response = row_.name == "impulse_response" ? out : call(row("impulse_response"), at);
    Numbers columns(response.size());
    static_cast<void>(row("jacobian").call(whole_.model, reference_.tree, at, columns));
    const Matrix J = Eigen::Map<const Matrix>(columns.data(), 6, nv),
                 Y = Eigen::Map<const Matrix>(response.data(), 6, nv);
    const Matrix MY = reference_.mass() * Y.transpose();
    Numbers without_loops(response.size());
    static_cast<void>(row("impulse_response").call(whole_.model, reference_.tree, at, without_loops));
    const double size = largest_of(Eigen::Map<const Vector>(without_loops.data(), std::ssize(without_loops)));
    constexpr double of_rounding = 1e-12;  // the rows of a loop that holds nothing are rounding errors
    const double of_rows = largest_of(reference_.A);
    expect_zero(reference_.A * Y.transpose(), (of_rows > of_rounding ? of_rows : 1) * size);
    expect_zero(reference_.N.transpose() * (MY - J.transpose()), largest_of(MY) + largest_of(J));
    if (row_.name == "impulse_response") return;
    const Matrix JY = J * Y.transpose(), found = Eigen::Map<const RowByRow>(out.data(), 6, 6);
    if (row_.name == "inverse_operational_space_inertia")
      expect_zero(found - (JY + JY.transpose()) / 2, largest_of(JY), 1e-10);
    else if (verdict.ok())
      expect_zero(found * JY - Matrix::Identity(6, 6), largest_of(found) * largest_of(JY), 1e-9);
  }
  /// Checks the derivatives by differences of the accelerations along the motion under the drive forces τ + t
  /// τ̇.
  void check_rate(const Numbers& out) {
    const catalog::Arguments<double>& at = reference_.given;
    const Row& dynamics = *catalog::find<BodyFixed>("forward_dynamics");
    const std::size_t nv = at.v.size();
    const Numbers a = call(dynamics, at);
    Numbers rate_of_tau(nv);
    for (std::size_t c = 0; c < nv; ++c) rate_of_tau[c] = at.dtau[c];
    catalog::Arguments<double> along = at;
    along.dq = at.v, along.dv = a, along.dtau = rate_of_tau;
    const auto moved = [&](double t) {
      catalog::Arguments<double> later = at;
      Numbers step(nv), v(nv), tau(nv);
      for (std::size_t c = 0; c < nv; ++c) {
        step[c] = t * at.v[c] + t * t / 2 * a[c];
        v[c] = at.v[c] + t * a[c], tau[c] = at.tau[c] + t * rate_of_tau[c];
      }
      const Numbers q = integrate(whole_.model, at.q, step);
      later.q = q, later.v = v, later.tau = tau;
      return call(dynamics, later);
    };
    const double t = 1e-5;
    const Numbers after = moved(t), before = moved(-t);
    const Vector rate =
        (as_eigen(std::span<const double>(after)) - as_eigen(std::span<const double>(before))) / (2 * t);
    const Numbers result = row_.name == "forward_dynamics_jvp" ? call(along) : out;
    Vector found = Vector::Zero(static_cast<Eigen::Index>(nv));
    if (row_.name == "forward_dynamics_jvp") {
      found = as_eigen(std::span<const double>(result));
    } else {
      const std::array<std::span<const double>, 3> directions{along.dq, along.dv, along.dtau};
      if (row_.name == "forward_dynamics_vjp") {
        double product = 0;
        for (std::size_t k = 0; k < 3; ++k)
          for (std::size_t c = 0; c < nv; ++c) product += result[k * nv + c] * directions[k][c];
        const double expected = rate.dot(as_eigen(at.w));
        EXPECT_NEAR(product, expected, 1e-4 * (1 + rate.norm() * as_eigen(at.w).norm()));
        return;
      }
      for (std::size_t k = 0; k < 3; ++k)
        found += Eigen::Map<const RowByRow>(result.data() + k * nv * nv, static_cast<Eigen::Index>(nv),
                                            static_cast<Eigen::Index>(nv)) *
                 as_eigen(directions[k]);
    }
    expect_zero(found - rate, 1 + rate.norm() + found.norm(), 1e-4);
  }

  const Whole& whole_;
  const Row& row_;
  const Case& case_;
  Reference reference_;
  Solvability verdict_;
};

TEST(WhatFunctionsCount, CountedLoopsAreThoseOfTheMechanism) {
  for_rows(20, [&](const Whole& whole, const Row& row, const Case& c) {
    ASSERT_EQ(row.call_with_loops != nullptr, row.counts.loops.word == Word::counted);
    if (row.call_with_loops != nullptr) {
      EXPECT_TRUE(CountedLoops(whole, row, c).check()) << "no reference for this row";
    }
  });
}

}  // namespace
}  // namespace axode::test
