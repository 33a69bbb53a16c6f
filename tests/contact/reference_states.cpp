
#include "axode/dynamics/mass_matrix/mass_matrix.hpp"
#include "tests/contact/reference_contacts.hpp"

/// The velocity problems of every file of contacts: rows, impulses, velocities and derivatives.
namespace axode::test {
namespace {

using Matrix = Eigen::MatrixXd;

Matrix matrix(const Json& rows) {
  const std::vector<double> x = numbers(rows);
  const auto n = static_cast<Eigen::Index>(rows.size());
  if (n == 0) return {};
  const auto m = static_cast<Eigen::Index>(x.size()) / n;
  return Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(x.data(), n,
                                                                                                  m);
}

class ContactStates : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    if (GetParam() == no_case) GTEST_SKIP() << missing(contact_folder(), "AXODE_VECTORS");
  }
  /// check(dynamics, state, status) for every state of the file, solved.
  template <class Check> void each_state(const Check& check) const {
    const ReferenceContacts reference(GetParam());
    const Model model = reference.build();
    ContactDynamics dynamics(model, reference.contact_rows());
    for (const Json& state : reference.file.at("states")) {
      SCOPED_TRACE(state.at("name").text());
      const std::vector<Contact> contacts = reference.contacts(model, state);
      const ContactStatus status =
          dynamics.solve(numbers(state.at("q")), numbers(state.at("v")), numbers(state.at("tau")), contacts,
                         {.h = number(state.at("h")), .threshold = reference.threshold});
      ASSERT_TRUE(status.mass_matrix.ok());
      check(dynamics, state, status, contacts);
    }
  }
};
INSTANTIATE_TEST_SUITE_P(Vectors, ContactStates, testing::ValuesIn(contact_cases()), case_name);

TEST_P(ContactStates, HaveTheRowsAndTheMassMatrix) {
  Comparison J("J", 1e-12), G("delassus", 1e-12), M("mass matrix", 1e-12), r("r", 1e-11);
  each_state([&](ContactDynamics& dynamics, const Json& state, const ContactStatus&,
                 const std::vector<Contact>& contacts) {
    ContactSystem& system = dynamics.system();
    const int m = system.problem().rows(), nv = system.model().nv();
    Matrix rows(nv, m);
    system.write(rows.data());
    J.expect_equal(Matrix(rows.transpose()), matrix(state.at("J")));
    Matrix delassus(m, m);
    system.problem().delassus(delassus);
    const Eigen::Map<const Eigen::VectorXd> c(system.problem().c.data(), m);
    Matrix scaled = c.asDiagonal() * matrix(state.at("delassus")) * c.asDiagonal();
    G.expect_equal(delassus, scaled);
    Matrix momenta(nv, nv);
    for (int k = 0; k < nv; ++k) {
      const Eigen::VectorXd unit = Eigen::VectorXd::Unit(nv, k);
      system.momenta(unit.data(), momenta.col(k).data());
    }
    M.expect_equal(momenta, matrix(state.at("mass_matrix")));
    r.expect_equal(to_vector(dynamics.r()), numbers(state.at("r")), 1e-2);
    for (std::size_t k = 0; k < contacts.size(); ++k) {
      const Json& contact = state.at("contacts").at(k);
      const ContactFrame frame = contact_frame(contacts[k].normal);
      EXPECT_LE(norm(frame.t1 - vec3(contact.at("tangents").at(0))), 1e-14);
      EXPECT_LE(norm(frame.t2 - vec3(contact.at("tangents").at(1))), 1e-14);
      EXPECT_EQ(dynamics.bounces()[k] != 0, contact.at("bounces").text() == "true");
    }
  });
}

TEST_P(ContactStates, ObeyTheLawWithTheVelocitiesOfTheFile) {
  Comparison free("free velocity", 1e-11), after("velocity after", 1e-11), u("contact velocity", 1e-11),
      p("generalized impulse", 1e-11), impulses("impulses", 1e-10), wrench("wrench on ground", 1e-10);
  each_state([&](ContactDynamics& dynamics, const Json& state, const ContactStatus& status,
                 const std::vector<Contact>&) {
    EXPECT_LE(status.solution.certificate, 1e-12);
    const bool unique = state.at("impulses_unique").text() == "true";
    const std::vector<double> v = numbers(state.at("velocity_after")),
                              v_0 = numbers(state.at("free_velocity"));
    const double size = 1e-3 + largest(v) + largest(v_0);
    free.expect_equal(to_vector(dynamics.free_velocity()), v_0, size);
    after.expect_equal(to_vector(dynamics.velocity()), v, size);
    u.expect_equal(to_vector(dynamics.contact_velocity()), numbers(state.at("contact_velocity_after")), size);
    p.expect_equal(to_vector(dynamics.generalized_impulse()), numbers(state.at("generalized_impulse")), 1e-3);
    bool floating = true;
    const Model& model = dynamics.system().model();
    for (int i = 1; i <= model.n_bodies(); ++i)
      if (model.body(i).predecessor == 0 && model.joint(i).kind != Subgroup::free) floating = false;
    if (unique || floating)
      wrench.expect_equal(dynamics.on_ground(), Wrench<Spatial>(from_eigen<Wrench<Spatial>>(Eigen::VectorXd(
                                                    matrix(state.at("wrench_on_ground")).reshaped()))));
    if (!unique) return;
    impulses.expect_equal(to_vector(dynamics.impulses()), numbers(state.at("impulses")));
    for (std::size_t k = 0; k < dynamics.branches().size(); ++k) {
      const std::string expected = state.at("contacts").at(k).at("status").text();
      const LawBranch branch = dynamics.branches()[k];
      EXPECT_EQ(branch == LawBranch::open    ? "open"
                : branch == LawBranch::stick ? "stick"
                                             : "slide",
                expected);
    }
  });
}

TEST_P(ContactStates, HaveTheCertificateOfTheImpulsesOfTheFile) {
  each_state(
      [&](ContactDynamics& dynamics, const Json& state, const ContactStatus&, const std::vector<Contact>&) {
        const VelocityProblem& problem = dynamics.system().problem();
        std::vector<double> lambda = numbers(state.at("impulses")),
                            scratch(2 * lambda.size() + static_cast<std::size_t>(problem.nv()));
        for (std::size_t k = 0; k < lambda.size(); ++k)
          lambda[k] = problem.c[k] > 0 ? lambda[k] / problem.c[k] : 0;
        EXPECT_LE(certificate(problem, lambda.data(), scratch.data()), 1e-13);  // by our own rows
      });
}

/// The figures that the schema gives for impulses of 0 and of 0.9 times those of the file.
TEST(Certificate, MeasuresHowFarImpulsesAreFromTheLaw) {
  struct Figure {
    const char *file, *state;
    double at_0, at_09;
  };
  int compared = 0;
  for (const auto& [file, name, at_0, at_09] :
       {Figure{"ball_drills", "drills and slides", 0.0165653273560, 0.00163760312114},
        Figure{"four_bar", "rubs", 0.147534387775, 0.0128955364341},
        Figure{"two_boxes", "upper falls", 1.34219056019, 0.0572956543768}}) {
    if (!std::filesystem::exists(contact_folder() / (std::string(file) + ".json")))
      GTEST_SKIP() << missing(contact_folder(), "AXODE_VECTORS");
    const ReferenceContacts reference(file);
    const Model model = reference.build();
    ContactDynamics dynamics(model, reference.contact_rows());
    for (const Json& state : reference.file.at("states")) {
      if (state.at("name").text() != name) continue;
      ASSERT_TRUE(dynamics
                      .solve(numbers(state.at("q")), numbers(state.at("v")), numbers(state.at("tau")),
                             reference.contacts(model, state),
                             {.h = number(state.at("h")), .threshold = reference.threshold})
                      .holds());
      const VelocityProblem& problem = dynamics.system().problem();
      const std::vector<double> lambda = numbers(state.at("impulses"));
      for (const auto& [part, expected] : {std::pair{0.0, at_0}, std::pair{0.9, at_09}}) {
        std::vector<double> x(lambda.size()), scratch(2 * x.size() + static_cast<std::size_t>(problem.nv()));
        for (std::size_t k = 0; k < x.size(); ++k)
          x[k] = problem.c[k] > 0 ? part * lambda[k] / problem.c[k] : 0;
        EXPECT_NEAR(certificate(problem, x.data(), scratch.data()), expected, 1e-11 * expected) << file;
        ++compared;
      }
    }
  }
  EXPECT_EQ(compared, 6);
}

TEST_P(ContactStates, HaveTheDerivativeByDriveForces) {
  int compared = 0;
  each_state(
      [&](ContactDynamics& dynamics, const Json& state, const ContactStatus&, const std::vector<Contact>&) {
        if (!state.contains("derivative_by_tau")) return;
        ++compared;
        const Matrix expected = matrix(state.at("derivative_by_tau"));
        const double size =
            number(state.at("h")) * matrix(state.at("mass_matrix")).inverse().cwiseAbs().maxCoeff();
        const Matrix found = dynamics.derivative_by_tau();
        EXPECT_LE((found - expected).cwiseAbs().maxCoeff(), 1e-8 * size);
      });
  if (compared == 0) GTEST_SKIP() << "no state has a derivative";
}

}  // namespace
}  // namespace axode::test
